//! What a run was made of: inputs of the scores with their origin, the cell, the posture model, what is
//! not modelled.

use super::repetitions::Repetitions;
use super::result::{
    Alternative, BodyFacts, IfChanged, InputOrigin, ModelSummary, NotModelled, ScoreInput, Setting,
    StartKind, WorkerFacts,
};
use crate::ergonomics::PerMethod;
use crate::human::{Body, Hands, Pelvis, Stance};
use crate::posture::StartRule;
use crate::robot::Obstacle;
use crate::scenario::{Origin, OtherArm, Scenario};
use crate::survey::{Lens, NeckRule};

/// The inputs of the scores, where they come from, and what one class more would change for the
/// person of `repetitions`: the body of the verdict on the best path.
pub(super) fn inputs(
    scenario: &Scenario,
    lens: &Lens,
    repetitions: Option<&Repetitions>,
) -> Vec<InputOrigin> {
    let now = repetitions.map(|w| (w, w.expected(lens)));
    let look = Look { lens, now };
    let mut all = posture_inputs(scenario, &look);
    all.extend(task_inputs(scenario, &look));
    all
}

/// The best path's repetitions, to be scored under other assumptions.
struct Look<'a> {
    lens: &'a Lens,
    now: Option<(&'a Repetitions, PerMethod<f64>)>,
}

impl Look<'_> {
    fn changed(&self, to: Alternative, change: impl Fn(&mut Lens)) -> Option<IfChanged> {
        let (repetitions, now) = self.now.as_ref()?;
        let mut other = self.lens.clone();
        change(&mut other);
        let then = repetitions.expected(&other);
        Some(IfChanged { to, change: PerMethod::of(|m| then[m] - now[m]) })
    }
}

fn input(input: ScoreInput, origin: Origin, if_changed: Option<IfChanged>) -> InputOrigin {
    InputOrigin { input, origin, if_changed }
}

fn given(given: bool) -> Origin {
    if given { Origin::FromTheTask } else { Origin::Assumed }
}

fn posture_inputs(scenario: &Scenario, look: &Look) -> Vec<InputOrigin> {
    let worker = &scenario.worker;
    let by_neck = |rule: NeckRule| look.changed(Alternative::Neck(rule), |l| l.neck = rule);
    // The rules that nobody predicts stand beside what is in force.
    let others = [NeckRule::Neutral, NeckRule::Gaze].into_iter().filter(|r| *r != worker.neck);
    let is_both = worker.hands == Hands::Both;
    let arm = match worker.other_arm {
        OtherArm::Unknown => Origin::Unknown,
        OtherArm::Hanging => Origin::FromTheTask,
        OtherArm::Predicted => Origin::Predicted,
    };
    let neck = match worker.neck {
        NeckRule::Predicted | NeckRule::Looking => Origin::Predicted,
        NeckRule::Neutral | NeckRule::Gaze => Origin::Assumed,
    };
    let moves = worker.pelvis != Pelvis::Rests;
    let is_seated = matches!(worker.stance, Stance::Seated { .. });
    let one_leg = look.changed(Alternative::OneLeg, |l| l.task.legs_unbalanced = true);
    let legs = if moves { Origin::Predicted } else { Origin::Assumed };
    let mut all = vec![
        input(ScoreInput::ArmAndTrunk(worker.hands), Origin::Predicted, None),
        input(ScoreInput::Seated(is_seated), Origin::Assumed, one_leg),
        input(
            if worker.may_step { ScoreInput::LegsThatStep } else { ScoreInput::Legs(moves) },
            legs,
            None,
        ),
        input(ScoreInput::ArmSupported(worker.arm_supported), given(worker.arm_supported), None),
    ];
    all.splice(1..1, others.map(|r| input(ScoreInput::Neck(worker.neck), neck, by_neck(r))));
    if !is_both {
        all.insert(1, input(ScoreInput::OtherArm(worker.other_arm), arm, None));
    }
    all
}

fn task_inputs(scenario: &Scenario, look: &Look) -> Vec<InputOrigin> {
    let task = &scenario.task;
    let load = [task.load_kg, task.part_mass_kg, task.human_load_share, task.extra_load_kg];
    // Just into the next class of RULA (2 kg) or REBA (5 and 10 kg).
    let more_load = [2.1, 5.0, 10.1].into_iter().find(|l| *l > task.load_kg);
    let heavier =
        more_load.and_then(|l| look.changed(Alternative::Load(l), |x| x.task.load_kg = l));
    let is_used = task.is_repeated() || task.is_static();
    let is_open = task.muscle_origin() == Origin::Assumed;
    let repeated = || {
        look.changed(Alternative::Repeated, |l| {
            l.task.repeated_gt_4min = true;
            l.task.load_static_or_repeated = true;
        })
    };
    let next = (task.coupling + 1).min(3);
    let looser = look.changed(Alternative::Coupling(next), |l| l.task.coupling = next);
    vec![
        input(ScoreInput::Load(load), task.load_origin, heavier),
        input(ScoreInput::LoadShare(task.human_load_share), task.share_origin, None),
        input(
            ScoreInput::MuscleUse(is_used),
            task.muscle_origin(),
            is_open.then(repeated).flatten(),
        ),
        input(ScoreInput::Coupling(task.coupling), task.coupling_origin, looser),
        input(ScoreInput::Shock(task.shock), given(task.shock), None),
    ]
}

