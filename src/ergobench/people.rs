//! Simulated people whose true behaviour is known. All but the first kind are outside what a posture
//! model of ours can say, each in its own way.
//!
//! | kind | what they do |
//! |---|---|
//! | in class | as our models: full weight matrix, pull to usual postures, correlated noise |
//! | as recorded | few quick synergies of the arm, as recorded people; small deviations stay |
//! | least effort | spare joints, shoulder and back at every step; no usual posture for a place |
//! | habits with memory | two habits with hysteresis; posture depends on direction and on the past |
//! | relaxing in time | go back to usual postures by the clock, even with the hand at rest |
//!
//! All but the first and the last hold their posture while the hand rests. Stooping and squatting
//! people need legs that move, and are not among them yet.

mod effort;
mod follow;
mod habits;
mod places;
mod recorded;
mod relaxer;

use crate::files::InputError;
use crate::human::{Body, Side};
use crate::math::pose::rotation_from_axes;
use crate::math::stream::{Purpose, stream};
use crate::math::{Pose, Vec3};
use crate::posture::{
    Behaviour, Coupling, Grips, HandPath, Hold, PostureDistribution, PostureModel, Repeated,
    Rollout, Sampler, Sampling, Start, roll_out, simulated_person,
};
use effort::Effort;
use follow::follow;
use habits::Habits;
use nalgebra::{DMatrix, UnitQuaternion};
use rand::RngExt as _;
use rayon::prelude::*;
use recorded::Recorded;
use relaxer::Relaxer;
use serde::Serialize;

/// Block offset of a person's chance, and of the habit that neighbouring repetitions share.
const CHANCE: u32 = 1 << 20;
const HABIT: u32 = 1 << 21;
/// Repetitions in a row that start with the same habit.
const NEIGHBOURS: usize = 4;
/// People that are drawn before one must have been found whose usual posture reaches a workplace.
const MOST_DRAWS: u64 = 20;

/// How a simulated person differs from the class of our models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Not at all.
    InClass,
    /// Velocities as those of recorded people.
    AsRecorded,
    /// Spares effort at every step.
    LeastEffort,
    /// Two habits, hysteresis and memory.
    HabitsWithMemory,
    /// Goes back to usual postures by the clock.
    RelaxingInTime,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::InClass,
        Self::AsRecorded,
        Self::LeastEffort,
        Self::HabitsWithMemory,
        Self::RelaxingInTime,
    ];

    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::InClass => "in class",
            Self::AsRecorded => "as recorded",
            Self::LeastEffort => "least effort",
            Self::HabitsWithMemory => "habits with memory",
            Self::RelaxingInTime => "relaxing in time",
        }
    }
}

/// How somebody moves the hand in demonstrations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Manner {
    /// Standard deviation of the hand's tilt about each axis at the ends, rad.
    pub tilt_rad: f64,
    /// Turn of the hand about the forward axis from the middle to the end of the longest side of the
    /// box in which it moves, rad: a hand that turns as it goes.
    pub turn_rad: f64,
    /// How quick the movements are beside the others'.
    pub tempo: f64,
}

/// Somebody with a body, habits and chance.
#[derive(Debug, Clone)]
pub struct TruePerson {
    kind: Kind,
    usual: PostureDistribution,
    nature: Nature,
}

#[derive(Debug, Clone)]
enum Nature {
    Model(Box<PostureModel>),
    Recorded(Recorded),
    Effort(Box<Effort>),
    Habits(Box<Habits>),
    Relaxer(Relaxer),
}

impl TruePerson {
    /// The person of a number in a body.
    ///
    /// # Errors
    /// Where the body cannot reach the simulated workplace.
    pub fn new(body: &Body, side: Side, kind: Kind, number: u64) -> Result<Self, InputError> {
        // Somebody whose own usual posture is out of reach of the workplace is somebody else.
        let mut last = InputError::new(&body.name, "cannot reach the simulated workplace");
        for attempt in 0..MOST_DRAWS {
            match Self::draw(body, side, kind, 2 * number + 1000 * attempt) {
                Ok(Some(person)) => return Ok(person),
                Ok(None) => {}
                Err(e) => last = e,
            }
        }
        Err(last)
    }

