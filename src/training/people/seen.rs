//! What a recording shows of a person: what is compared with a prediction, and what scores need besides.
//!
//! Head and heels are told from the person's own upright neutral, as the law of the head is: the median over the
//! most upright postures with knees that are not bent. Systems place the axes of a head some degrees apart, and one
//! degree of extension moves RULA's neck from 1 to 4.

use super::super::measurer::bend_deg;
use super::super::upright::Upright;
use super::Features;
use crate::files::InputError;
use crate::human::{Head, Side};
use crate::math::Vec3;
use crate::math::stats::quantile;
use crate::recording::{Recording, SegmentTrack};

/// Share of the frames that are the most upright, and flexion from which a knee is bent (deg), as where the law of
/// the head was learned.
const MOST_UPRIGHT: f64 = 0.15;
const BENT_KNEE_DEG: f64 = 45.0;
/// Place of the trunk and of the knees among the features.
const TRUNK: usize = 1;
const KNEES: usize = 4;

/// What was recorded of a posture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// What is compared with a prediction.
    pub features: Features,
    /// The head from the thorax; none where it was not recorded.
    pub head: Option<Head>,
    /// Flexion of the right and the left knee, deg.
    pub knees_deg: [f64; 2],
    /// Rise of the heels over the balls of the feet, right and left, deg; none without balls.
    pub heels_deg: Option<[f64; 2]>,
}

/// What a recording shows at each frame, in its own axes.
pub(super) fn recorded(
    recording: &Recording,
    side: Side,
    upright: Upright,
) -> Result<Vec<Seen>, InputError> {
    let track = |name: &str| {
        recording.segment(name).ok_or_else(|| {
            InputError::new(&recording.source, format!("has no segment `{name}`"))
                .remedy("people are compared as a whole: trunk, the leading arm and both legs")
        })
    };
    let of = |part: &str| track(&format!("{}{part}", side.prefix()));
    let thorax = track("T8")?;
    let arm = [of("UpperArm")?, of("ForeArm")?, of("Hand")?];
    let leg = |side: Side| -> Result<_, InputError> {
        let of = |part: &str| track(&format!("{}{part}", side.prefix()));
        Ok([of("UpperLeg")?, of("LowerLeg")?, of("Foot")?])
    };
    let legs = [leg(Side::Right)?, leg(Side::Left)?];
    let balls = [Side::Right, Side::Left].map(|s| recording.segment(&format!("{}Toe", s.prefix())));
    let head = recording.segment("Head");
    let count = recording.frames();
    let floors: Vec<f64> = (0..count)
        .map(|i| legs.iter().map(|l| l[2].position[i].z).fold(f64::INFINITY, f64::min))
        .collect();
    let floor = quantile(&floors, 0.05);
    let points = |leg: &[&SegmentTrack; 3], i: usize| leg.map(|t| t.position[i]);
    let length = |i: usize| {
        let [h, k, a] = points(&legs[0], i);
        (k - h).norm() + (a - k).norm()
    };
    let leg_m = quantile(&(0..count).map(length).collect::<Vec<_>>(), 0.5);
    Ok((0..count)
        .map(|i| {
            let knees_deg =
                upright.knees_rad(legs.each_ref().map(|leg| points(leg, i))).map(f64::to_degrees);
            let hips = 0.5 * (legs[0][0].position[i].z + legs[1][0].position[i].z);
            let up = thorax.rotation[i] * Vec3::y();
            let [shoulder, elbow, hand] = points(&arm, i);
            let rise = |s: usize| balls[s].map(|b| rise_deg(legs[s][2].position[i], b.position[i]));
            Seen {
                features: [
                    (hips - floor) / leg_m,
                    up.angle(&Vec3::z()).to_degrees(),
                    (elbow - shoulder).angle(&-up).to_degrees(),
                    bend_deg([shoulder, elbow, hand]),
                    0.5 * (knees_deg[0] + knees_deg[1]),
                ],
                head: head.map(|h| Head::of(&(thorax.rotation[i].inverse() * h.rotation[i]))),
                knees_deg,
                heels_deg: rise(0).zip(rise(1)).map(|(right, left)| [right, left]),
            }
        })
        .collect())
}