fn body_facts((body, members): (&Body, &Vec<Body>)) -> BodyFacts {
    BodyFacts {
        name: body.name.clone(),
        size: body.size,
        members: members.iter().map(|m| m.size).collect(),
    }
}

pub(super) fn setting(scenario: &Scenario) -> Setting {
    let w = &scenario.worker;
    Setting {
        name: scenario.name.clone(),
        description: scenario.description.clone(),
        bodies: w.bodies.iter().zip(&w.members).map(body_facts).collect(),
        worker: WorkerFacts {
            hands: w.hands,
            pelvis_moves: w.pelvis != Pelvis::Rests,
            may_step: w.may_step,
            stance: w.stance,
            at_m: w.at_m,
            facing: w.facing,
            hold: scenario.hold,
            start: match w.start_rule {
                StartRule::Sampled => StartKind::Sampled,
                StartRule::Mean => StartKind::Mean,
                StartRule::Given(_) => StartKind::Given,
            },
        },
        robot: scenario.robot.facts(),
        assumed_limits: scenario.assumed_limits.clone(),
        task: scenario.task.clone(),
        duration_s: scenario.duration_s,
        start_m: scenario.start.translation.vector.into(),
        goal_m: scenario.goal.translation.vector.into(),
        facing: [w.facing.cos(), w.facing.sin()],
        obstacles: boxes(&scenario.obstacles),
        meshes: scenario.meshes.iter().map(|m| m.facts.clone()).collect(),
    }
}

/// Axis-aligned boxes around obstacles; the parts of a mesh share one.
fn boxes(obstacles: &[(String, Obstacle)]) -> Vec<(String, [f64; 3], [f64; 3])> {
    let mut all: Vec<(String, [f64; 3], [f64; 3])> = Vec::new();
    for (name, low, high) in obstacles.iter().map(bounds) {
        match all.last_mut().filter(|l| l.0 == name) {
            Some((_, l, h)) => (0..3).for_each(|i| {
                l[i] = l[i].min(low[i]);
                h[i] = h[i].max(high[i]);
            }),
            None => all.push((name, low, high)),
        }
    }
    all
}

/// An axis-aligned box around an obstacle.
fn bounds((name, obstacle): &(String, Obstacle)) -> (String, [f64; 3], [f64; 3]) {
    let around = |center: nalgebra::Vector3<f64>, half: nalgebra::Vector3<f64>| {
        ((center - half).into(), (center + half).into())
    };
    let turned = |pose: &crate::math::Pose, half: nalgebra::Vector3<f64>| {
        pose.rotation.to_rotation_matrix().matrix().abs() * half
    };
    let (low, high) = match obstacle {
        Obstacle::Box { pose, size } => around(pose.translation.vector, turned(pose, size * 0.5)),
        Obstacle::Sphere { center, radius } => around(*center, nalgebra::Vector3::repeat(*radius)),
        Obstacle::Capsule { a, b, radius } => {
            around((a + b) * 0.5, (a - b).abs() * 0.5 + nalgebra::Vector3::repeat(*radius))
        }
        Obstacle::Cylinder { pose, radius, length } => around(
            pose.translation.vector,
            turned(pose, nalgebra::Vector3::new(*radius, *radius, 0.5 * length)),
        ),
        Obstacle::Hull(hull) => {
            let (low, high) = hull.bounds();
            (low.into(), high.into())
        }
    };
    (name.clone(), low, high)
}

pub(super) fn model_summary(scenario: &Scenario) -> ModelSummary {
    let model = &scenario.worker.model;
    let group = |(name, share): (&str, f64)| (name.to_owned(), share);
    ModelSummary {
        name: model.name.clone(),
        method: model.method.name().into(),
        simulated: model.provenance.simulated,
        learned_on: BodyFacts {
            name: model.provenance.body.0.clone(),
            size: model.size,
            members: Vec::new(),
        },
        applied_to: scenario.worker.bodies.iter().map(|b| b.name.clone()).collect(),
        weight_by_group: model.weight_by_group().into_iter().map(group).collect(),
        quality: model.quality.clone(),
        notes: model.provenance.notes.clone(),
    }
}

pub(super) fn not_modelled(scenario: &Scenario) -> Vec<NotModelled> {
    let w = &scenario.worker;
    let is_unknown = w.other_arm == OtherArm::Unknown && w.hands != Hands::Both;
    let stands = match w.pelvis {
        Pelvis::Rests => NotModelled::Legs,
        Pelvis::Turns | Pelvis::Moves if w.may_step => NotModelled::HowToStep,
        Pelvis::Turns | Pelvis::Moves => NotModelled::Steps,
    };
    let all = [
        stands,
        NotModelled::Forces,
        NotModelled::Contact,
        NotModelled::Fatigue,
        NotModelled::Between,
        NotModelled::Safety,
    ];
    all.into_iter().chain(is_unknown.then_some(NotModelled::OtherArm)).collect()
}
