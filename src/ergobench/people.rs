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
//! All but the first and the last hold their posture while the hand rests. Each kind is also met as a
//! whole person, with one hand or with both: pelvis, spine and arms move by the law, the legs follow, and
//! what legs and balance do not allow is not done. They differ in how much they squat or stoop.

mod effort;
mod follow;
mod habits;
mod places;
mod recorded;
mod relaxer;

use crate::files::InputError;
use crate::human::{Body, Coupled, Hands, PELVIS_JOINTS, Pelvis, Side, Stance};
use crate::math::pose::rotation_from_axes;
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use crate::posture::{
    Behaviour, Coupling, Grips, HandPath, Hold, PostureDistribution, PostureModel, Repeated,
    Rollout, Sampler, Sampling, Start, postures_at, roll_out, simulated_person,
    simulated_whole_person,
};
use effort::Effort;
use follow::follow;
use habits::Habits;
use nalgebra::{DMatrix, DVector};
use places::Grid;
use rand::RngExt as _;
use rayon::prelude::*;
use recorded::Recorded;
use relaxer::Relaxer;
use serde::Serialize;
use std::borrow::Cow;

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

/// Half the way between the hands on a crate, m.
pub(super) const HALF_CRATE_M: f64 = 0.19;
/// How far the bars lean forward that somebody holds who bends down, rad: thumbs up and ahead.
pub(super) const LEAN: f64 = std::f64::consts::PI / 6.0;
/// Shoes of who stands, m.
const SHOE_M: f64 = 0.03;
/// One more way in which a whole person gives way: hips forward, up (leg lengths) and tilted (deg). How
/// much of it differs between people: standard deviation of the logarithm.
const SQUAT: [(&str, f64); 3] =
    [("pelvis_forward", -0.015), ("pelvis_up", -0.05), ("jPelvis_Z", -3.0)];
const SQUAT_DIFFERS: f64 = 0.7;

/// How somebody takes part in a family's work.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contacts {
    /// The hands on the robot, and the pelvis.
    pub coupled: Coupled,
    /// What the robot prescribes of each hand.
    pub hold: Hold,
    /// Carried in the grips together, kg: what a whole person expects of the family.
    pub load_kg: f64,
}

impl Contacts {
    /// One hand on an upright bar, on a pelvis that rests.
    pub(super) fn arm(side: Side) -> Self {
        Self { coupled: Coupled::arm(side), hold: Hold::Rigid, load_kg: 0.0 }
    }

    /// A whole person who stands: bars that lean forward may turn in the hands.
    pub(super) fn whole(hands: Hands, load_kg: f64) -> Self {
        let coupled = Coupled { hands, pelvis: Pelvis::Moves };
        Self { coupled, hold: Hold::FreeRoll, load_kg }
    }

    /// Whether the pelvis moves over legs.
    pub(super) fn is_whole(&self) -> bool {
        self.coupled.pelvis == Pelvis::Moves
    }

    fn coupling(&self, body: &Body) -> Result<Coupling, InputError> {
        let holds = vec![self.hold; self.coupled.hands.sides().len()];
        let held = (Stance::Standing { shoe_m: SHOE_M }, self.load_kg);
        Coupling::of_person(body, self.coupled, &holds, held)
    }

    /// Where usual postures are worked out.
    fn grid(&self) -> Grid {
        match (self.is_whole(), self.coupled.hands) {
            (false, _) => places::ARM,
            (true, Hands::Both) => places::CRATE,
            (true, _) => places::WHOLE,
        }
    }

    /// Grips with the hands about a place (rest frame, m): bars before the body, the thumb up.
    pub(super) fn grips(&self, at: Vec3) -> Grips {
        let (sin, cos) = if self.is_whole() { LEAN.sin_cos() } else { (0.0, 1.0) };
        let bar =
            rotation_from_axes(-Vec3::z(), Vec3::new(-cos, sin, 0.0), Vec3::new(sin, cos, 0.0));
        let of = |sideways: f64| Pose::from_parts((at + Vec3::z() * sideways).into(), bar);
        match self.coupled.hands {
            Hands::Both => Grips { first: of(HALF_CRATE_M), second: Some(of(-HALF_CRATE_M)) },
            _ => of(0.0).into(),
        }
    }
}

/// Where a hand is, or the middle between both, rest frame, m.
fn middle(grips: &Grips) -> Vec3 {
    let first = grips.first.translation.vector;
    grips.second.map_or(first, |second| (first + second.translation.vector) * 0.5)
}

/// Somebody with a body, habits and chance.
#[derive(Debug, Clone)]
pub struct TruePerson {
    kind: Kind,
    contacts: Contacts,
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
    pub(super) fn new(
        body: &Body,
        contacts: Contacts,
        kind: Kind,
        number: u64,
    ) -> Result<Self, InputError> {
        // Somebody whose own usual posture is out of reach of the workplace is somebody else.
        let mut last = InputError::new(&body.name, "cannot reach the simulated workplace");
        for attempt in 0..MOST_DRAWS {
            match Self::draw(body, contacts, kind, 2 * number + 1000 * attempt) {
                Ok(Some(person)) => return Ok(person),
                Ok(None) => {}
                Err(e) => last = e,
            }
        }
        Err(last)
    }

