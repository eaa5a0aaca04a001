//! Simulated people whose true behaviour is known. Most are outside what a posture model can say.
//!
//! | kind | what it does |
//! |---|---|
//! | in class | full weight matrix, pull to usual postures, correlated noise: as our models |
//! | height and history | weights that blend with the height of the hand; drifts to where it has been |
//! | two habits | every other repetition with other weights and other usual postures |
//! | rough noise | mostly a bias that lasts a repetition, of heavy-tailed size, and white noise |

use crate::files::InputError;
use crate::human::{Body, Side};
use crate::kinematics::Frames;
use crate::math::Pose;
use crate::math::stream::{Purpose, normals, stream};
use crate::posture::{
    Behaviour, Coupling, HandPath, Noise, NoiseShares, PostureDistribution, PostureLaw,
    PostureModel, Rollout, Sampler, Sampling, Start, StepSolver, roll_out, simulated_person,
};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

/// Block offset of a person's chance.
const CHANCE: u32 = 1 << 20;
/// Time over which somebody with history forgets where they were, s, and how fast they return there.
const MEMORY_S: f64 = 1.5;
const RETURN_PER_S: f64 = 1.0;
/// Hand travel over which they go back to their usual posture, m.
const HABIT_M: f64 = 0.2;
/// Residuals as in a rollout of a model: corrected beyond, given up beyond, m.
const CORRECT_BEYOND_M: f64 = 1e-4;
const GIVE_UP_BEYOND_M: f64 = 1e-3;
/// Steps between two samples of the path.
const SUBSTEPS: usize = 2;

/// How a simulated person differs from the class of our models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Not at all.
    InClass,
    /// Weights by height, and a pull to where the body has been.
    HeightAndHistory,
    /// Two ways of moving, alternating.
    TwoHabits,
    /// Another kind of noise.
    RoughNoise,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] =
        [Self::InClass, Self::HeightAndHistory, Self::TwoHabits, Self::RoughNoise];

    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::InClass => "in class",
            Self::HeightAndHistory => "height and history",
            Self::TwoHabits => "two habits",
            Self::RoughNoise => "rough noise",
        }
    }
}

/// Somebody with a body, habits and chance.
#[derive(Debug, Clone)]
pub struct TruePerson {
    kind: Kind,
    /// The main habit.
    one: PostureModel,
    /// The other habit, or the habit at the other end of the height.
    other: PostureModel,
}

impl TruePerson {
    /// The person of a number in a body.
    ///
    /// # Errors
    /// Where the body cannot reach the simulated workplace.
    pub fn new(body: &Body, side: Side, kind: Kind, number: u64) -> Result<Self, InputError> {
        // Somebody whose own usual posture is out of reach of the workplace is somebody else.
        let draw = |first: u64| {
            let mut last = None;
            for attempt in 0..20 {
                match simulated_person(body, side, Some(first + 1000 * attempt)) {
                    Ok(model) => return Ok(model),
                    Err(e) => last = Some(e),
                }
            }
            Err(last.unwrap_or_else(|| InputError::new(&body.name, "cannot be simulated")))
        };
        Ok(Self { kind, one: draw(2 * number)?, other: draw(2 * number + 1)? })
    }

    /// Names of the joints, n.
    pub fn joints(&self) -> &[String] {
        &self.one.joints
    }

    fn habit(&self, repetition: usize) -> &PostureModel {
        let is_other = self.kind == Kind::TwoHabits && repetition % 2 == 1;
        if is_other { &self.other } else { &self.one }
    }
}

impl Behaviour for TruePerson {
    fn postures(&self) -> &PostureDistribution {
        &self.one.postures
    }

    fn walk(
        &self,
        coupling: &Coupling,
        (time_s, targets): (&[f64], &[Pose]),
        starts: &[Start],
        (seed, block): (u64, u32),
        first: usize,
    ) -> Vec<Rollout> {
        let hand =
            |law: &PostureLaw| HandPath::new(coupling, law, time_s.to_vec(), targets.to_vec());
        let (one, other) = (hand(&self.one.law), hand(&self.other.law));
        let walk = |(i, start): (usize, &Start)| {
            let repetition = first + i;
            let mut rng = stream(seed, Purpose::Posture, CHANCE + block, repetition as u32);
            let habit = self.habit(repetition);
            let is_one = std::ptr::eq(habit, &raw const self.one);
            let path = if is_one { &one } else { &other };
            match self.kind {
                Kind::InClass | Kind::TwoHabits => {
                    by_law(coupling, &habit.law, path, start, &mut rng)
                }
                Kind::RoughNoise => {
                    let law = PostureLaw {
                        noise: rough(&habit.law.noise, &mut rng),
                        ..habit.law.clone()
                    };
                    by_law(coupling, &law, path, start, &mut rng)
                }
                Kind::HeightAndHistory => {
                    self.with_history(coupling, path, time_s, start, &mut rng)
                }
            }
        };
        starts.par_iter().enumerate().map(walk).collect()
    }
}

/// As a posture law says, with its chance.
fn by_law(
    coupling: &Coupling,
    law: &PostureLaw,
    path: &HandPath,
    start: &Start,
    rng: &mut ChaCha8Rng,
) -> Rollout {
    let sampler = Sampler::new(law, Sampling::Pathwise);
    let person = sampler.as_ref().map(|s| s.draw(rng, path));
    roll_out(coupling, law, path, start, person.as_ref())
}

