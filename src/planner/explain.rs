//! The run in words: verdict, comparisons, origins of inputs, assumptions.

use super::causes::nothing_feasible;
use super::evaluate::Walks;
use super::result::{
    BodyScores, CandidateResult, Comparison, Evaluated, IfChanged, InputOrigin, ModelSummary,
    Setting, Status, Verdict,
};
use super::searches::{ANY_FREEDOM, WITHOUT, held};
use super::timing::lingering;
use crate::ergonomics::{paired_difference, rula_action_level, rula_action_words};
use crate::human::Stance;
use crate::posture::{Hold, StartRule};
use crate::robot::Obstacle;
use crate::scenario::{Origin, OtherArm, Scenario};
use crate::survey::{Lens, NeckRule};

/// The words that must stand in the verdict of a model that is not of the worker concerned.
const CAVEAT: &str = "demonstration model, not your workers";

/// The best feasible path of the report.
fn best(candidates: &[CandidateResult]) -> Option<&CandidateResult> {
    candidates.iter().find(|c| {
        c.status == Status::Feasible && c.evaluated == Evaluated::Reported && c.ends.is_none()
    })
}

/// Index of the body with the highest expected RULA.
pub(super) fn worst_index(bodies: &[BodyScores]) -> Option<usize> {
    let by_rula =
        |a: &usize, b: &usize| bodies[*a].rula.expected.total_cmp(&bodies[*b].rula.expected);
    (0..bodies.len()).max_by(by_rula)
}

fn worst_body(candidate: &CandidateResult) -> Option<&BodyScores> {
    worst_index(&candidate.bodies).map(|i| &candidate.bodies[i])
}

/// The best path against every other path of the report, for every body.
pub(super) fn comparisons(candidates: &[CandidateResult]) -> Vec<Comparison> {
    let Some(best) = best(candidates) else { return Vec::new() };
    let is_other = |c: &&CandidateResult| {
        c.id != best.id && c.evaluated == Evaluated::Reported && c.ends.is_none()
    };
    let others = candidates.iter().filter(is_other);
    let mut all = Vec::new();
    for other in others {
        for (a, b) in best.bodies.iter().zip(&other.bodies) {
            let rula = paired_difference(&a.rula_by_rollout, &b.rula_by_rollout);
            let [mine, its] = [&best.id, &other.id].map(|id| format!("`{id}`"));
            all.push(Comparison {
                best: best.id.clone(),
                other: other.id.clone(),
                body: a.body.clone(),
                words: rula.sentence("expected RULA", &mine, &its),
                rula,
            });
        }
    }
    all
}

