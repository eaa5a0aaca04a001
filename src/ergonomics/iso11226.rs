//! ISO 11226:2000, evaluation of static working postures: zones of trunk, head, neck and upper arm.
//!
//! | part | acceptable | up to a holding time | not recommended |
//! |---|---|---|---|
//! | trunk inclination | 0-20 deg | 20-60 deg: 4 min falling to 1 min | > 60 deg; backward without support |
//! | trunk twist, side bend | not visible | - | visible |
//! | head inclination | 0-25 deg | 25-85 deg: 8 min falling to 1 min | > 85 deg; backward without support |
//! | neck flexion (head to trunk) | 0-25 deg | - | backward; > 25 deg |
//! | neck twist, side bend | not visible | - | visible |
//! | upper arm elevation | 0-20 deg | 20-60 deg: 3 min falling to 1 min | > 60 deg; behind or across the body; raised shoulder |
//!
//! With full support of trunk, head or arm the zone with a holding time is acceptable. Not assessed:
//! rotation of the upper arm, elbow, forearm, wrist and legs, recovery between holds. See
//! [`ISO_11226_PROVENANCE`] for what was checked.

use super::angles::{ArmAngles, TrunkNeckAngles};
use super::zones::{PartZone, PostureZone, ZonePart, ZoneSettings, larger};

/// Where the zones were checked; for reports.
pub const ISO_11226_PROVENANCE: &str = "ISO 11226 zones, not verified against the standard itself: trunk, head and neck angles \
     agree with the limits printed in a peer-reviewed motion capture study (J Occup Med Toxicol \
     2020, article s12995-020-00286-9, table 2); upper arm angles with software help; the holding \
     times (linear: trunk 4 to 1 min, head 8 to 1 min, upper arm 3 to 1 min) agree with one public \
     program and are otherwise from memory, as is what full support allows.";

/// Zones of one posture: trunk, trunk asymmetry, head, neck, neck asymmetry, upper arm.
///
/// Head inclination is the sum of trunk inclination and neck flexion, which holds as long as trunk
/// and neck bend in one plane. What is not a number is not recommended.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{ArmAngles, PostureZone, TrunkNeckAngles, ZoneSettings, iso_11226};
/// let body = TrunkNeckAngles { trunk_flex_deg: 40.0, ..TrunkNeckAngles::default() };
/// let zones = iso_11226(&body, &ArmAngles::default(), &ZoneSettings::default());
/// assert_eq!(zones[0].zone, PostureZone::UpTo { holding_s: 150.0 });
/// ```
pub fn iso_11226(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    settings: &ZoneSettings,
) -> [PartZone; 6] {
    let head = body.trunk_flex_deg + body.neck_flex_deg;
    let trunk_bent = larger(body.trunk_twist_deg, body.trunk_side_deg);
    let neck_bent = larger(body.neck_twist_deg, body.neck_side_deg);
    let at = |part, angle_deg, zone| PartZone { part, angle_deg, zone };
    let incline = |deg, band, is_supported| inclination(deg, band, is_supported, settings);
    [
        at(
            ZonePart::Trunk,
            body.trunk_flex_deg,
            incline(body.trunk_flex_deg, &TRUNK, settings.trunk_supported),
        ),
        at(ZonePart::TrunkAsymmetry, trunk_bent, asymmetry(trunk_bent, settings)),
        at(ZonePart::Head, head, incline(head, &HEAD, settings.head_supported)),
        at(ZonePart::Neck, body.neck_flex_deg, neck(body.neck_flex_deg, settings)),
        at(ZonePart::NeckAsymmetry, neck_bent, asymmetry(neck_bent, settings)),
        at(ZonePart::UpperArm, arm.upper_arm_elevation_deg, upper_arm(arm, settings)),
    ]
}

/// A zone with a holding time: its ends (deg) and the holding times there (s).
struct Band {
    from_deg: f64,
    to_deg: f64,
    from_s: f64,
    to_s: f64,
}

const TRUNK: Band = Band { from_deg: 20.0, to_deg: 60.0, from_s: 240.0, to_s: 60.0 };
const HEAD: Band = Band { from_deg: 25.0, to_deg: 85.0, from_s: 480.0, to_s: 60.0 };
const UPPER_ARM: Band = Band { from_deg: 20.0, to_deg: 60.0, from_s: 180.0, to_s: 60.0 };

impl Band {
    /// The zone of an angle that is not below neutral.
    fn zone(&self, deg: f64, is_supported: bool) -> PostureZone {
        if deg <= self.from_deg || (is_supported && deg <= self.to_deg) {
            PostureZone::Acceptable
        } else if deg <= self.to_deg {
            let along = (deg - self.from_deg) / (self.to_deg - self.from_deg);
            PostureZone::UpTo { holding_s: self.from_s + along * (self.to_s - self.from_s) }
        } else {
            PostureZone::NotRecommended
        }
    }
}

fn inclination(deg: f64, band: &Band, is_supported: bool, settings: &ZoneSettings) -> PostureZone {
    if deg < -settings.neutral_band_deg && !is_supported {
        PostureZone::NotRecommended
    } else {
        band.zone(deg, is_supported)
    }
}

