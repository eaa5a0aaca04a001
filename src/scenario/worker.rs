//! Who works, where, and in which posture.

use super::file::{BodyNames, LookAt, OtherArm, PelvisFile, StanceFile, StepsFile, WorkerFile};
use super::plausible;
use super::source::Source;
use crate::files::{InputError, NumericTable};
use crate::human::{
    Body, Coupled, Hands, PELVIS_JOINTS, POPULATION, Pelvis, Stance, column_of, column_unit,
    workforce,
};
use crate::physical::ANGLE_DEG;
use crate::posture::{PERSONS, PostureModel, StartRule, Unsuitable, load_model};
use crate::survey::NeckRule;
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::Spanned;

/// The worker of a scenario.
#[derive(Debug, Clone)]
pub struct Worker {
    /// Bodies, the first is the main one.
    pub bodies: Vec<Body>,
    /// Of each body the bodies of the people for whom it stands; none where it stands for itself.
    pub members: Vec<Vec<Body>>,
    /// The posture model, for these hands (or their mirror image) and this pelvis.
    pub model: PostureModel,
    /// SHA-256 of the model's file.
    pub model_sha256: String,
    /// The hands on the robot.
    pub hands: Hands,
    /// How the pelvis takes part.
    pub pelvis: Pelvis,
    /// How the model differs from what was learned; `model` is the adapted one.
    pub adaptations: Vec<Adaptation>,
    /// Standing or seated.
    pub stance: Stance,
    /// Whether the feet may be set elsewhere during the movement.
    pub may_step: bool,
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

/// What a posture model had to be changed to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Adaptation {
    /// Learned with the other hand: mirrored.
    Mirrored,
    /// Learned with one hand: the second arm is the mirror image.
    BothFromOne,
    /// Learned standing, used on a seat.
    OnSeat,
    /// The pelvis is fixed by the scenario.
    PelvisFixed,
    /// Modes go by where the feet are, and the planner chooses that: one law of all.
    OneWay,
}

impl Worker {
    /// Which joints of the worker's body are predicted together.
    pub fn coupled(&self) -> Coupled {
        Coupled { hands: self.hands, pelvis: self.pelvis }
    }

    /// Whether the model is of the other hand, so that the mirror image of the worker moves by it.
    pub fn is_mirrored(&self) -> bool {
        self.hands != Hands::Both && self.hands.lead() != self.model.side
    }

    /// Which joints of the worker, or of the mirror image, the model speaks of.
    pub fn modelled(&self) -> Coupled {
        let hands = if self.is_mirrored() { self.model.side.into() } else { self.hands };
        Coupled { hands, pelvis: self.pelvis }
    }
}

pub(super) fn resolve_worker(source: &Source, file: &WorkerFile) -> Result<Worker, InputError> {
    let (bodies, members) = bodies(source, file)?;
    let named_model = &file.posture_model;
    let (model, model_sha256) = load_model(named_model.get_ref(), source.folder)
        .map_err(|e| source.named(named_model, "worker.posture_model", e))?;
    let hands = match (file.hands, file.side) {
        (Some(_), Some(_)) => {
            return Err(source
                .plain("worker.hands and worker.side are both given")
                .remedy("keep worker.hands"));
        }
        (Some(hands), None) => hands,
        (None, side) => side.map_or(Hands::Right, Hands::from),
    };
    let stance = stance(source, file)?;
    let neck = match (file.look_at, file.neck) {
        (None, neck) => neck,
        (Some(LookAt::Part), NeckRule::Predicted) => NeckRule::Looking,
        (Some(LookAt::Part), _) => {
            return Err(source
                .plain("worker.look_at goes with worker.neck = \"predicted\" only")
                .remedy("keep one of the two keys"));
        }
    };
    let at = file.at_m.get_ref();
    source.refuse_far("worker.at_m", at).map_err(|e| source.at(&file.at_m, e))?;
    let facing =
        source.number(&file.facing_deg, "worker.facing_deg", ANGLE_DEG.low, ANGLE_DEG.high)?;
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
        name => given_posture(
            source,
            &bodies,
            Coupled { hands, pelvis: taken(&model, file, stance) },
            name,
        )?,
    };
    let (model, adaptations) = adapted(source, named_model, &model, hands, (file, stance))?;
    let may_step = may_step(source, file, &model, stance)?;
    Ok(Worker {
        bodies,
        members,
        pelvis: model.pelvis(),
        model,
        model_sha256,
        hands,
        adaptations,
        stance,
        may_step,
        at_m: *at,
        facing: facing.to_radians(),
        trunk_supported,
        arm_supported: file.arm_supported,
        start_rule,
        neck,
        other_arm: file.other_arm,
    })
}

