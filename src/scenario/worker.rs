//! Who works, where, and in which posture.

use super::file::{OtherArm, StanceFile, WorkerFile};
use super::plausible;
use super::source::Source;
use crate::files::{InputError, NumericTable};
use crate::human::{Body, Side, Stance};
use crate::posture::{PostureModel, StartRule, load_model};
use crate::survey::NeckRule;
use std::path::Path;

/// The worker of a scenario.
#[derive(Debug, Clone)]
pub struct Worker {
    /// Bodies, the first is the main one.
    pub bodies: Vec<Body>,
    /// The posture model.
    pub model: PostureModel,
    /// SHA-256 of the model's file.
    pub model_sha256: String,
    /// The coupled side.
    pub side: Side,
    /// Standing or seated.
    pub stance: Stance,
    /// Floor point below the pelvis, m.
    pub at_m: [f64; 2],
    /// Facing, rad about world z.
    pub facing: f64,
    /// A backrest supports the trunk.
    pub trunk_supported: bool,
    /// The arm is supported.
    pub arm_supported: bool,
    /// How the start posture is chosen.
    pub start_rule: StartRule,
    /// How the head is held.
    pub neck: NeckRule,
    /// What is known of the other arm.
    pub other_arm: OtherArm,
}

pub(super) fn resolve_worker(source: &Source, file: &WorkerFile) -> Result<Worker, InputError> {
    let names = file.bodies.get_ref();
    if names.is_empty() {
        return Err(source
            .error(&file.bodies, "worker.bodies is empty")
            .remedy("name at least one"));
    }
    let bodies: Result<Vec<Body>, InputError> = names
        .iter()
        .map(|n| {
            Body::load(n.get_ref(), source.folder).map_err(|e| source.named(n, "worker.bodies", e))
        })
        .collect();
    let bodies = bodies?;
    let named_model = &file.posture_model;
    let (model, model_sha256) = load_model(named_model.get_ref(), source.folder)
        .map_err(|e| source.named(named_model, "worker.posture_model", e))?;
    if model.side != file.side {
        return Err(source
            .error(
                named_model,
                format!(
                    "posture model `{}` was learned on the {:?} arm, the scenario couples the {:?} hand",
                    named_model.get_ref(),
                    model.side,
                    file.side
                ),
            )
            .remedy("set worker.side, or train a model for this side"));
    }
    let stance = match (file.stance, file.seat_height_m) {
        (StanceFile::Standing, None) => {
            if !(0.0..=0.3).contains(&file.shoe_m) {
                let message = format!("worker.shoe_m = {} is outside 0 to 0.3", file.shoe_m);
                return Err(source.plain(message));
            }
            Stance::Standing { shoe_m: file.shoe_m }
        }
        (StanceFile::Seated, Some(h)) if (0.1..=1.2).contains(&h) => {
            Stance::Seated { seat_height_m: h }
        }
        (StanceFile::Seated, Some(h)) => {
            return Err(source.plain(format!("worker.seat_height_m = {h} is outside 0.1 to 1.2")));
        }
        (StanceFile::Seated, None) => {
            return Err(source
                .plain("worker.stance is seated, but worker.seat_height_m is missing")
                .remedy(
                    "give the height of the seat in metres, for example seat_height_m = 0.45",
                ));
        }
        (StanceFile::Standing, Some(_)) => {
            return Err(source
                .plain("worker.seat_height_m is given, but worker.stance is standing")
                .remedy("remove it, or set stance = \"seated\""));
        }
    };
    let at = file.at_m.get_ref();
    source.refuse_far("worker.at_m", at).map_err(|e| source.at(&file.at_m, e))?;
    let facing = source.number(&file.facing_deg, "worker.facing_deg", -720.0, 720.0)?;
    source.doubt(plausible::radians("worker.facing_deg", &[facing]));
    let trunk_supported = file.trunk_supported.as_ref().is_some_and(|s| *s.get_ref());
    if let (true, Stance::Standing { .. }, Some(at)) =
        (trunk_supported, stance, &file.trunk_supported)
    {
        return Err(source
            .error(at, "worker.trunk_supported = true, but the worker stands")
            .remedy("a backrest supports who sits: remove it, or set stance = \"seated\""));
    }
    let start_rule = match file.start_posture.0.as_str() {
        "sampled" => StartRule::Sampled,
        "mean" => StartRule::Mean,
        name => given_posture(source, &bodies, file.side, name)?,
    };
    Ok(Worker {
        bodies,
        model,
        model_sha256,
        side: file.side,
        stance,
        at_m: *at,
        facing: facing.to_radians(),
        trunk_supported,
        arm_supported: file.arm_supported,
        start_rule,
        neck: file.neck,
        other_arm: file.other_arm,
    })
}

/// A start posture from a CSV with one row of joint angles (rad), named as the joints.
fn given_posture(
    source: &Source,
    bodies: &[Body],
    side: Side,
    name: &str,
) -> Result<StartRule, InputError> {
    if !Path::new(name).extension().is_some_and(|x| x.eq_ignore_ascii_case("csv")) {
        return Err(source
            .plain(format!("worker.start_posture = \"{name}\" is not known"))
            .remedy("use \"sampled\", \"mean\", or the name of a CSV file of joint angles"));
    }
    let table = NumericTable::read(&source.folder.join(name))?;
    let arm = bodies[0].arm(side)?;
    let values: Result<Vec<f64>, InputError> = arm
        .joints()
        .iter()
        .map(|j| {
            let with_unit = format!("{}_rad", j.name);
            let key = if table.columns.contains(&with_unit) { &with_unit } else { &j.name };
            Ok(table.rows[0][table.index(key)?])
        })
        .collect();
    Ok(StartRule::Given(values?))
}