/// A bias that lasts a repetition, of heavy-tailed size, and white noise beside it.
fn rough(noise: &Noise, rng: &mut ChaCha8Rng) -> Noise {
    let z = normals(rng, 4);
    // A ratio of normal numbers to the root of a mean square: Student's t with 3 degrees of freedom.
    let size = z[0].abs() / ((z[1] * z[1] + z[2] * z[2] + z[3] * z[3]) / 3.0).sqrt().max(0.2);
    Noise {
        factor: &noise.factor * (0.4 + 0.6 * size.min(4.0)),
        shares: NoiseShares { white: 0.3, correlated: 0.1, lasting: 0.6 },
        white_interval_s: 0.04,
        ..noise.clone()
    }
}

impl TruePerson {
    /// Weights that go from one habit to the other with the height of the hand, and a pull to where
    /// the body has been of late.
    fn with_history(
        &self,
        coupling: &Coupling,
        path: &HandPath,
        time_s: &[f64],
        start: &Start,
        rng: &mut ChaCha8Rng,
    ) -> Rollout {
        let mut walk = HistoryWalk::new(self, coupling, start);
        let mut q = vec![walk.q.clone()];
        let mut lost = start.q.is_none().then_some(0);
        let (mut largest, mut squares) = (0.0f64, 0.0);
        let noise = &self.one.law.noise;
        let mut drift = DVector::from_vec(normals(rng, noise.factor.ncols()));
        for k in 1..path.len() {
            let span = time_s[k] - time_s[k - 1];
            let keep = (-span / noise.correlation_time_s).exp();
            drift = drift * keep
                + DVector::from_vec(normals(rng, noise.factor.ncols()))
                    * (1.0 - keep * keep).sqrt();
            if lost.is_none() {
                let (from, to) = (&path.targets()[k - 1], &path.targets()[k]);
                let speed = (to.translation.vector - from.translation.vector).norm() / span;
                let chance = &noise.factor * &drift * noise.gain(&[speed]);
                let usual = path.usual_posture(k);
                match walk.advance((from, to), usual.as_ref(), (&chance, speed), span) {
                    Some(residual) => {
                        largest = largest.max(residual);
                        squares += residual * residual;
                    }
                    None => lost = Some(k),
                }
            }
            q.push(walk.q.clone());
        }
        let reached = lost.unwrap_or(path.len()).max(1) as f64;
        Rollout {
            q,
            reach_exceeded_at: lost,
            max_residual_m: largest,
            rms_residual_m: (squares / reached).sqrt(),
            max_residual_rad: 0.0,
        }
    }
}

struct HistoryWalk<'a> {
    person: &'a TruePerson,
    coupling: &'a Coupling,
    solver: StepSolver,
    frames: Frames,
    q: DVector<f64>,
    /// Where the body has been of late.
    past: DVector<f64>,
}

impl<'a> HistoryWalk<'a> {
    fn new(person: &'a TruePerson, coupling: &'a Coupling, start: &Start) -> Self {
        let q = start.q.clone().unwrap_or_else(|| DVector::zeros(coupling.dof()));
        Self {
            person,
            coupling,
            solver: StepSolver::new(person.one.law.weight.clone()),
            frames: Frames::default(),
            past: q.clone(),
            q,
        }
    }

    /// Weights at a height of the hand over the pelvis (m): the other habit low, the first one high.
    fn weight(&self, up_m: f64) -> DMatrix<f64> {
        let high = 1.0 / (1.0 + (-up_m / 0.08).exp());
        &self.person.one.law.weight * high + &self.person.other.law.weight * (1.0 - high)
    }

    /// Moves to the next sample; the residual of the hand there (m), none where it is lost.
    fn advance(
        &mut self,
        (from, to): (&Pose, &Pose),
        usual: Option<&DVector<f64>>,
        (chance, speed): (&DVector<f64>, f64),
        span: f64,
    ) -> Option<f64> {
        let limits = self.coupling.limits();
        let h = span / SUBSTEPS as f64;
        self.solver.set_weight(self.weight(to.translation.vector.y - 0.15));
        let rate = speed / HABIT_M;
        for step in 0..SUBSTEPS {
            let part = (step + 1) as f64 / SUBSTEPS as f64;
            let target = crate::math::pose::interpolate(from, to, part);
            let mut wish = (&self.past - &self.q) * RETURN_PER_S + chance;
            if let Some(usual) = usual {
                wish += (usual - &self.q) * rate;
            }
            let seen = self.coupling.observe(&self.q, &mut self.frames);
            let task = self.coupling.task_error(&seen.pose, &target) / h;
            let qdot = self.solver.solve(&self.q, &seen.jacobian, &task, &wish, limits, h).ok()?;
            self.q.axpy(h, &qdot, 1.0);
            self.past += (&self.q - &self.past) * (h / MEMORY_S);
        }
        self.correct(to)
    }

    /// Newton corrections at the end of a step.
    fn correct(&mut self, to: &Pose) -> Option<f64> {
        let limits = self.coupling.limits();
        let still = DVector::zeros(self.q.len());
        let linear = self.coupling.hold().linear_rows();
        for _ in 0..6 {
            let seen = self.coupling.observe(&self.q, &mut self.frames);
            let error = self.coupling.task_error(&seen.pose, to);
            let metres = error.rows(0, linear).norm();
            if error.amax() <= CORRECT_BEYOND_M {
                return Some(metres);
            }
            let step =
                self.solver.solve(&self.q, &seen.jacobian, &error, &still, limits, 1.0).ok()?;
            self.q += step;
        }
        let seen = self.coupling.observe(&self.q, &mut self.frames);
        let left = self.coupling.task_error(&seen.pose, to).rows(0, linear).norm();
        (left <= GIVE_UP_BEYOND_M).then_some(left)
    }
}