    fn draw(body: &Body, side: Side, kind: Kind, number: u64) -> Result<Option<Self>, InputError> {
        if kind == Kind::InClass {
            let model = simulated_person(body, side, Some(number))?;
            let usual = model.postures.clone();
            return Ok(Some(Self { kind, usual, nature: Nature::Model(Box::new(model)) }));
        }
        let frame = Frame::draw(body, side, number)?;
        let nature = match kind {
            Kind::InClass => None,
            Kind::AsRecorded => Recorded::draw(&frame, number).map(Nature::Recorded),
            Kind::LeastEffort => {
                Some(Nature::Effort(Box::new(Effort::draw(body, side, &frame, number)?)))
            }
            Kind::HabitsWithMemory => {
                let other = Frame::draw(body, side, number + 1)?;
                Habits::draw(&other, &frame, number).map(|h| Nature::Habits(Box::new(h)))
            }
            Kind::RelaxingInTime => Relaxer::draw(&frame, number).map(Nature::Relaxer),
        };
        Ok(nature.map(|nature| Self { kind, usual: frame.usual, nature }))
    }
}

impl TruePerson {
    /// How they move in demonstrations.
    pub(super) fn manner(&self) -> Manner {
        match self.kind {
            // Recorded hands move at 0.3 to 0.5 m/s and turn at 1 to 2 rad/s root mean square.
            Kind::AsRecorded => Manner { tilt_rad: 0.05, turn_rad: -0.5, tempo: 1.45 },
            _ => Manner { tilt_rad: 0.05, turn_rad: 0.0, tempo: 1.0 },
        }
    }
}

impl Behaviour for TruePerson {
    fn postures(&self) -> &PostureDistribution {
        &self.usual
    }

    fn repeat(
        &self,
        coupling: &Coupling,
        grips: (&[f64], &[Grips]),
        starts: &[Start],
        (seed, block): (u64, u32),
        first: usize,
    ) -> Repeated {
        let led: Vec<Pose> = grips.1.iter().map(|g| g.first).collect();
        let path = (grips.0, &led[..]);
        let own = |i: usize| {
            stream(seed, Purpose::Posture, CHANCE.wrapping_add(block), (first + i) as u32)
        };
        let each = |walk: &(dyn Fn(usize, &Start) -> Rollout + Sync)| {
            starts.par_iter().enumerate().map(|(i, s)| walk(i, s)).collect()
        };
        let rollouts = match &self.nature {
            Nature::Model(model) => {
                let law = &model.law;
                let hand = HandPath::new(coupling, law, grips.0.to_vec(), grips.1.to_vec());
                let sampler = Sampler::new(law, Sampling::Pathwise);
                each(&|i, start| {
                    let person = sampler.as_ref().map(|s| s.draw(&mut own(i), &hand));
                    roll_out(coupling, law, &hand, start, person.as_ref())
                })
            }
            Nature::Recorded(p) => {
                each(&|i, start| follow(coupling, path, start, &mut p.repetition(own(i))))
            }
            Nature::Effort(p) => {
                each(&|i, start| follow(coupling, path, start, &mut p.repetition(own(i))))
            }
            Nature::Habits(p) => each(&|i, start| {
                let group = ((first + i) / NEIGHBOURS) as u32;
                let mut rng = stream(seed, Purpose::Posture, HABIT.wrapping_add(block), group);
                let keeps_high = rng.random::<bool>();
                follow(coupling, path, start, &mut p.repetition(own(i), keeps_high))
            }),
            Nature::Relaxer(p) => {
                each(&|i, start| follow(coupling, path, start, &mut p.repetition(own(i))))
            }
        };
        Repeated { rollouts, extrapolation_share: 0.0 }
    }
}

/// What somebody brings along, whatever their law: a body that holds a bar, and usual postures.
#[derive(Debug, Clone)]
struct Frame {
    joints: Vec<String>,
    coupling: Coupling,
    usual: PostureDistribution,
    /// Of the hand, pelvis frame: a vertical bar before the body, the thumb up.
    grip: UnitQuaternion<f64>,
    /// +1 for a right hand, -1 for a left one.
    outward: f64,
}

impl Frame {
    fn draw(body: &Body, side: Side, number: u64) -> Result<Self, InputError> {
        let coupling = Coupling::new(body, side, Hold::Rigid)?;
        Ok(Self {
            joints: coupling.joints().map(str::to_owned).collect(),
            coupling,
            usual: simulated_person(body, side, Some(number))?.postures,
            grip: rotation_from_axes(-Vec3::z(), -Vec3::x(), Vec3::y()),
            outward: if side == Side::Right { 1.0 } else { -1.0 },
        })
    }

    /// A root of the usual postures' covariance, n x n, rad.
    fn spread(&self) -> Option<DMatrix<f64>> {
        self.usual.covariance.clone().cholesky().map(|f| f.l())
    }
}