/// How far the line from the ball of a foot to the ankle rises above the floor, deg.
fn rise_deg(ankle: Vec3, ball: Vec3) -> f64 {
    let foot = ankle - ball;
    foot.z.atan2(foot.xy().norm()).to_degrees()
}

/// Head and heels from the person's own neutral, over all movements of the person.
pub(super) fn from_upright(movements: &mut [&mut [Seen]]) {
    let every = || movements.iter().flat_map(|m| m.iter());
    let least = quantile(&every().map(|s| s.features[TRUNK]).collect::<Vec<_>>(), MOST_UPRIGHT);
    let upright: Vec<Seen> = every()
        .filter(|s| s.features[TRUNK] <= least && s.features[KNEES] < BENT_KNEE_DEG)
        .copied()
        .collect();
    // Who is never upright keeps the axes of the recording.
    let median = |values: Vec<f64>| {
        if values.is_empty() { 0.0 } else { quantile(&values, 0.5) }
    };
    let heads = || upright.iter().filter_map(|s| s.head);
    let neutral = Head {
        flexion: median(heads().map(|h| h.flexion).collect()),
        turn: median(heads().map(|h| h.turn).collect()),
        bend: median(heads().map(|h| h.bend).collect()),
    };
    let heel =
        |side: usize| median(upright.iter().filter_map(|s| s.heels_deg.map(|h| h[side])).collect());
    let flat_deg = [heel(0), heel(1)];
    for seen in movements.iter_mut().flat_map(|m| m.iter_mut()) {
        seen.head = seen.head.map(|h| Head {
            flexion: h.flexion - neutral.flexion,
            turn: h.turn - neutral.turn,
            bend: h.bend - neutral.bend,
        });
        seen.heels_deg =
            seen.heels_deg.map(|[right, left]| [right - flat_deg[0], left - flat_deg[1]]);
    }
}

impl Seen {
    /// Rise of the lower heel, deg.
    pub fn lower_heel_deg(&self) -> Option<f64> {
        self.heels_deg.map(|[right, left]| right.min(left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(trunk: f64, knees: f64, flexion: f64, heels: [f64; 2]) -> Seen {
        Seen {
            features: [1.0, trunk, 0.0, 0.0, knees],
            head: Some(Head { flexion, turn: 0.1, bend: -0.2 }),
            knees_deg: [knees; 2],
            heels_deg: Some(heels),
        }
    }

    #[test]
    fn heads_and_heels_are_told_from_the_persons_own_neutral() {
        // Upright in the first movement; the second is bent all the time, and once upright on bent knees.
        let mut first: Vec<Seen> = (0..4).map(|_| seen(2.0, 5.0, 0.3, [60.0, 58.0])).collect();
        let mut second: Vec<Seen> = (0..9).map(|_| seen(70.0, 30.0, 0.5, [60.0, 88.0])).collect();
        second.push(seen(1.0, 90.0, 2.0, [90.0; 2]));
        from_upright(&mut [first.as_mut_slice(), second.as_mut_slice()]);
        let head = second[0].head.unwrap();
        assert!((head.flexion - 0.2).abs() < 1e-12 && head.turn.abs() < 1e-12);
        assert!(head.bend.abs() < 1e-12 && first[0].head.unwrap().flexion.abs() < 1e-12);
        assert_eq!(second[0].heels_deg, Some([0.0, 30.0]));
        assert_eq!(second[0].lower_heel_deg(), Some(0.0));
        // A heel over its ball, and one that is half as high as it is behind.
        let rise = |x: f64, z: f64| rise_deg(Vec3::new(x, 0.0, z), Vec3::zeros());
        assert!((rise(0.0, 0.1) - 90.0).abs() < 1e-9);
        assert!((rise(-0.2, 0.1) - 0.5f64.atan().to_degrees()).abs() < 1e-9);
    }

    #[test]
    fn what_was_not_recorded_stays_unknown() {
        let mut own = [Seen { head: None, heels_deg: None, ..seen(3.0, 5.0, 0.0, [0.0; 2]) }; 3];
        from_upright(&mut [own.as_mut_slice()]);
        assert!(own.iter().all(|s| s.head.is_none() && s.lower_heel_deg().is_none()));
    }
}