fn asymmetry(deg: f64, settings: &ZoneSettings) -> PostureZone {
    if deg.abs() <= settings.visible_deg {
        PostureZone::Acceptable
    } else {
        PostureZone::NotRecommended
    }
}

fn neck(deg: f64, settings: &ZoneSettings) -> PostureZone {
    if (-settings.neutral_band_deg..=25.0).contains(&deg) {
        PostureZone::Acceptable
    } else {
        PostureZone::NotRecommended
    }
}

fn upper_arm(arm: &ArmAngles, settings: &ZoneSettings) -> PostureZone {
    let band = settings.neutral_band_deg;
    let is_awkward = arm.upper_arm_flex_deg < -band
        || arm.upper_arm_abduction_deg < -band
        || arm.girdle_elevation_deg > settings.shoulder_raised_deg;
    if is_awkward {
        PostureZone::NotRecommended
    } else {
        UPPER_ARM.zone(arm.upper_arm_elevation_deg, settings.arm_supported)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::zone_times;

    fn zones(
        edit: impl Fn(&mut TrunkNeckAngles, &mut ArmAngles, &mut ZoneSettings),
    ) -> [PartZone; 6] {
        let (mut body, mut arm) = (TrunkNeckAngles::default(), ArmAngles::default());
        let mut settings = ZoneSettings::default();
        edit(&mut body, &mut arm, &mut settings);
        iso_11226(&body, &arm, &settings)
    }

    fn up(holding_s: f64) -> PostureZone {
        PostureZone::UpTo { holding_s }
    }

    #[test]
    fn upright_is_acceptable_in_all_parts() {
        assert!(zones(|_, _, _| ()).iter().all(|z| z.zone == PostureZone::Acceptable));
    }

    #[test]
    fn holding_times_fall_linearly_between_the_ends_of_the_zone() {
        let trunk = |deg: f64| zones(|b, _, _| b.trunk_flex_deg = deg)[0].zone;
        assert_eq!(
            [trunk(20.0), trunk(40.0), trunk(60.0)],
            [PostureZone::Acceptable, up(150.0), up(60.0)]
        );
        assert_eq!([trunk(60.1), trunk(-6.0)], [PostureZone::NotRecommended; 2]);
        assert_eq!(trunk(-4.0), PostureZone::Acceptable);
        let head = |deg: f64| zones(|b, _, _| b.neck_flex_deg = deg)[2].zone;
        assert_eq!(
            [head(25.0), head(55.0), head(85.0)],
            [PostureZone::Acceptable, up(270.0), up(60.0)]
        );
        let arm = |deg: f64| zones(|_, a, _| a.upper_arm_elevation_deg = deg)[5].zone;
        assert_eq!(
            [arm(20.0), arm(30.0), arm(60.0)],
            [PostureZone::Acceptable, up(150.0), up(60.0)]
        );
        assert_eq!(arm(61.0), PostureZone::NotRecommended);
    }

    #[test]
    fn a_head_kept_level_on_a_bent_trunk_is_extended() {
        let z = zones(|b, _, _| (b.trunk_flex_deg, b.neck_flex_deg) = (40.0, -40.0));
        assert_eq!((z[2].angle_deg, z[2].zone), (0.0, PostureZone::Acceptable));
        assert_eq!(z[3].zone, PostureZone::NotRecommended);
    }

    #[test]
    fn support_lifts_the_time_limit_only() {
        let trunk =
            |deg: f64| zones(|b, _, s| (b.trunk_flex_deg, s.trunk_supported) = (deg, true))[0].zone;
        assert_eq!([trunk(-20.0), trunk(50.0)], [PostureZone::Acceptable; 2]);
        assert_eq!(trunk(70.0), PostureZone::NotRecommended);
    }

    #[test]
    fn asymmetry_and_awkward_arms_are_not_recommended() {
        let n = PostureZone::NotRecommended;
        assert_eq!(zones(|b, _, _| b.trunk_side_deg = -12.0)[1].zone, n);
        assert_eq!(zones(|b, _, _| b.neck_twist_deg = 11.0)[4].zone, n);
        assert_eq!(zones(|_, a, _| a.upper_arm_flex_deg = -10.0)[5].zone, n);
        assert_eq!(zones(|_, a, _| a.upper_arm_abduction_deg = -10.0)[5].zone, n);
        assert_eq!(zones(|_, a, _| a.girdle_elevation_deg = 8.0)[5].zone, n);
    }

    #[test]
    fn what_is_not_a_number_is_not_recommended() {
        let z = zones(|b, a, _| {
            (b.trunk_flex_deg, b.trunk_twist_deg, b.neck_flex_deg) = (f64::NAN, f64::NAN, f64::NAN);
            a.upper_arm_elevation_deg = f64::NAN;
        });
        for i in [0, 1, 2, 3, 5] {
            assert_eq!(z[i].zone, PostureZone::NotRecommended, "{i}");
        }
    }

    #[test]
    fn a_bend_of_100_s_is_too_long_at_55_deg_but_not_at_25() {
        let held = |deg: f64| {
            let posture = zones(|b, _, _| b.trunk_flex_deg = deg);
            zone_times(&vec![posture; 200], 0.5)[0].is_held_too_long()
        };
        assert_eq!([held(25.0), held(55.0)], [false, true]);
    }
}
