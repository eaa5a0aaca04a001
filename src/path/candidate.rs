//! Candidate paths: K interior via-points and the curve through them.
//!
//! ```text
//! vias = mu + L x,   mu = the vias of the straight path,   L L^T = sigma^2 R^-1
//! R_ij = int phi_i'' phi_j'' ds   (phi_i: the clamped spline that is 1 at via i, 0 at the others)
//! ```
//! `x` in R^(3K) is white: with independent standard normal numbers the deviation from the straight
//! path is drawn with density `exp(-bending / 2 sigma^2)`, so that smooth deviations are the likely
//! ones, and `sigma` is chosen to make the offset in mid-path as large as asked. The curve is
//! traversed by the minimum-jerk law *in its arc length*, so that every family, the straight one
//! included, has the same bell-shaped speed. A candidate of the search may have a pace of its own
//! ([`super::pace`]) and go through that law quicker and slower.

use super::pace::Pace;
use super::spline::ClampedSpline;
use super::turning::{Turning, sway};
use crate::math::pose::interpolate;
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use crate::trajectory::{Pause, TimedPath, TrajectoryError, phase};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Chords by which the arc length of a curve is measured; 0.3 micrometres of sag at 10 /m.
const CHORDS: usize = 2000;

/// Where a candidate comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// The straight line.
    Straight,
    /// The straight line with its timing chosen by the search.
    StraightRetimed,
    /// Over the straight line (world z).
    Lifted,
    /// Under the straight line.
    Lowered,
    /// Nearer to the worker's body.
    TowardBody,
    /// Farther from the worker's body.
    Away,
    /// Drawn at random around the straight line, or decoded from a search's numbers.
    Sampled,
    /// The user's own via-points.
    Drawn,
    /// What an expert would draw: over the middle at elbow height, nearer to the body.
    ExpertArc,
    /// The shortest feasible path that was found, where the straight one is not feasible.
    Shortest,
    /// The best of as many random paths.
    BestRandom,
    /// Planned with a single posture by the plain pseudo-inverse.
    SinglePosturePlain,
    /// Planned with a single posture by the learned model, without its spread.
    SinglePostureLearned,
    /// Found by the search with one freedom taken away.
    Held,
}

/// A path as via-points between start and goal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// Name: the family's, or `s` and a number for samples.
    pub id: String,
    /// Where it comes from.
    pub family: Family,
    /// Via-points in order, world, m.
    pub vias: Vec<Vec3>,
    /// Their spline parameters, strictly increasing inside (0, 1).
    pub parameters: Vec<f64>,
    /// Rotation vectors at equal parts of the way, TCP axes, rad: turns besides that from start to
    /// goal. None where the tool turns straight.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub turns: Vec<Vec3>,
    /// How long the path rests at its middle via-point, s.
    pub dwell_s: f64,
    /// Where it is quicker and slower than by the minimum-jerk law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pace: Option<Pace>,
}

/// Which candidates are made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CandidateSettings {
    /// Number of via-points K.
    pub vias: usize,
    /// Offset in mid-path of the named families, m.
    pub named_offset_m: f64,
    /// Root mean square offset in mid-path of the samples, m.
    pub sampled_offset_m: f64,
    /// Number of samples.
    pub samples: usize,
    /// Block of random numbers, so that later generations draw others.
    pub generation: u32,
}

impl Default for CandidateSettings {
    fn default() -> Self {
        Self { vias: 3, named_offset_m: 0.12, sampled_offset_m: 0.15, samples: 11, generation: 0 }
    }
}

/// The whitened space of via-points between one start and goal.
#[derive(Debug, Clone, PartialEq)]
pub struct ViaSpace {
    parameters: Vec<f64>,
    straight: Vec<Vec3>,
    /// L for one axis, K x K lower triangular, m.
    factor: DMatrix<f64>,
    /// Offsets at the vias of the least bent curve that is 1 in mid-path.
    bump: DVector<f64>,
}

impl ViaSpace {
    /// Space of `vias` via-points with the given root mean square offset in mid-path (m); `None`
    /// without via-points, for more than 50, or for a size that is not positive.
    pub fn new(vias: usize, start: &Pose, goal: &Pose, offset_rms_m: f64) -> Option<Self> {
        if vias == 0 || vias > 50 || !(offset_rms_m > 0.0 && offset_rms_m.is_finite()) {
            return None;
        }
        let parameters: Vec<f64> = (1..=vias).map(|k| k as f64 / (vias + 1) as f64).collect();
        let units: Option<Vec<ClampedSpline>> = (0..vias)
            .map(|i| {
                let unit = (0..vias).map(|k| if k == i { Vec3::x() } else { Vec3::zeros() });
                through(&parameters, unit, Vec3::zeros(), Vec3::zeros())
            })
            .collect();
        let units = units?;
        let stiffness = DMatrix::from_fn(vias, vias, |i, j| units[i].bending(&units[j]));
        let covariance = stiffness.cholesky()?.inverse();
        let middle = DVector::from_iterator(vias, units.iter().map(|u| u.position(0.5).x));
        let reach = &covariance * &middle;
        let variance = middle.dot(&reach);
        // Three axes add up in the mean square.
        let sigma = offset_rms_m / (3.0 * variance).sqrt();
        let factor = covariance.cholesky()?.l() * sigma;
        let (a, b) = (start.translation.vector, goal.translation.vector);
        let straight = parameters.iter().map(|s| a.lerp(&b, ease(*s))).collect();
        Some(Self { parameters, straight, factor, bump: reach / variance })
    }