pub(super) fn verdict(
    scenario: &Scenario,
    candidates: &[CandidateResult],
    comparisons: &[Comparison],
    inputs: &[InputOrigin],
) -> Verdict {
    let caveat = caveat(scenario);
    let Some(best) = best(candidates) else {
        return nothing_feasible(candidates, caveat);
    };
    let Some(body) = worst_body(best) else {
        return nothing_feasible(candidates, caveat);
    };
    let level = rula_action_level(body.rula.expected.round() as u8);
    let [exposure, low, high] = body.exposure_rula_5_band;
    let headline = format!(
        "Path `{}`: {} of the time at RULA action level 3 or above (90 % of repetitions: {} to {})",
        best.id,
        percent(exposure),
        percent(low),
        percent(high),
    );
    let mut lines = vec![format!(
        "Expected RULA {:.2} (90 % band {:.2} to {:.2}, standard error {:.2}), near action level {level}: {}. \
         Expected REBA {:.2} ({:.2} to {:.2}). These are means of ordinal scores, over people and time.",
        body.rula.expected,
        body.rula.p05,
        body.rula.p95,
        body.rula.standard_error.unwrap_or(f64::NAN),
        rula_action_words(level),
        body.reba.expected,
        body.reba.p05,
        body.reba.p95,
    )];
    if best.id != "straight" {
        lines.extend(against("straight", "the straight path", comparisons));
    }
    for own in candidates.iter().filter(|c| is_users(scenario, &c.id) && c.id != best.id) {
        lines.extend(against(&own.id, &format!("your path `{}`", own.id), comparisons));
    }
    if !best.chosen.is_empty() {
        lines.push(format!("Chosen with it: {}.", best.chosen.join("; ")));
    }
    lines.extend(best.path.as_ref().and_then(lingering));
    lines.extend(worth(scenario, &best.id, comparisons, &body.body));
    if best.bodies.len() > 1 {
        lines.push(format!("Figures are for the worst body, {}.", body.body));
    }
    if body.reach_exceeded > 0.0 {
        lines.push(format!(
            "In {} of the rollouts the hand cannot follow (first at {:.2} s); they count as the worst \
             score from there on.",
            percent(body.reach_exceeded),
            body.reach_exceeded_from_s.unwrap_or(0.0)
        ));
    }
    if let Some(muscle) = inputs.iter().find(|i| i.input == "muscle use")
        && let Some(change) = &muscle.if_changed
    {
        lines.push(format!(
            "If the task repeats more than 4 times a minute or is held over a minute: RULA {:.2}, REBA \
             {:.2} (cycles_per_min and hold_s are not both given).",
            body.rula.expected + change.rula,
            body.reba.expected + change.reba,
        ));
    }
    Verdict { headline, lines, best: Some(best.id.clone()), changes: Vec::new(), caveat }
}

fn is_users(scenario: &Scenario, id: &str) -> bool {
    scenario.paths.iter().any(|p| p.name == id) || scenario.drawn.iter().any(|d| d.id == id)
}

/// The best path against another: a sentence for each body.
fn against(id: &str, name: &str, comparisons: &[Comparison]) -> Vec<String> {
    let found: Vec<&Comparison> = comparisons.iter().filter(|c| c.other == id).collect();
    let sentence = |c: &&Comparison| {
        let text = c.rula.sentence("expected RULA", "this path", name);
        if found.len() > 1 { format!("Body {}: {text}", c.body) } else { text }
    };
    found.iter().map(sentence).collect()
}

/// What each freedom is worth: the best path against the best that was found without it.
fn worth(scenario: &Scenario, best: &str, comparisons: &[Comparison], body: &str) -> Vec<String> {
    let of = |name: &str| {
        let id = format!("{WITHOUT}{name}");
        let what = match name {
            ANY_FREEDOM => "All freedoms together".to_owned(),
            _ => format!("Freedom of the {name}"),
        };
        if id == best {
            return Some(format!("{what}: worth nothing that this search has found."));
        }
        let found = comparisons.iter().find(|c| c.other == id && c.body == body)?;
        let d = &found.rula;
        Some(if d.clear {
            format!(
                "{what}: worth {:.2} of expected RULA (95 % interval {:.2} to {:.2}).",
                -d.mean, -d.high95, -d.low95
            )
        } else {
            format!("{what}: no clear difference ({:+.2}).", -d.mean)
        })
    };
    held(&scenario.free).into_iter().filter_map(of).collect()
}

fn caveat(scenario: &Scenario) -> Option<String> {
    let model = &scenario.worker.model;
    let other_body = scenario.worker.bodies.iter().any(|b| b.size != model.size);
    (model.provenance.simulated || other_body).then(|| CAVEAT.to_owned())
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// The inputs of the scores, where they come from, and what one class more would change for the
/// person of `walks`: the body of the verdict on the best path.
pub(super) fn inputs(scenario: &Scenario, lens: &Lens, walks: Option<&Walks>) -> Vec<InputOrigin> {
    let now = walks.map(|w| (w, w.expected(lens)));
    let look = Look { lens, now };
    let mut all = posture_inputs(scenario, &look);
    all.extend(task_inputs(scenario, &look));
    all
}

/// The best path's walks, to be scored under other assumptions.
struct Look<'a> {
    lens: &'a Lens,
    now: Option<(&'a Walks, (f64, f64))>,
}

impl Look<'_> {
    fn changed(&self, to: &str, change: impl Fn(&mut Lens)) -> Option<IfChanged> {
        let (walks, (rula, reba)) = self.now.as_ref()?;
        let mut other = self.lens.clone();
        change(&mut other);
        let (r, b) = walks.expected(&other);
        Some(IfChanged { to: to.to_owned(), rula: r - rula, reba: b - reba })
    }
}

