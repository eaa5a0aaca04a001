//! EN 1005-4:2005+A1:2008, working postures and movements at machines: zones by how often they occur.
//!
//! | part | static | below 2/min | 2/min or more |
//! |---|---|---|---|
//! | trunk 0-20 deg | acceptable | acceptable | acceptable |
//! | trunk 20-60 deg | conditional (support, short holds) | acceptable | not acceptable |
//! | trunk > 60 deg, backward | not acceptable | conditional | not acceptable |
//! | trunk twist, side bend > 10 deg | not acceptable | conditional | not acceptable |
//! | line of sight 0-40 deg below level | acceptable | acceptable | acceptable |
//! | line of sight above level or > 40 deg below | not acceptable | conditional | not acceptable |
//! | neck side bend > 10, twist > 45 deg | not acceptable | conditional | not acceptable |
//! | upper arm 0-20 deg | acceptable | acceptable | acceptable |
//! | upper arm 20-60 deg | conditional (support, short holds) | acceptable | conditional |
//! | upper arm > 60 deg | not acceptable | not acceptable | not acceptable |
//! | upper arm behind or across the body | not acceptable | conditional | not acceptable |
//!
//! With full support, static postures of 20-60 deg are acceptable. See [`EN_1005_4_PROVENANCE`] for
//! what was checked.

use super::angles::{ArmAngles, TrunkNeckAngles};
use super::zones::{PartZone, PostureZone, ZonePart, ZoneSettings, larger};
use serde::Serialize;

/// Where the zones were checked; for reports.
pub const EN_1005_4_PROVENANCE: &str = "EN 1005-4 zones, not verified against the standard itself: trunk twist and side bend, \
     line of sight, upper arm 0 to 60 and above 60 deg agree with the help text of commercial \
     simulation software; trunk inclination by frequency, neck twist of 45 deg, arms behind or \
     across the body and the static column are from memory. The standard may allow upper arms \
     above 60 deg for short use below 2/min; here they are not acceptable.";

/// Neck twist that is acceptable, deg.
const NECK_TWIST_DEG: f64 = 45.0;
/// Lowest acceptable line of sight below level, deg.
const SIGHT_DOWN_DEG: f64 = 40.0;

/// How often a posture occurs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PostureUse {
    /// Held.
    Static,
    /// Movement, less than twice a minute.
    Below2PerMin,
    /// Movement, twice a minute or more.
    From2PerMin,
}

impl PostureUse {
    /// Movement of a part that leaves the acceptable zone `departures` times a cycle (see
    /// [`super::PartTimes::departures`]). A rate that is not a number counts as frequent.
    pub fn of_movement(departures: usize, cycles_per_min: f64) -> Self {
        if (departures as f64 * cycles_per_min) < 2.0 {
            Self::Below2PerMin
        } else {
            Self::From2PerMin
        }
    }
}

/// Zones of one posture: trunk, trunk asymmetry, head (line of sight), neck asymmetry, upper arm.
///
/// The eyes look straight ahead of the head: the line of sight is as far below level as the head is
/// inclined, trunk inclination plus neck flexion. What is not a number is not acceptable.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{
///     ArmAngles, PostureUse, PostureZone, TrunkNeckAngles, ZoneSettings, en_1005_4,
/// };
/// let arm = ArmAngles { upper_arm_elevation_deg: 40.0, ..ArmAngles::default() };
/// let (body, settings) = (TrunkNeckAngles::default(), ZoneSettings::default());
/// let zone = |used| en_1005_4(&body, &arm, used, &settings)[4].zone;
/// assert_eq!(zone(PostureUse::Below2PerMin), PostureZone::Acceptable);
/// assert_eq!(zone(PostureUse::From2PerMin), PostureZone::Conditional);
/// ```
pub fn en_1005_4(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    used: PostureUse,
    settings: &ZoneSettings,
) -> [PartZone; 5] {
    let sight = body.trunk_flex_deg + body.neck_flex_deg;
    let trunk_bent = larger(body.trunk_twist_deg, body.trunk_side_deg);
    let (twist, side) = (body.neck_twist_deg, body.neck_side_deg);
    let neck_is_straight = twist.abs() <= NECK_TWIST_DEG && side.abs() <= settings.visible_deg;
    let trunk_is_straight = trunk_bent.abs() <= settings.visible_deg;
    let sees_well = (-settings.neutral_band_deg..=SIGHT_DOWN_DEG).contains(&sight);
    let at = |part, angle_deg, zone| PartZone { part, angle_deg, zone };
    [
        at(ZonePart::Trunk, body.trunk_flex_deg, trunk(body.trunk_flex_deg, used, settings)),
        at(ZonePart::TrunkAsymmetry, trunk_bent, seldom_unless(trunk_is_straight, used)),
        at(ZonePart::Head, sight, seldom_unless(sees_well, used)),
        at(ZonePart::NeckAsymmetry, larger(twist, side), seldom_unless(neck_is_straight, used)),
        at(ZonePart::UpperArm, arm.upper_arm_elevation_deg, upper_arm(arm, used, settings)),
    ]
}

/// Acceptable if so, otherwise only below 2/min, under conditions.
fn seldom_unless(is_acceptable: bool, used: PostureUse) -> PostureZone {
    match used {
        _ if is_acceptable => PostureZone::Acceptable,
        PostureUse::Below2PerMin => PostureZone::Conditional,
        PostureUse::Static | PostureUse::From2PerMin => PostureZone::NotRecommended,
    }
}

