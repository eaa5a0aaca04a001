//! The numbers that the search may choose: white via-points, the white pace where the timing is free,
//! white turns where the tool may turn on its way, then the scenario's other freedoms.
//!
//! A freedom with range `[lo, hi]` enters as `lo + Phi(x) (hi - lo)` with the normal distribution
//! function Phi: a standard normal `x` is then uniform over the range, like the via-points' `x` is
//! white, and no bound is ever broken.

use super::preset::Preset;
use crate::math::stats::{normal_cdf, normal_quantile};
use crate::math::{Pose, Vec3};
use crate::path::{Candidate, Family, Pace, ViaSpace};
use crate::scenario::{Chosen, Freedom, Freedoms, Scenario, TIMING, TURN_ON_THE_WAY, Variant};

/// Height of the elbow over the floor, as a share of stature, in the expert's arc.
const ELBOW_HEIGHT: f64 = 0.63;
/// How far the expert's arc comes towards the body, m.
const EXPERT_PULL_M: f64 = 0.10;
/// Farthest that a freedom's number is put when a scenario's own value lies at an end of its range.
const FARTHEST: f64 = 2.0;

/// A bend that is none, m: what `sampled_offset_m = 0` becomes.
const STRAIGHT_M: f64 = 1e-6;

/// How the search without a freedom is called, and what it is followed by when several are free and
/// none is used.
pub(super) const WITHOUT: &str = "without ";
pub(super) const ANY_FREEDOM: &str = "any freedom";

/// A path with everything that was chosen for it.
#[derive(Debug, Clone)]
pub(super) struct Choice {
    pub candidate: Candidate,
    pub variant: Variant,
}

/// The decision space of one search.
#[derive(Debug, Clone)]
pub(super) struct Space<'a> {
    scenario: &'a Scenario,
    vias: usize,
    /// Never 0, which would be no space; with [`STRAIGHT_M`] every path is the straight one.
    offset_rms_m: f64,
    named_offset_m: f64,
    /// Whether this search may bend the path; else it keeps to the straight line.
    has_route: bool,
    /// Spread of the pace, where this search may choose it.
    pace: Option<f64>,
    /// For each free number whether this search may use it.
    is_used: Vec<bool>,
    /// How far the tool may turn on its way, rad.
    turn_rad: Option<f64>,
}

impl<'a> Space<'a> {
    /// All freedoms of the scenario.
    pub(super) fn new(scenario: &'a Scenario, preset: &Preset) -> Self {
        Self {
            scenario,
            vias: preset.vias,
            offset_rms_m: preset.sampled_offset_m.max(STRAIGHT_M),
            named_offset_m: preset.named_offset_m,
            has_route: true,
            pace: scenario.free.pace_spread,
            is_used: vec![true; scenario.free.all.len()],
            turn_rad: scenario.free.turn_rad,
        }
    }

    /// The same without a freedom by name, or without any.
    pub(super) fn narrowed(&self, name: Option<&str>) -> Self {
        match name {
            None => self.clone(),
            Some(ANY_FREEDOM) => self.fixed(),
            Some(name) => self.without(name),
        }
    }

    fn without(&self, name: &str) -> Self {
        let keep = |(f, _): &(Freedom, [f64; 2])| f.name() != name;
        Self {
            is_used: self.scenario.free.all.iter().map(keep).collect(),
            turn_rad: self.turn_rad.filter(|_| name != TURN_ON_THE_WAY),
            pace: self.pace.filter(|_| name != TIMING),
            ..self.clone()
        }
    }

    fn fixed(&self) -> Self {
        let is_used = vec![false; self.is_used.len()];
        Self { is_used, turn_rad: None, pace: None, ..self.clone() }
    }

    /// The straight line of the cell as it is, with nothing but its timing to choose; none where that
    /// is not free.
    pub(super) fn retimed(&self) -> Option<Self> {
        self.pace?;
        Some(Self { has_route: false, pace: self.pace, ..self.fixed() })
    }

    /// Number of search variables.
    pub(super) fn dimension(&self) -> usize {
        self.route() + self.paces() + self.turns() + self.is_used.iter().filter(|u| **u).count()
    }

    /// Number of search variables of the via-points.
    fn route(&self) -> usize {
        if self.has_route { 3 * self.vias } else { 0 }
    }

    /// Number of search variables of the pace.
    fn paces(&self) -> usize {
        if self.pace.is_some() { self.vias } else { 0 }
    }

    /// Number of search variables that turn the tool.
    fn turns(&self) -> usize {
        if self.turn_rad.is_some() { 3 * self.vias } else { 0 }
    }

    /// The choice at `x`, as many numbers as the dimension.
    pub(super) fn decode(&self, id: &str, x: &[f64]) -> Option<Choice> {
        let [white, paces, turns, free] = self.parts(x)?;
        let mut free = free.iter();
        let shares: Vec<Option<f64>> = self
            .is_used
            .iter()
            .map(|used| if *used { free.next().map(|x| normal_cdf(*x)) } else { None })
            .collect();
        let variant = self.scenario.variant(&shares);
        let space = self.via_space(&variant)?;
        let mut candidate = space.decode(id, white);
        candidate.dwell_s = variant.dwell_s;
        candidate.pace = self.pace.map(|spread| Pace::of_white(paces, spread));
        if let Some(most) = self.turn_rad {
            // White rotation vectors, as smooth as the offsets; half of the bound in mid-path.
            let still = Pose::identity();
            let space = ViaSpace::new(self.vias, &still, &still, 0.5 * most)?;
            candidate.turns = space.decode("", turns).vias;
        }
        Some(Choice { candidate, variant })
    }