    /// Number of search variables, 3 K.
    pub fn dimension(&self) -> usize {
        3 * self.straight.len()
    }

    /// The candidate at `x` (3 K numbers: all x offsets, then y, then z; missing ones count as 0).
    pub fn decode(&self, id: impl Into<String>, x: &[f64]) -> Candidate {
        let k = self.straight.len();
        let at = |i: usize| x.get(i).copied().unwrap_or(0.0);
        let white = DMatrix::from_fn(k, 3, |i, axis| at(axis * k + i));
        let offsets = &self.factor * white;
        let offset = |i: usize| Vec3::new(offsets[(i, 0)], offsets[(i, 1)], offsets[(i, 2)]);
        self.candidate(id.into(), Family::Sampled, offset)
    }

    /// The white numbers that decode to a candidate of this space; `None` for another number of vias.
    pub fn encode(&self, candidate: &Candidate) -> Option<Vec<f64>> {
        let k = self.straight.len();
        if candidate.vias.len() != k {
            return None;
        }
        let offsets =
            DMatrix::from_fn(k, 3, |i, axis| candidate.vias[i][axis] - self.straight[i][axis]);
        Some(self.factor.solve_lower_triangular(&offsets)?.as_slice().to_vec())
    }

    /// The least bent candidate whose mid-path is moved by `offset` (m) from the straight line.
    pub fn bent(&self, id: impl Into<String>, family: Family, offset: &Vec3) -> Candidate {
        self.candidate(id.into(), family, |i| offset * self.bump[i])
    }

    fn candidate(&self, id: String, family: Family, offset: impl Fn(usize) -> Vec3) -> Candidate {
        let vias = self.straight.iter().enumerate().map(|(i, p)| p + offset(i)).collect();
        let parameters = self.parameters.clone();
        Candidate { id, family, vias, parameters, turns: Vec::new(), dwell_s: 0.0, pace: None }
    }
}

/// The five named candidates, then the samples. `toward_body` is the horizontal direction from the
/// path to the worker's body, any length; without one (zero or not finite) its two families are left
/// out. Empty for settings that make no sense (see [`ViaSpace::new`]).
pub fn candidates(
    settings: &CandidateSettings,
    start: &Pose,
    goal: &Pose,
    toward_body: &Vec3,
    seed: u64,
) -> Vec<Candidate> {
    let Some(space) = ViaSpace::new(settings.vias, start, goal, settings.sampled_offset_m) else {
        return Vec::new();
    };
    let named = |id: &str, family, direction: Vec3| {
        space.bent(id, family, &(direction * settings.named_offset_m))
    };
    let mut made = vec![
        named("straight", Family::Straight, Vec3::zeros()),
        named("lifted", Family::Lifted, Vec3::z()),
        named("lowered", Family::Lowered, -Vec3::z()),
    ];
    if let Some(body) = toward_body.try_normalize(1e-9).filter(|b| b.norm().is_finite()) {
        made.push(named("toward_body", Family::TowardBody, body));
        made.push(named("away", Family::Away, -body));
    }
    made.extend((0..settings.samples).map(|i| {
        let mut rng = stream(seed, Purpose::Search, settings.generation, i as u32);
        space.decode(format!("s{i:03}"), &normals(&mut rng, space.dimension()))
    }));
    made
}

/// The candidate through the user's via-points (world, m), spaced along the spline by the chords
/// between them; a point that repeats its neighbour is left out, one that is not finite is refused by
/// its index.
pub fn drawn(
    id: impl Into<String>,
    vias: &[Vec3],
    start: &Pose,
    goal: &Pose,
) -> Result<Candidate, TrajectoryError> {
    let (first, last) = (start.translation.vector, goal.translation.vector);
    if let Some(i) = vias.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(TrajectoryError::Pose(i));
    }
    let mut points: Vec<Vec3> = Vec::with_capacity(vias.len());
    for via in vias {
        if (via - points.last().unwrap_or(&first)).norm() > 1e-6 {
            points.push(*via);
        }
    }
    if points.last().is_some_and(|p| (p - last).norm() <= 1e-6) {
        points.pop();
    }
    let mut covered = 0.0;
    let mut before = first;
    let mut along = Vec::with_capacity(points.len());
    for point in points.iter().chain([&last]) {
        covered += (point - before).norm();
        before = *point;
        along.push(covered);
    }
    along.pop();
    let parameters = along.iter().map(|c| inverse_ease(c / covered)).collect();
    let (turns, dwell_s) = (Vec::new(), 0.0);
    let (id, family, pace) = (id.into(), Family::Drawn, None);
    Ok(Candidate { id, family, vias: points, parameters, turns, dwell_s, pace })
}