/// The bodies, and of each the people for whom it stands.
fn bodies(source: &Source, file: &WorkerFile) -> Result<(Vec<Body>, Vec<Vec<Body>>), InputError> {
    let one;
    let names = match file.bodies.get_ref() {
        BodyNames::One(name) => {
            one = [Spanned::new(file.bodies.span(), name.clone())];
            &one[..]
        }
        BodyNames::Several(names) => names,
    };
    if names.is_empty() {
        return Err(source
            .error(&file.bodies, "worker.bodies is empty")
            .remedy("name at least one"));
    }
    let women = match &file.women_share {
        Some(share) if names.iter().all(|n| n.get_ref() != POPULATION) => {
            return Err(source
                .error(
                    share,
                    "worker.women_share is given, but no body of the scenario is a population",
                )
                .remedy("remove it, or set bodies = \"population\""));
        }
        Some(share) => source.number(share, "worker.women_share", 0.0, 1.0)?,
        None => 0.5,
    };
    let of = |name: &Spanned<String>| match name.get_ref().as_str() {
        POPULATION => workforce(women, PERSONS),
        single => Body::load(single, source.folder)
            .map(|body| (body, Vec::new()))
            .map_err(|e| source.named(name, "worker.bodies", e)),
    };
    names.iter().map(of).collect()
}

