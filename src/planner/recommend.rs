//! What would lower the score of the best path: small changes of where the worker stands, of the
//! handle and of the load, each tried on the same people.
//!
//! Path and robot stay as they are, so that a change needs no new plan. The hand's reach is part of
//! the figures, and a change that brings people too near to the robot is left out.

use super::evaluate::Person;
use super::near::Care;
use super::objective::Figures;
use super::pipeline::Environment;
use super::prepare::Prepared;
use super::result::{Recommendation, Recommendations};
use super::search::near;
use crate::ergonomics::paired_difference;
use crate::human::Stance;
use crate::math::stats::mean;
use crate::math::{Pose, Vec3};
use crate::scenario::Variant;
use crate::survey::Lens;
use nalgebra::UnitQuaternion;

/// Steps that are tried, m and deg.
const LENGTHS_M: [f64; 2] = [0.05, 0.10];
const ANGLES_DEG: [f64; 2] = [10.0, 20.0];
/// Least gain in expected RULA that is worth a sentence.
const LEAST_GAIN: f64 = 0.02;
/// Most people behind an effect.
const PEOPLE: usize = 32;
/// Block of people: others than those that chose and reported a path.
const BLOCK: u32 = 4;

/// One change: in words, what it is about, and the cell with it.
struct Tried {
    what: String,
    /// Changes of one direction; the best of them is told.
    direction: &'static str,
    variant: Variant,
    load_share: f64,
}

impl Environment<'_> {
    /// Changes that clearly lower the expected RULA of a path for one person, best first.
    pub(super) fn recommend(&self, prepared: &Prepared, person: &Person) -> Recommendations {
        let nothing = Recommendations { tried: 0, people: 0, clear: Vec::new() };
        let Some(path) = &prepared.path else { return nothing };
        let people = PEOPLE.min(self.preset.rollouts_final);
        let robot = self.workshop.robot_of(&prepared.variant);
        let arm = prepared.arm(&robot, Care::Selection);
        let figures = |variant: &Variant, load_share: f64| {
            let mut lens: Lens = self.lens.clone();
            lens.task.load_kg *= load_share;
            let walks = person.walk(path, variant, (self.seed, BLOCK), 0..people);
            let there = Prepared { variant: variant.clone(), ..prepared.clone() };
            let (near_m, _) = near(person, &walks, &(0..people), (arm.as_ref(), &there));
            Figures { near_m, ..Figures::of(&walks, &lens) }
        };
        let margin = &self.scenario.person_margin;
        let is_too_near = |f: &Figures| {
            let below = f.near_m.iter().filter(|d| **d < margin.margin_m).count() as f64;
            below > margin.share * f.near_m.len() as f64
        };
        let now = figures(&prepared.variant, 1.0);
        let all = self.changes(&prepared.variant);
        let mut clear: Vec<(&str, Recommendation)> = Vec::new();
        for t in &all {
            let then = figures(&t.variant, t.load_share);
            let rula = paired_difference(&then.rula, &now.rula);
            let is_worse = mean(&then.lost) > mean(&now.lost) || is_too_near(&then);
            if !rula.clear || rula.mean > -LEAST_GAIN || is_worse {
                continue;
            }
            let found = Recommendation {
                what: t.what.clone(),
                rula,
                expected_rula: [mean(&now.rula), mean(&then.rula)],
                expected_reba: [mean(&now.reba), mean(&then.reba)],
                exposure_rula_5: [mean(&now.exposure_rula_5), mean(&then.exposure_rula_5)],
            };
            match clear.iter_mut().find(|(d, _)| *d == t.direction) {
                Some((_, known)) if known.rula.mean <= found.rula.mean => {}
                Some((_, known)) => *known = found,
                None => clear.push((t.direction, found)),
            }
        }
        clear.sort_by(|a, b| a.1.rula.mean.total_cmp(&b.1.rula.mean));
        let clear = clear.into_iter().map(|(_, r)| r).collect();
        Recommendations { tried: all.len(), people, clear }
    }

    fn changes(&self, from: &Variant) -> Vec<Tried> {
        let mut all = Vec::new();
        let mut push = |what: String, direction: &'static str, variant: Variant| {
            all.push(Tried { what, direction, variant, load_share: 1.0 });
        };
        let forward = Vec3::new(from.facing.cos(), from.facing.sin(), 0.0);
        let left = Vec3::z().cross(&forward);
        for by in LENGTHS_M {
            let cm = 100.0 * by;
            for (words, direction, way) in [
                ("nearer (forward)", "near", forward),
                ("farther back", "far", -forward),
                ("further to the left", "left", left),
                ("further to the right", "right", -left),
            ] {
                let at_m = [from.at_m[0] + by * way.x, from.at_m[1] + by * way.y];
                let place = match self.scenario.worker.stance {
                    Stance::Standing { .. } => "let the worker stand",
                    Stance::Seated { .. } => "let the worker sit",
                };
                let variant = Variant { at_m, ..from.clone() };
                push(format!("{place} {cm:.0} cm {words}"), direction, variant);
            }
            for (sign, direction) in [(1.0, "up"), (-1.0, "down")] {
                let variant = Variant { floor_m: from.floor_m + sign * by, ..from.clone() };
                let words = match (self.scenario.worker.stance, sign > 0.0) {
                    (Stance::Standing { .. }, true) => {
                        format!("raise the worker by {cm:.0} cm (platform), or lower the cell")
                    }
                    (Stance::Seated { .. }, true) => format!("raise the seat by {cm:.0} cm"),
                    (Stance::Standing { .. }, false) => format!("raise the cell by {cm:.0} cm"),
                    (Stance::Seated { .. }, false) => format!("lower the seat by {cm:.0} cm"),
                };
                push(words, direction, variant);
            }
        }
        for deg in ANGLES_DEG {
            for (sign, side, turn, roll) in [
                (1.0, "left", "turn left", "roll left"),
                (-1.0, "right", "turn right", "roll right"),
            ] {
                let by = sign * f64::to_radians(deg);
                let variant = Variant { facing: from.facing + by, ..from.clone() };
                push(format!("turn the worker by {deg:.0} deg to the {side}"), turn, variant);
                let about = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), by);
                let grip = from.grip * Pose::from_parts(Vec3::zeros().into(), about);
                let sign = if sign > 0.0 { "+" } else { "-" };
                push(
                    format!("turn the handle on the tool by {sign}{deg:.0} deg about its bar"),
                    roll,
                    Variant { grip, ..from.clone() },
                );
            }
        }
        if self.lens.task.load_kg > 0.0 {
            all.push(Tried {
                what: format!(
                    "let the robot carry half of the load ({:.1} kg now)",
                    self.lens.task.load_kg
                ),
                direction: "load",
                variant: from.clone(),
                load_share: 0.5,
            });
        }
        all
    }
}