    fn draw(
        body: &Body,
        contacts: Contacts,
        kind: Kind,
        number: u64,
    ) -> Result<Option<Self>, InputError> {
        if kind == Kind::InClass {
            let model = in_class(body, contacts, number)?;
            let usual = model.postures.clone();
            let nature = Nature::Model(Box::new(model));
            return Ok(Some(Self { kind, contacts, usual, nature }));
        }
        let frame = Frame::draw(body, contacts, number)?;
        let nature = match kind {
            Kind::InClass => None,
            Kind::AsRecorded => Recorded::draw(&frame, number).map(Nature::Recorded),
            Kind::LeastEffort => {
                Some(Nature::Effort(Box::new(Effort::draw(body, &frame, number)?)))
            }
            Kind::HabitsWithMemory => {
                let other = Frame::draw(body, contacts, number + 1)?;
                Habits::draw(&other, &frame, number).map(|h| Nature::Habits(Box::new(h)))
            }
            Kind::RelaxingInTime => Relaxer::draw(&frame, number).map(Nature::Relaxer),
        };
        Ok(nature.map(|nature| Self { kind, contacts, usual: frame.usual, nature }))
    }
}

/// The learner's own law with habits of somebody's own; of both hands as one hand's makes it.
fn in_class(body: &Body, contacts: Contacts, number: u64) -> Result<PostureModel, InputError> {
    let Coupled { hands, pelvis } = contacts.coupled;
    if !contacts.is_whole() {
        return simulated_person(body, hands.lead(), Some(number));
    }
    let model = simulated_whole_person(body, hands.lead(), number)?;
    model
        .adapted(pelvis, hands == Hands::Both)
        .map_err(|_| InputError::new(&body.name, "has no law of both hands"))
}

impl TruePerson {
    /// How they move in demonstrations.
    pub(super) fn manner(&self) -> Manner {
        match self.kind {
            // Recorded hands move at 0.3 to 0.5 m/s and turn at 1 to 2 rad/s root mean square. A load that
            // is lifted keeps its attitude.
            Kind::AsRecorded => {
                let turn_rad = if self.contacts.is_whole() { 0.0 } else { -0.5 };
                Manner { tilt_rad: 0.05, turn_rad, tempo: 1.45 }
            }
            _ => Manner { tilt_rad: 0.05, turn_rad: 0.0, tempo: 1.0 },
        }
    }
}

impl Behaviour for TruePerson {
    fn postures(&self) -> &PostureDistribution {
        &self.usual
    }