fn input(name: &str, origin: Origin, value: &str, if_changed: Option<IfChanged>) -> InputOrigin {
    InputOrigin { input: name.to_owned(), origin, value: value.to_owned(), if_changed }
}

fn given(given: bool) -> Origin {
    if given { Origin::FromTheTask } else { Origin::Assumed }
}

fn posture_inputs(scenario: &Scenario, look: &Look) -> Vec<InputOrigin> {
    let worker = &scenario.worker;
    let side = worker.side.prefix().to_lowercase();
    let neck = |rule| match rule {
        NeckRule::Neutral => "in line with the trunk",
        NeckRule::Gaze => "turned to the hand",
    };
    let other_neck = match worker.neck {
        NeckRule::Neutral => NeckRule::Gaze,
        NeckRule::Gaze => NeckRule::Neutral,
    };
    let (arm_origin, arm) = match worker.other_arm {
        OtherArm::Unknown => (Origin::Unknown, "not scored"),
        OtherArm::Hanging => (Origin::FromTheTask, "hanging"),
    };
    let legs = match worker.stance {
        Stance::Seated { .. } => "seated, feet supported",
        Stance::Standing { .. } => "standing, weight on both, knees straight",
    };
    let other_neck_name = neck(other_neck);
    vec![
        input(&format!("{side} arm, girdle, trunk"), Origin::Predicted, "posture model", None),
        input("other arm", arm_origin, arm, None),
        input(
            "neck",
            Origin::Assumed,
            neck(worker.neck),
            look.changed(other_neck_name, |l| l.neck = other_neck),
        ),
        input(
            "legs",
            Origin::Assumed,
            legs,
            look.changed("weight on one leg", |l| l.task.legs_unbalanced = true),
        ),
        input(
            "support of the arm",
            given(worker.arm_supported),
            if worker.arm_supported { "supported" } else { "none" },
            None,
        ),
    ]
}

fn task_inputs(scenario: &Scenario, look: &Look) -> Vec<InputOrigin> {
    let task = &scenario.task;
    let load = format!(
        "{:.2} kg (part {} kg x share {}, plus {} kg)",
        task.load_kg, task.part_mass_kg, task.human_load_share, task.extra_load_kg
    );
    // Just into the next class of RULA (2 kg) or REBA (5 and 10 kg).
    let more_load = [2.1, 5.0, 10.1].into_iter().find(|l| *l > task.load_kg);
    let is_used = task.is_repeated() || task.is_static();
    let is_open = task.muscle_origin() == Origin::Assumed;
    let coupling = ["good", "fair", "poor", "unacceptable"][usize::from(task.coupling.min(3))];
    vec![
        input(
            "load",
            task.load_origin,
            &load,
            more_load.and_then(|l| look.changed(&format!("{l} kg"), |x| x.task.load_kg = l)),
        ),
        input("share of the load", task.share_origin, &task.human_load_share.to_string(), None),
        input(
            "muscle use",
            task.muscle_origin(),
            if is_used { "repeated or static" } else { "neither repeated nor static" },
            is_open
                .then(|| {
                    look.changed("repeated over 4 a minute", |l| {
                        l.task.repeated_gt_4min = true;
                        l.task.load_static_or_repeated = true;
                    })
                })
                .flatten(),
        ),
        input(
            "coupling (REBA)",
            task.coupling_origin,
            coupling,
            look.changed("one class worse", |l| l.task.coupling = (l.task.coupling + 1).min(3)),
        ),
        input("shock", given(task.shock), if task.shock { "yes" } else { "none" }, None),
    ]
}

