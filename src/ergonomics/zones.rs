//! Zones of the posture standards, and how long a posture stays in them.
//!
//! What ISO 11226 and EN 1005-4 have in common: body parts, zones, what counts as visible, and the
//! time that a series of postures spends in each zone.

use serde::Serialize;

/// Holds longer than this are static working postures, s (definition in ISO 11226; from memory).
pub const STATIC_FROM_S: f64 = 4.0;

/// A body part that the standards judge on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ZonePart {
    /// Inclination of the trunk to the vertical.
    Trunk,
    /// Twist or side bend of the trunk, the larger one.
    TrunkAsymmetry,
    /// Inclination of the head to the vertical.
    Head,
    /// Flexion of the neck: head to trunk.
    Neck,
    /// Twist or side bend of the neck, the larger one.
    NeckAsymmetry,
    /// Elevation of the upper arm, or how far it is behind or across the body.
    UpperArm,
}

impl ZonePart {
    /// Name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trunk => "trunk inclination",
            Self::TrunkAsymmetry => "trunk twist or side bend",
            Self::Head => "head inclination",
            Self::Neck => "neck flexion",
            Self::NeckAsymmetry => "neck twist or side bend",
            Self::UpperArm => "upper arm",
        }
    }
}

/// What a standard says of one posture of one part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "zone", rename_all = "snake_case")]
pub enum PostureZone {
    /// Acceptable.
    Acceptable,
    /// Acceptable up to a holding time.
    UpTo {
        /// The longest acceptable hold, s.
        holding_s: f64,
    },
    /// Acceptable under conditions that no posture shows (support, short use, recovery).
    Conditional,
    /// Not recommended (ISO), not acceptable (EN).
    NotRecommended,
}

/// One part of one posture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PartZone {
    /// The part.
    pub part: ZonePart,
    /// The angle that was judged, deg.
    pub angle_deg: f64,
    /// Its zone.
    pub zone: PostureZone,
}

/// What the task adds to the angles, and readings that the standards leave open.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ZoneSettings {
    /// The trunk is fully supported.
    pub trunk_supported: bool,
    /// The head is fully supported.
    pub head_supported: bool,
    /// The arm is fully supported.
    pub arm_supported: bool,
    /// How far backward an inclination, or across the body an arm, still counts as 0, deg. 0 by the
    /// standards; 5 here, so that upright postures do not flicker over the border.
    pub neutral_band_deg: f64,
    /// Twist or side bend above which a posture is visibly asymmetric, deg. The standards speak of
    /// "clearly visible"; 10 in software that follows EN 1005-4.
    pub visible_deg: f64,
    /// Girdle elevation above which the shoulder is raised, deg; as in [`super::Profile`].
    pub shoulder_raised_deg: f64,
}

impl Default for ZoneSettings {
    fn default() -> Self {
        Self {
            trunk_supported: false,
            head_supported: false,
            arm_supported: false,
            neutral_band_deg: 5.0,
            visible_deg: 10.0,
            shoulder_raised_deg: 5.0,
        }
    }
}

/// A stretch of time in which a part stays in a zone with a holding time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ZoneHold {
    /// Start, s after the first sample.
    pub from_s: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Holding time, s: the mean over the stretch, as the angle may change within the zone.
    pub allowed_s: f64,
}

impl ZoneHold {
    /// Whether it is longer than acceptable.
    pub fn is_too_long(&self) -> bool {
        self.duration_s > self.allowed_s
    }

    /// Whether it is long enough for a static posture; shorter ones are movement, which ISO 11226
    /// does not judge.
    pub fn is_static(&self) -> bool {
        self.duration_s > STATIC_FROM_S
    }

    fn used(&self) -> f64 {
        self.duration_s / self.allowed_s
    }
}

/// One part over time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PartTimes {
    /// The part.
    pub part: ZonePart,
    /// Share of the time in acceptable postures.
    pub acceptable: f64,
    /// Share of the time in postures acceptable up to a holding time.
    pub up_to: f64,
    /// Share of the time in conditional postures.
    pub conditional: f64,
    /// Share of the time in postures that are not recommended.
    pub not_recommended: f64,
    /// How often the part leaves the acceptable zone; a start outside counts.
    pub departures: usize,
    /// The longest hold in a zone with a holding time.
    pub longest: Option<ZoneHold>,
    /// The hold that uses up the largest part of its holding time.
    pub most_used: Option<ZoneHold>,
}

impl PartTimes {
    /// Whether some hold is longer than acceptable.
    pub fn is_held_too_long(&self) -> bool {
        self.most_used.is_some_and(|h| h.is_too_long())
    }
}