    fn postures_at(&self, coupling: &Coupling, grips: &Grips) -> Cow<'_, PostureDistribution> {
        match &self.nature {
            Nature::Model(model) => postures_at((&model.law, &model.postures), coupling, grips),
            _ => Cow::Borrowed(&self.usual),
        }
    }

    fn repeat(
        &self,
        coupling: &Coupling,
        path: (&[f64], &[Grips]),
        starts: &[Start],
        (seed, block): (u64, u32),
        first: usize,
    ) -> Repeated {
        let own = |i: usize| {
            stream(seed, Purpose::Posture, CHANCE.wrapping_add(block), (first + i) as u32)
        };
        let each = |walk: &(dyn Fn(usize, &Start) -> Rollout + Sync)| {
            starts.par_iter().enumerate().map(|(i, s)| walk(i, s)).collect()
        };
        let rollouts = match &self.nature {
            Nature::Model(model) => {
                let law = &model.law;
                let hand = HandPath::new(coupling, law, path.0.to_vec(), path.1.to_vec());
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
    contacts: Contacts,
    usual: PostureDistribution,
    /// How easily the joints give way, n x n.
    ease: DMatrix<f64>,
    /// +1 for a right hand that leads, -1 for a left one.
    outward: f64,
}

impl Frame {
    fn draw(body: &Body, contacts: Contacts, number: u64) -> Result<Self, InputError> {
        let coupling = contacts.coupling(body)?;
        let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
        let usual = in_class(body, contacts, number)?.postures;
        let mut ease = usual.covariance.clone();
        if contacts.is_whole() {
            let z = normals(&mut stream(number, Purpose::Simulation, 13, 0), 1)[0];
            let of = |j: &String| {
                let amount = SQUAT.iter().find(|(joint, _)| joint == j).map_or(0.0, |s| s.1);
                if PELVIS_JOINTS[..3].contains(&j.as_str()) { amount } else { amount.to_radians() }
            };
            let way = DVector::from_iterator(joints.len(), joints.iter().map(of));
            ease += &way * way.transpose() * (2.0 * SQUAT_DIFFERS * z).exp();
        }
        let outward = if contacts.coupled.hands.lead() == Side::Right { 1.0 } else { -1.0 };
        Ok(Self { joints, coupling, contacts, usual, ease, outward })
    }

    /// +1 for a joint of the right arm, -1 for one of the left; of the trunk as the hand that leads.
    fn outward_of(&self, joint: &str) -> f64 {
        match (joint.contains("Right"), joint.contains("Left")) {
            (true, _) => 1.0,
            (_, true) => -1.0,
            _ => self.outward,
        }
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
    use crate::kinematics::Frames;
    use crate::posture::{Bounds, StartRule};
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
        met_at(Contacts::arm(Side::Right), kind, |share| Vec3::new(0.42, -0.05 + up(share), 0.2))
    }

    /// The same as a whole person, with one hand or with both, from half a metre below the hips up.
    fn met_whole(hands: Hands, kind: Kind, up: impl Fn(f64) -> f64) -> Met {
        let sideways = if hands == Hands::Both { 0.0 } else { 0.2 };
        met_at(Contacts::whole(hands, 3.0), kind, |share| {
            Vec3::new(0.47, up(share) - 0.5, sideways)
        })
    }

    fn met_at(contacts: Contacts, kind: Kind, place: impl Fn(f64) -> Vec3) -> Met {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let coupling = contacts.coupling(&body).unwrap();
        let person = TruePerson::new(&body, contacts, kind, 2).unwrap();
        let times: Vec<f64> = (0..=120).map(|i| f64::from(i) / 30.0).collect();
        let grips: Vec<Grips> =
            (0..=120).map(|i| contacts.grips(place(f64::from(i) / 120.0))).collect();
        let rule = StartRule::Sampled;
        let starts = person.starts(&coupling, &grips[0], None, &rule, (1, 1), 0..COUNT);
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

    const HANDS: [Hands; 2] = [Hands::Right, Hands::Both];

    #[test]
    fn whole_people_keep_hands_legs_and_limits_on_the_way_up() {
        for (kind, hands) in Kind::ALL.into_iter().flat_map(|k| HANDS.map(|h| (k, h))) {
            let name = format!("{}, {hands:?}", kind.name());
            let met = met_whole(hands, kind, |share| 0.6 * share);
            let lost = met.rollouts.iter().filter(|r| r.reach_exceeded_at.is_some()).count();
            assert!(lost <= 1, "{name}: {lost} of {COUNT} lost");
            let (mut frames, mut bounds) = (Frames::default(), Bounds::default());
            for r in met.rollouts.iter().filter(|r| r.reach_exceeded_at.is_none()) {
                for (q, grips) in r.q.iter().zip(&met.path.1) {
                    let seen = met.coupling.observe(q, &mut frames);
                    let error = met.coupling.task_error(&seen.grips, grips);
                    assert!(error.norm() < 2e-3, "{name}: {error}");
                    let (short_m, leg) = met.coupling.bounds(&frames, 0.0, &mut bounds);
                    assert!(short_m < 1e-3 && leg < 0.02, "{name}: {short_m} m, {leg} rad");
                    assert!(met.coupling.limits().violation(q.as_slice()) < 1e-8, "{name}");
                }
            }
        }
    }

    #[test]
    fn whole_people_go_down_with_knees_and_hips() {
        for (kind, hands) in Kind::ALL.into_iter().flat_map(|k| HANDS.map(|h| (k, h))) {
            let met = met_whole(hands, kind, |share| 0.6 * share);
            let mean = |k: usize, joint: usize| {
                met.rollouts.iter().map(|r| r.q[k][joint]).sum::<f64>() / COUNT as f64
            };
            // Height of the hips in leg lengths, and tilt of the pelvis, at the top less at the bottom.
            let (hips, tilt) = (mean(120, 1) - mean(0, 1), mean(120, 3) - mean(0, 3));
            let name = format!("{}, {hands:?}: {hips} leg lengths, {tilt} rad", kind.name());
            assert!(hips > 0.01 && tilt > 0.1, "{name}");
        }
    }

    #[test]
    fn whole_people_at_rest_stay_and_depend_on_their_number_only() {
        for kind in Kind::ALL.into_iter().filter(|k| *k != Kind::InClass) {
            let met = met_whole(Hands::Both, kind, |_| 0.2);
            let moved = met.rollouts.iter().map(|r| rms_deg(&(&r.q[120] - &r.q[0])));
            let mean = moved.sum::<f64>() / COUNT as f64;
            let holds = kind != Kind::RelaxingInTime;
            assert_eq!(mean < 0.1, holds, "{}: {mean} deg", kind.name());
            let path = (&met.path.0[..], &met.path.1[..]);
            let again =
                met.person.repeat(&met.coupling, path, &met.starts[5..7], (1, 1), 5).rollouts;
            assert_eq!(again, met.rollouts[5..7], "{}", kind.name());
        }
    }
}