/// How the worker stands or sits.
fn stance(source: &Source, file: &WorkerFile) -> Result<Stance, InputError> {
    let stance = match (file.stance, file.seat_height_m) {
        (StanceFile::Standing, None) => {
            if !(0.0..=0.3).contains(&file.shoe_m) {
                let message = format!("worker.shoe_m = {} is outside 0 to 0.3", file.shoe_m);
                return Err(source.plain(message));
            }
            Stance::Standing { shoe_m: file.shoe_m }
        }
        (StanceFile::Seated, Some(h)) if (0.1..=1.2).contains(&h) => {
            let footrest_m = file.footrest_m.unwrap_or(0.0);
            if !(0.0..h).contains(&footrest_m) {
                let message =
                    format!("worker.footrest_m = {footrest_m} is outside 0 to the seat's {h}");
                return Err(source
                    .plain(message)
                    .remedy("give the height of what the feet stand on, in metres"));
            }
            Stance::Seated { seat_height_m: h, footrest_m }
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
    if let (Some(_), Stance::Standing { .. }) = (file.footrest_m, stance) {
        return Err(source
            .plain("worker.footrest_m is given, but worker.stance is standing")
            .remedy("remove it, or set stance = \"seated\""));
    }
    Ok(stance)
}

/// Whether the worker steps, which only who stands on a moving pelvis and whose standing place is known can.
fn may_step(
    source: &Source,
    file: &WorkerFile,
    model: &PostureModel,
    stance: Stance,
) -> Result<bool, InputError> {
    let Some(steps) = file.steps.as_ref().filter(|s| *s.get_ref() == StepsFile::Allowed) else {
        return Ok(false);
    };
    let refused = |message: &str, remedy: &str| Err(source.error(steps, message).remedy(remedy));
    if matches!(stance, Stance::Seated { .. }) {
        return refused(
            "worker.steps is \"allowed\", but the worker sits",
            "remove it, or set stance = \"standing\"",
        );
    }
    if model.pelvis() != Pelvis::Moves {
        return refused(
            "worker.steps is \"allowed\", but the pelvis does not move",
            "use a posture model of whole people, such as \"people\", and leave worker.pelvis at \"predicted\"",
        );
    }
    if model.standing.is_none() {
        return refused(
            "worker.steps is \"allowed\", but the posture model does not know where people stand",
            "use posture_model = \"people\", or train one on recordings of several people with their legs",
        );
    }
    Ok(true)
}

/// How the pelvis takes part: as the model knows it, and as seat and scenario let it.
fn taken(model: &PostureModel, file: &WorkerFile, stance: Stance) -> Pelvis {
    let most = match (file.pelvis, stance) {
        (PelvisFile::Fixed, _) => Pelvis::Rests,
        (PelvisFile::Predicted, Stance::Seated { .. }) => Pelvis::Turns,
        (PelvisFile::Predicted, Stance::Standing { .. }) => Pelvis::Moves,
    };
    if model.pelvis().free() < most.free() { model.pelvis() } else { most }
}

/// The model for the worker's hands and pelvis, and what that changed.
fn adapted(
    source: &Source,
    named: &toml::Spanned<String>,
    model: &PostureModel,
    hands: Hands,
    (file, stance): (&WorkerFile, Stance),
) -> Result<(PostureModel, Vec<Adaptation>), InputError> {
    let pelvis = taken(model, file, stance);
    let is_both = hands == Hands::Both;
    let mut all = Vec::new();
    if !is_both && model.side != hands.lead() {
        all.push(Adaptation::Mirrored);
    }
    if is_both && model.side != hands.lead() {
        return Err(source
            .error(
                named,
                format!("posture model `{}` was learned with the left hand", named.get_ref()),
            )
            .remedy("for both hands use a model of the right hand"));
    }
    if is_both {
        all.push(Adaptation::BothFromOne);
    }
    match (model.pelvis(), pelvis) {
        (Pelvis::Moves, Pelvis::Turns) => all.push(Adaptation::OnSeat),
        (Pelvis::Moves | Pelvis::Turns, Pelvis::Rests) => all.push(Adaptation::PelvisFixed),
        _ => {}
    }
    let adapted = model.adapted(pelvis, is_both).map_err(|why| {
        let message = match why {
            Unsuitable::Method => format!(
                "posture model `{}` (method {}) can only be used as it was learned: one hand, on its own legs",
                named.get_ref(),
                model.method.name()
            ),
            Unsuitable::Singular => format!(
                "posture model `{}` does not say how the rest of the body moves when the pelvis is held",
                named.get_ref()
            ),
        };
        source.error(named, message).remedy("train a model with the method full-w")
    })?;
    Ok((adapted, all))
}

/// A start posture from a CSV with one row of joint angles (rad), named as the joints; without columns of
/// the pelvis it is at rest.
fn given_posture(
    source: &Source,
    bodies: &[Body],
    coupled: Coupled,
    name: &str,
) -> Result<StartRule, InputError> {
    if !Path::new(name).extension().is_some_and(|x| x.eq_ignore_ascii_case("csv")) {
        return Err(source
            .plain(format!("worker.start_posture = \"{name}\" is not known"))
            .remedy("use \"sampled\", \"mean\", or the name of a CSV file of joint angles"));
    }
    let table = NumericTable::read(&source.folder.join(name))?;
    let chain = bodies[0].chain(coupled, &[])?;
    let values: Result<Vec<f64>, InputError> = chain
        .joints()
        .iter()
        .map(|j| {
            let with_unit = column_of(&j.name);
            let key = if table.columns.contains(&with_unit) { &with_unit } else { &j.name };
            if PELVIS_JOINTS.contains(&j.name.as_str()) && !table.columns.contains(key) {
                return Ok(0.0);
            }
            Ok(table.rows[0][table.index(key)?] / column_unit(&j.name, &bodies[0]))
        })
        .collect();
    Ok(StartRule::Given(values?))
}