/// The candidate as a timed path, `steps + 1` samples over `duration_s` (its rest included), without
/// regard to limits: minimum jerk along the arc length of its curve, at its pace; the orientation turning from
/// start to goal by the same law.
pub fn reference_path(
    candidate: &Candidate,
    start: &Pose,
    goal: &Pose,
    duration_s: f64,
    steps: usize,
) -> Result<TimedPath, TrajectoryError> {
    let fault =
        TrajectoryError::Length { times: candidate.parameters.len(), poses: candidate.vias.len() };
    let Some(way) = Way::of(candidate, start, goal) else { return Err(fault) };
    let pause = candidate.pause(&way);
    TimedPath::sample(duration_s, steps, |t| {
        let paced = |pace: &Pace| duration_s * pace.at(t / duration_s);
        let [s, _] = phase(candidate.pace.as_ref().map_or(t, paced), duration_s, pause);
        let turned = interpolate(start, goal, s).rotation;
        Pose::from_parts(way.at(s).into(), turned)
    })
}

impl Candidate {
    /// How it is gone along, the turns besides bounded by `most` (rad); none where it neither rests
    /// nor turns besides.
    pub fn turning(&self, start: &Pose, goal: &Pose, most: f64) -> Option<Turning> {
        if self.turns.is_empty() && self.dwell_s <= 0.0 {
            return None;
        }
        let pause = Way::of(self, start, goal).and_then(|way| self.pause(&way));
        Some(Turning { pause, sway: sway(&self.turns, most) })
    }

    fn pause(&self, way: &Way) -> Option<Pause> {
        let middle = *self.parameters.get(self.parameters.len() / 2)?;
        let phase = way.share(middle).clamp(0.02, 0.98);
        (self.dwell_s > 0.0).then_some(Pause { phase, dwell_s: self.dwell_s })
    }
}

/// A curve by its arc length.
struct Way {
    points: Vec<Vec3>,
    covered: Vec<f64>,
}

impl Way {
    fn of(candidate: &Candidate, start: &Pose, goal: &Pose) -> Option<Self> {
        let (first, last) = (start.translation.vector, goal.translation.vector);
        let curve = through(&candidate.parameters, candidate.vias.iter().copied(), first, last)?;
        let points: Vec<Vec3> =
            (0..=CHORDS).map(|i| curve.position(i as f64 / CHORDS as f64)).collect();
        let mut covered = vec![0.0; points.len()];
        for i in 1..points.len() {
            covered[i] = covered[i - 1] + (points[i] - points[i - 1]).norm();
        }
        Some(Self { points, covered })
    }

    /// The point at a share of the length.
    fn at(&self, share: f64) -> Vec3 {
        point_at(&self.points, &self.covered, share * self.covered[CHORDS])
    }

    /// The share of the length at a spline parameter.
    fn share(&self, parameter: f64) -> f64 {
        let at = ((parameter * CHORDS as f64).round() as usize).min(CHORDS);
        let length = self.covered[CHORDS];
        if length > 0.0 { self.covered[at] / length } else { parameter }
    }
}

/// The point of a polyline at a distance from its start.
fn point_at(points: &[Vec3], covered: &[f64], distance: f64) -> Vec3 {
    let last = points.len() - 1;
    let i = covered.partition_point(|c| *c <= distance).clamp(1, last);
    let chord = covered[i] - covered[i - 1];
    let part = if chord > 0.0 { (distance - covered[i - 1]) / chord } else { 0.0 };
    points[i - 1].lerp(&points[i], part.clamp(0.0, 1.0))
}

/// The clamped spline from `first` to `last` through the vias.
fn through(
    parameters: &[f64],
    vias: impl Iterator<Item = Vec3>,
    first: Vec3,
    last: Vec3,
) -> Option<ClampedSpline> {
    let knots = [0.0].into_iter().chain(parameters.iter().copied()).chain([1.0]).collect();
    let points = [first].into_iter().chain(vias).chain([last]).collect();
    ClampedSpline::new(knots, points)
}

/// The spline without via-points: `3 s^2 - 2 s^3`.
fn ease(s: f64) -> f64 {
    s * s * (3.0 - 2.0 * s)
}

/// The `s` in [0, 1] whose [`ease`] is `y`, in closed form.
fn inverse_ease(y: f64) -> f64 {
    0.5 - ((1.0 - 2.0 * y.clamp(0.0, 1.0)).asin() / 3.0).sin()
}

#[cfg(test)]
mod tests;