/// Kind without side, and axis (0 Z, 1 X, 2 Y), of a joint such as `jRightElbow_Z`.
fn parts(joint: &str) -> (&str, usize) {
    let (bare, axis) = joint.rsplit_once('_').unwrap_or((joint, "Y"));
    let bare = bare.trim_start_matches('j').trim_start_matches("Right").trim_start_matches("Left");
    (bare, ["Z", "X", "Y"].iter().position(|a| *a == axis).unwrap_or(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posture::{StartRule, start_postures};
    use nalgebra::DVector;
    use std::path::Path;

    const COUNT: usize = 16;

    struct Met {
        coupling: Coupling,
        person: TruePerson,
        rollouts: Vec<Rollout>,
        starts: Vec<Start>,
        path: (Vec<f64>, Vec<Grips>),
    }

    /// A man of the kind whose hand is, at each share of 4 s, `up` above the low place (m).
    fn met(kind: Kind, up: impl Fn(f64) -> f64) -> Met {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
        let person = TruePerson::new(&body, Side::Right, kind, 2).unwrap();
        let grip = rotation_from_axes(-Vec3::z(), -Vec3::x(), Vec3::y());
        let hand =
            |share: f64| Pose::from_parts(Vec3::new(0.42, -0.05 + up(share), 0.2).into(), grip);
        let times: Vec<f64> = (0..=120).map(|i| f64::from(i) / 30.0).collect();
        let hands: Vec<Pose> = (0..=120).map(|i| hand(f64::from(i) / 120.0)).collect();
        let starts = start_postures(
            &coupling,
            person.postures(),
            &StartRule::Sampled,
            hands[0],
            (1, 1),
            0..COUNT,
        );
        let grips: Vec<Grips> = hands.iter().map(Into::into).collect();
        let rollouts = person.repeat(&coupling, (&times, &grips), &starts, (1, 1), 0).rollouts;
        Met { coupling, person, rollouts, starts, path: (times, grips) }
    }

    fn rms_deg(d: &DVector<f64>) -> f64 {
        (d.norm_squared() / d.len() as f64).sqrt().to_degrees()
    }

    fn up_and_down(share: f64) -> f64 {
        0.4 * (1.0 - (2.0 * share - 1.0).abs())
    }

    #[test]
    fn a_resting_hand_holds_the_posture_except_of_those_who_relax() {
        for kind in Kind::ALL.into_iter().filter(|k| *k != Kind::InClass) {
            let met = met(kind, |_| 0.15);
            let moved = met.rollouts.iter().map(|r| rms_deg(&(&r.q[120] - &r.q[0])));
            let mean = moved.sum::<f64>() / COUNT as f64;
            if kind == Kind::RelaxingInTime {
                assert!(mean > 1.0, "{}: {mean} deg", kind.name());
            } else {
                assert!(mean < 0.1, "{}: {mean} deg", kind.name());
            }
        }
    }

    #[test]
    fn everybody_keeps_path_and_limits_and_differs_between_repetitions() {
        for kind in Kind::ALL {
            let met = met(kind, up_and_down);
            for r in &met.rollouts {
                assert_eq!(r.reach_exceeded_at, None, "{}", kind.name());
                assert!(r.max_residual_m < 5e-4, "{}: {}", kind.name(), r.max_residual_m);
                for q in &r.q {
                    assert!(
                        met.coupling.limits().violation(q.as_slice()) < 1e-8,
                        "{}",
                        kind.name()
                    );
                }
            }
            let mean = met.rollouts.iter().map(|r| r.q[60].clone()).sum::<DVector<f64>>();
            let mean = mean / COUNT as f64;
            let spread = met.rollouts.iter().map(|r| rms_deg(&(&r.q[60] - &mean)));
            let spread = spread.sum::<f64>() / COUNT as f64;
            assert!((0.3..10.0).contains(&spread), "{}: {spread} deg", kind.name());
        }
    }

    #[test]
    fn a_repetition_depends_on_its_number_only() {
        for kind in Kind::ALL {
            let met = met(kind, up_and_down);
            let path = (&met.path.0[..], &met.path.1[..]);
            let again =
                met.person.repeat(&met.coupling, path, &met.starts[5..7], (1, 1), 5).rollouts;
            assert_eq!(again, met.rollouts[5..7], "{}", kind.name());
        }
    }

    #[test]
    fn with_memory_the_way_down_is_not_the_way_up() {
        // The same places at a quarter and at three quarters of the path.
        let between = |kind: Kind| {
            let met = met(kind, up_and_down);
            let way = met.rollouts.iter().map(|r| &r.q[90] - &r.q[30]).sum::<DVector<f64>>();
            rms_deg(&(way / COUNT as f64))
        };
        let (memory, recorded) = (between(Kind::HabitsWithMemory), between(Kind::AsRecorded));
        assert!(memory > 1.5 && memory > 2.0 * recorded, "{memory} deg, {recorded} deg");
    }
}