    /// The numbers of the via-points, of the pace, of the tool's turns and of the freedoms.
    fn parts<'x>(&self, x: &'x [f64]) -> Option<[&'x [f64]; 4]> {
        let (route, rest) = x.split_at_checked(self.route())?;
        let (paces, rest) = rest.split_at_checked(self.paces())?;
        let (turns, free) = rest.split_at_checked(self.turns())?;
        Some([route, paces, turns, free])
    }

    /// A point of another space of this scenario in this one: what is not free there has the scenario's
    /// own value, what is not free here is left out.
    pub(super) fn carried(&self, from: &Self, x: &[f64]) -> Option<Vec<f64>> {
        let [route, paces, turns, free] = from.parts(x)?;
        let mut all = Vec::with_capacity(self.dimension());
        for (there, count) in [(route, self.route()), (paces, self.paces()), (turns, self.turns())]
        {
            all.extend((0..count).map(|i| there.get(i).copied().unwrap_or(0.0)));
        }
        let mut free = free.iter();
        let used = self.is_used.iter().zip(&from.is_used);
        for ((here, there), range) in used.zip(&self.scenario.free.all) {
            let number = if *there { free.next().copied() } else { None };
            let own = || {
                let own = normal_quantile(self.scenario.own_share(range));
                own.clamp(-FARTHEST, FARTHEST)
            };
            if *here {
                all.push(number.unwrap_or_else(own));
            }
        }
        (all.len() == self.dimension()).then_some(all)
    }

    /// What a variant chooses besides the path.
    pub(super) fn chosen(&self, variant: &Variant) -> Vec<Chosen> {
        self.scenario.chosen(variant)
    }

    /// Search variables of the named families, the straight path first; freedoms in mid-range.
    pub(super) fn seeds(&self) -> Vec<Vec<f64>> {
        let middle = vec![0.0; self.dimension()];
        if !self.has_route || self.offset_rms_m <= STRAIGHT_M {
            return vec![middle];
        }
        let Some(nominal) = self.decode("", &middle) else { return Vec::new() };
        let Some(space) = self.via_space(&nominal.variant) else { return Vec::new() };
        let bent = |offset: &Vec3| {
            let mut x = space.encode(&space.bent("", Family::Sampled, offset))?;
            x.resize(self.dimension(), 0.0);
            Some(x)
        };
        let families = self.families();
        families.iter().filter_map(|(_, _, offset)| bent(offset)).collect()
    }

    /// The named families at the scenario's own values.
    pub(super) fn named(&self) -> Vec<Choice> {
        let variant = self.scenario.nominal();
        let Some(space) = self.via_space(&variant) else { return Vec::new() };
        let choice = |(id, family, offset): &(&str, Family, Vec3)| {
            let dwell_s = variant.dwell_s;
            let candidate = Candidate { dwell_s, ..space.bent(*id, *family, offset) };
            Choice { candidate, variant: variant.clone() }
        };
        let mut all: Vec<Choice> = self.families().iter().map(choice).collect();
        all.push(choice(&("expert_arc", Family::ExpertArc, self.expert_offset())));
        all
    }

    fn via_space(&self, variant: &Variant) -> Option<ViaSpace> {
        ViaSpace::new(self.vias, &variant.start, &variant.goal, self.offset_rms_m)
    }

    fn families(&self) -> [(&'static str, Family, Vec3); 5] {
        let (up, body) = (
            Vec3::z() * self.named_offset_m,
            toward_body(self.scenario, &self.scenario.nominal()) * self.named_offset_m,
        );
        [
            ("straight", Family::Straight, Vec3::zeros()),
            ("lifted", Family::Lifted, up),
            ("lowered", Family::Lowered, -up),
            ("toward_body", Family::TowardBody, body),
            ("away", Family::Away, -body),
        ]
    }

    /// What an expert would draw: the middle of the path at elbow height, a hand's breadth nearer.
    fn expert_offset(&self) -> Vec3 {
        let s = self.scenario;
        let middle = f64::midpoint(s.start.translation.vector.z, s.goal.translation.vector.z);
        let bodies = &s.worker.bodies;
        let elbow = |b: &crate::human::Body| {
            // Seated, the elbow comes down with the pelvis.
            let pelvis = |stance| b.pelvis_pose([0.0; 2], 0.0, stance).translation.vector.z;
            let standing = crate::human::Stance::Standing { shoe_m: 0.0 };
            ELBOW_HEIGHT * b.size.stature_m + pelvis(s.worker.stance) - pelvis(standing)
        };
        let mean = bodies.iter().map(elbow).sum::<f64>() / bodies.len().max(1) as f64;
        Vec3::z() * (mean - middle)
            + toward_body(self.scenario, &self.scenario.nominal()) * EXPERT_PULL_M
    }
}

/// What a search goes without: each freedom, and all of them where there are several.
pub(super) fn held(free: &Freedoms) -> Vec<&'static str> {
    let mut names = free.names();
    if names.len() > 1 {
        names.push(ANY_FREEDOM);
    }
    names
}

/// Horizontal direction from the middle of the task to the worker, of unit length.
pub(super) fn toward_body(scenario: &Scenario, variant: &Variant) -> Vec3 {
    let middle = (variant.start.translation.vector + variant.goal.translation.vector) * 0.5;
    let [x, y] = variant.at_m;
    let to = Vec3::new(x - middle.x, y - middle.y, 0.0);
    // Standing on top of the task: backwards is towards the body.
    let facing = scenario.worker.facing;
    let back = Vec3::new(-facing.cos(), -facing.sin(), 0.0);
    if to.norm() > 1e-3 { to.normalize() } else { back }
}