/// Time of each part in each zone.
///
/// `samples[i]` is the posture at time `i dt` (s), all with the same parts in the same order; each
/// stands for `dt`. A part counts as held as long as its angle stays in zones with a holding time,
/// without a break. A movement of a few seconds cannot be held too long: postures between the
/// movements, or the same one for minutes, have to be given as such. Empty for no sample.
pub fn zone_times<const N: usize>(samples: &[[PartZone; N]], dt: f64) -> Vec<PartTimes> {
    let Some(first) = samples.first() else { return Vec::new() };
    (0..N)
        .map(|i| {
            let zones: Vec<PostureZone> = samples.iter().map(|s| s[i].zone).collect();
            part_times(first[i].part, &zones, dt)
        })
        .collect()
}

fn part_times(part: ZonePart, zones: &[PostureZone], dt: f64) -> PartTimes {
    let share = |is: fn(&PostureZone) -> bool| {
        zones.iter().filter(|z| is(z)).count() as f64 / zones.len() as f64
    };
    let is_out = |z: &PostureZone| *z != PostureZone::Acceptable;
    let starts_out = usize::from(zones.first().is_some_and(is_out));
    let leaves = zones.windows(2).filter(|w| !is_out(&w[0]) && is_out(&w[1])).count();
    let all = holds(zones, dt);
    let largest =
        |of: fn(&ZoneHold) -> f64| all.iter().copied().max_by(|a, b| of(a).total_cmp(&of(b)));
    PartTimes {
        part,
        acceptable: share(|z| matches!(z, PostureZone::Acceptable)),
        up_to: share(|z| matches!(z, PostureZone::UpTo { .. })),
        conditional: share(|z| matches!(z, PostureZone::Conditional)),
        not_recommended: share(|z| matches!(z, PostureZone::NotRecommended)),
        departures: starts_out + leaves,
        longest: largest(|h| h.duration_s),
        most_used: largest(ZoneHold::used),
    }
}

/// All stretches in zones with a holding time.
fn holds(zones: &[PostureZone], dt: f64) -> Vec<ZoneHold> {
    let mut found = Vec::new();
    let mut run: Vec<f64> = Vec::new();
    let end = std::iter::once(&PostureZone::Acceptable);
    for (i, zone) in zones.iter().chain(end).enumerate() {
        if let PostureZone::UpTo { holding_s } = zone {
            run.push(*holding_s);
        } else if !run.is_empty() {
            found.push(ZoneHold {
                from_s: (i - run.len()) as f64 * dt,
                duration_s: run.len() as f64 * dt,
                allowed_s: run.iter().sum::<f64>() / run.len() as f64,
            });
            run.clear();
        }
    }
    found
}

/// The value of larger magnitude; not a number if one of them is not.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a.abs() >= b.abs() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(zones: &[PostureZone]) -> PartTimes {
        part_times(ZonePart::Trunk, zones, 0.5)
    }

    #[test]
    fn shares_departures_and_holds() {
        let up = |holding_s| PostureZone::UpTo { holding_s };
        let (a, c, n) =
            (PostureZone::Acceptable, PostureZone::Conditional, PostureZone::NotRecommended);
        let t = series(&[up(240.0), up(180.0), a, up(1.0), up(1.0), up(1.0), n, c, a, up(60.0)]);
        assert_eq!((t.acceptable, t.up_to, t.conditional, t.not_recommended), (0.2, 0.6, 0.1, 0.1));
        assert_eq!(t.departures, 3);
        let longest = t.longest.unwrap();
        assert_eq!((longest.from_s, longest.duration_s, longest.allowed_s), (1.5, 1.5, 1.0));
        assert!(longest.is_too_long() && t.is_held_too_long() && !longest.is_static());
        assert_eq!(t.most_used, t.longest);
    }

    #[test]
    fn the_longest_hold_need_not_use_most() {
        let up = |holding_s, n| vec![PostureZone::UpTo { holding_s }; n];
        let gap = vec![PostureZone::Acceptable];
        let t = series(&[up(200.0, 100), gap, up(60.0, 60)].concat());
        assert_eq!(t.longest.unwrap().duration_s, 50.0);
        assert!(t.longest.unwrap().is_static());
        assert_eq!(t.most_used.unwrap().duration_s, 30.0);
        assert!(!t.is_held_too_long());
    }

    #[test]
    fn calm_postures_have_no_hold() {
        let t = series(&[PostureZone::Acceptable; 4]);
        assert_eq!((t.acceptable, t.departures, t.longest), (1.0, 0, None));
        assert!(zone_times::<1>(&[], 0.1).is_empty());
    }

    #[test]
    fn the_larger_magnitude_keeps_its_sign() {
        assert_eq!([larger(-12.0, 5.0), larger(3.0, -2.0)], [-12.0, 3.0]);
        assert!(larger(f64::NAN, 1.0).is_nan() && larger(1.0, f64::NAN).is_nan());
    }
}