fn trunk(deg: f64, used: PostureUse, settings: &ZoneSettings) -> PostureZone {
    if (-settings.neutral_band_deg..=20.0).contains(&deg) {
        return PostureZone::Acceptable;
    }
    let is_between = deg > 20.0 && deg <= 60.0;
    match used {
        PostureUse::Static if settings.trunk_supported && deg <= 60.0 => PostureZone::Acceptable,
        PostureUse::Static if is_between => PostureZone::Conditional,
        PostureUse::Below2PerMin if is_between => PostureZone::Acceptable,
        _ => seldom_unless(false, used),
    }
}

fn upper_arm(arm: &ArmAngles, used: PostureUse, settings: &ZoneSettings) -> PostureZone {
    let (elevation, band) = (arm.upper_arm_elevation_deg, settings.neutral_band_deg);
    if arm.upper_arm_flex_deg < -band || arm.upper_arm_abduction_deg < -band {
        return seldom_unless(false, used);
    }
    if elevation <= 20.0 {
        PostureZone::Acceptable
    } else if elevation <= 60.0 {
        match used {
            PostureUse::Below2PerMin => PostureZone::Acceptable,
            PostureUse::Static if settings.arm_supported => PostureZone::Acceptable,
            PostureUse::Static | PostureUse::From2PerMin => PostureZone::Conditional,
        }
    } else {
        PostureZone::NotRecommended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USES: [PostureUse; 3] =
        [PostureUse::Static, PostureUse::Below2PerMin, PostureUse::From2PerMin];
    const A: PostureZone = PostureZone::Acceptable;
    const C: PostureZone = PostureZone::Conditional;
    const N: PostureZone = PostureZone::NotRecommended;

    /// The row of the table for one part.
    fn row(part: usize, edit: impl Fn(&mut TrunkNeckAngles, &mut ArmAngles)) -> [PostureZone; 3] {
        let (mut body, mut arm) = (TrunkNeckAngles::default(), ArmAngles::default());
        edit(&mut body, &mut arm);
        USES.map(|used| en_1005_4(&body, &arm, used, &ZoneSettings::default())[part].zone)
    }

    #[test]
    fn rows_of_the_table() {
        assert_eq!(row(0, |b, _| b.trunk_flex_deg = 15.0), [A, A, A]);
        assert_eq!(row(0, |b, _| b.trunk_flex_deg = 45.0), [C, A, N]);
        assert_eq!(row(0, |b, _| b.trunk_flex_deg = 65.0), [N, C, N]);
        assert_eq!(row(0, |b, _| b.trunk_flex_deg = -10.0), [N, C, N]);
        assert_eq!(row(1, |b, _| b.trunk_twist_deg = -10.0), [A, A, A]);
        assert_eq!(row(1, |b, _| b.trunk_twist_deg = -11.0), [N, C, N]);
        assert_eq!(row(2, |b, _| b.neck_flex_deg = 40.0), [A, A, A]);
        assert_eq!(row(2, |b, _| b.neck_flex_deg = 41.0), [N, C, N]);
        assert_eq!(row(2, |b, _| b.neck_flex_deg = -10.0), [N, C, N]);
        assert_eq!(row(3, |b, _| b.neck_twist_deg = 40.0), [A, A, A]);
        assert_eq!(row(3, |b, _| b.neck_twist_deg = 50.0), [N, C, N]);
        assert_eq!(row(3, |b, _| b.neck_side_deg = 15.0), [N, C, N]);
        assert_eq!(row(4, |_, a| a.upper_arm_elevation_deg = 20.0), [A, A, A]);
        assert_eq!(row(4, |_, a| a.upper_arm_elevation_deg = 40.0), [C, A, C]);
        assert_eq!(row(4, |_, a| a.upper_arm_elevation_deg = 70.0), [N, N, N]);
        assert_eq!(row(4, |_, a| a.upper_arm_flex_deg = -15.0), [N, C, N]);
    }

    #[test]
    fn support_makes_static_postures_acceptable() {
        let body = TrunkNeckAngles { trunk_flex_deg: 45.0, ..TrunkNeckAngles::default() };
        let arm = ArmAngles { upper_arm_elevation_deg: 45.0, ..ArmAngles::default() };
        let settings =
            ZoneSettings { trunk_supported: true, arm_supported: true, ..ZoneSettings::default() };
        let zones = en_1005_4(&body, &arm, PostureUse::Static, &settings);
        assert_eq!((zones[0].zone, zones[4].zone), (A, A));
    }

    #[test]
    fn frequency_comes_from_departures_and_cycles() {
        assert_eq!(PostureUse::of_movement(1, 1.9), PostureUse::Below2PerMin);
        assert_eq!(PostureUse::of_movement(2, 1.0), PostureUse::From2PerMin);
        assert_eq!(PostureUse::of_movement(0, 10.0), PostureUse::Below2PerMin);
        assert_eq!(PostureUse::of_movement(1, f64::NAN), PostureUse::From2PerMin);
    }

    #[test]
    fn what_is_not_a_number_is_never_acceptable() {
        let zones = row(0, |b, _| b.trunk_flex_deg = f64::NAN);
        assert!(!zones.contains(&A), "{zones:?}");
        assert_eq!(row(4, |_, a| a.upper_arm_elevation_deg = f64::NAN), [N, N, N]);
    }
}