pub(super) fn setting(scenario: &Scenario) -> Setting {
    let w = &scenario.worker;
    let stance = match w.stance {
        Stance::Standing { shoe_m } => format!("standing, shoes {shoe_m} m"),
        Stance::Seated { seat_height_m } => format!("seated at {seat_height_m} m"),
    };
    let hold = match scenario.hold {
        Hold::Rigid => "the robot prescribes position and orientation of the hand",
        Hold::FreeRoll => "the hand may turn about the bar it holds",
        Hold::Point | Hold::Planar => "the robot prescribes the position of the hand only",
    };
    let start = match w.start_rule {
        StartRule::Sampled => "start postures drawn from the person's own",
        StartRule::Mean => "start posture: the person's mean, moved on to the start pose",
        StartRule::Given(_) => "start posture as given, moved on to the start pose",
    };
    let robot = &scenario.robot;
    let mut robot_lines = vec![robot.name.clone()];
    robot_lines.extend(robot.assumed().into_iter().map(|a| format!("assumed: {a}")));
    robot_lines.extend(robot.notes.iter().cloned());
    robot_lines.push(robot.self_collision_note());
    Setting {
        name: scenario.name.clone(),
        description: scenario.description.clone(),
        bodies: w
            .bodies
            .iter()
            .map(|b| {
                format!(
                    "{}: {}, stature {} m, {} kg",
                    b.name, b.size.sex, b.size.stature_m, b.size.mass_kg
                )
            })
            .collect(),
        worker: vec![
            format!("{} hand on the robot, {stance}", w.side.prefix().to_lowercase()),
            format!(
                "pelvis above ({}, {}) m, facing {:.0} deg",
                w.at_m[0],
                w.at_m[1],
                w.facing.to_degrees()
            ),
            hold.to_owned(),
            start.to_owned(),
            "assumed for the distance to the robot: limbs as thick as cylinders of their mass, a trunk 0.7 \
             times as deep as broad, the other arm hanging"
                .to_owned(),
        ],
        robot: robot_lines,
        assumed_limits: scenario.assumed_limits.clone(),
        task: scenario.task.clone(),
        duration_s: scenario.duration_s,
        start_m: scenario.start.translation.vector.into(),
        goal_m: scenario.goal.translation.vector.into(),
        facing: [w.facing.cos(), w.facing.sin()],
        obstacles: scenario.obstacles.iter().map(bounds).collect(),
    }
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
    };
    (name.clone(), low, high)
}

pub(super) fn model_summary(scenario: &Scenario) -> ModelSummary {
    let model = &scenario.worker.model;
    let group = |(name, share): (&str, f64)| (name.to_owned(), share);
    let size = &model.size;
    ModelSummary {
        name: model.name.clone(),
        method: model.method.name().into(),
        simulated: model.provenance.simulated,
        learned_on: format!(
            "learned on body `{}` ({}, {} m, {} kg), applied to {}",
            model.provenance.body.0,
            size.sex,
            size.stature_m,
            size.mass_kg,
            scenario.worker.bodies.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", ")
        ),
        weight_by_group: model.weight_by_group().into_iter().map(group).collect(),
        quality: model.quality.clone(),
        notes: model.provenance.notes.clone(),
    }
}

pub(super) fn not_modelled(scenario: &Scenario) -> Vec<String> {
    let mut all = vec![
        "the pelvis stays where it is; stepping and bending of the legs are not predicted".to_owned(),
        "forces: only the load in kilograms enters the scores, no dynamics of body or robot".to_owned(),
        "contact: distances are between capsules, and the hand and forearm on the handle may be at the \
         robot's wrist; the margin to the person is for planning, not a safety function"
            .to_owned(),
        "fatigue and recovery over a shift; scores are per frame of one movement".to_owned(),
        "safety: nothing here certifies conformity with ISO 10218, ISO/TS 15066 or any other standard".to_owned(),
    ];
    if scenario.worker.other_arm == OtherArm::Unknown {
        all.push("the other arm: unknown, not scored".to_owned());
    }
    all
}
