//! The cell, the worker and the posture model, and what is not modelled.

use crate::human::{BodySize, Hands, Sex, Stance};
use crate::planner::{BodyFacts, ModelSummary, NotModelled, Setting, StartKind, WorkerFacts};
use crate::posture::Hold;
use crate::scenario::{Adaptation, EndMismatch, MeshFacts, Warning};

/// A body with its size.
pub fn body(b: &BodyFacts) -> String {
    format!("{}: {}", b.name, who(b))
}

/// Who a body is: its size, or that of the people for whom it stands.
pub fn who(b: &BodyFacts) -> String {
    if b.members.is_empty() {
        return size(&b.size);
    }
    let women = b.members.iter().filter(|m| m.sex == Sex::Female).count();
    let range = |of: fn(&BodySize) -> f64| {
        let all = || b.members.iter().map(of);
        (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max))
    };
    let (short, tall) = range(|m| m.stature_m);
    let (light, heavy) = range(|m| m.mass_kg);
    format!(
        "{} people, {women} women and {} men, stature {short:.2} to {tall:.2} m, {light:.0} to {heavy:.0} kg, with \
         the spread of sizes and proportions of the ANSUR II survey",
        b.members.len(),
        b.members.len() - women
    )
}

/// A size.
pub fn size(s: &BodySize) -> String {
    format!("{}, stature {} m, {} kg", s.sex, s.stature_m, s.mass_kg)
}

/// All bodies of a cell, a line each.
pub fn bodies(s: &Setting) -> Vec<String> {
    s.bodies.iter().map(body).collect()
}

/// An obstacle that is a mesh, and what stands for it.
pub fn mesh(m: &MeshFacts) -> String {
    let parts = match m.parts {
        1 => "one convex body holds it and stands".to_owned(),
        n => format!("{n} convex parts hold it and stand"),
    };
    format!(
        "obstacle `{}` from {} ({} triangles, in {}): {parts} out by at most {:.0} mm",
        m.name,
        m.file,
        m.triangles,
        m.units.symbol(),
        (1e3 * m.stands_out_m).ceil()
    )
}

/// Who works where and how, a line each.
pub fn worker(w: &WorkerFacts) -> Vec<String> {
    let stance = match w.stance {
        Stance::Standing { shoe_m } => format!("standing, shoe soles {shoe_m} m thick"),
        Stance::Seated { seat_height_m, footrest_m: 0.0 } => {
            format!("seated, seat height {seat_height_m} m")
        }
        Stance::Seated { seat_height_m, footrest_m } => {
            format!("seated, seat height {seat_height_m} m, feet on a rest at {footrest_m} m")
        }
    };
    let hold = match w.hold {
        Hold::Rigid => "the robot prescribes the position and orientation of the hand",
        Hold::FreeRoll => "the hand may turn about the bar that it holds",
        Hold::Point | Hold::Planar => "the robot prescribes only the position of the hand",
    };
    let start = match w.start {
        StartKind::Sampled => "start postures: drawn from the person's own",
        StartKind::Mean => "start posture: the person's mean, moved to the start pose",
        StartKind::Given => "start posture: as given, moved to the start pose",
    };
    vec![
        format!("{} on the robot, {stance}", hands(w.hands)),
        format!(
            "{} ({}, {}) m, facing {:.0} deg",
            match (w.stance, w.pelvis_moves, w.may_step) {
                (Stance::Standing { .. }, true, true) => "feet at first on either side of",
                (Stance::Standing { .. }, true, false) => "feet planted on either side of",
                _ => "pelvis above",
            },
            w.at_m[0],
            w.at_m[1],
            w.facing.to_degrees()
        ),
        hold.to_owned(),
        start.to_owned(),
        "assumed for the distance to the robot: limbs as thick as cylinders of their mass, a trunk 0.7 times as \
         deep as it is wide"
            .to_owned(),
    ]
}

/// Which hands hold on to the robot.
pub fn hands(hands: Hands) -> &'static str {
    match hands {
        Hands::Right => "right hand",
        Hands::Left => "left hand",
        Hands::Both => "both hands",
    }
}

/// On which body a posture model was learned, and to which it is applied.
pub fn learned_on(m: &ModelSummary) -> String {
    let on = &m.learned_on;
    format!(
        "learned on body `{}` ({}), applied to {}",
        on.name,
        size(&on.size),
        m.applied_to.join(", ")
    )
}

/// Something that no figure takes into account.
pub fn not_modelled(n: NotModelled) -> &'static str {
    match n {
        NotModelled::Legs => {
            "pelvis and legs: the pelvis stays where it is; steps and bending knees are not predicted"
        }
        NotModelled::Steps => {
            "steps: the feet stay where they are, an assumption of the cell; free people step for low and far places"
        }
        NotModelled::HowToStep => {
            "how a step is made: both feet go to their next place together, in half a second, and count as \
             standing on both while they do"
        }
        NotModelled::Forces => {
            "forces: only the load in kilograms enters the scores; no dynamics of the body or the robot"
        }
        NotModelled::Contact => {
            "contact: distances are between capsules, and the hand and forearm on the handle may touch the robot's \
             wrist; the margin to the person is a planning margin, not a safety function"
        }
        NotModelled::Fatigue => {
            "fatigue and recovery over a shift; each posture of one movement is scored by itself"
        }
        NotModelled::Between => {
            "the time at the goal and between two cycles: only the movement itself is scored"
        }
        NotModelled::Safety => {
            "safety: nothing here certifies conformity with ISO 10218, ISO/TS 15066 or any other standard"
        }
        NotModelled::OtherArm => "the other arm: unknown and not scored",
    }
}

/// What the reader of a scenario should know.
pub fn warning(w: &Warning) -> String {
    match w {
        Warning::WholeLoad { mass_kg } => format!(
            "task.human_load_share is not given: the worker is assumed to carry the whole {mass_kg} kg"
        ),
        Warning::Doubtful { path: None, doubt } => doubt.warning(),
        Warning::Doubtful { path: Some(path), doubt } => {
            format!("path `{path}`, {}", doubt.warning())
        }
        Warning::OnlyTcp { path } => format!(
            "path `{path}` gives only the TCP: the arm's postures along it are chosen here, and its distances \
             to people and things may differ from those under your controller; columns with the robot's \
             joints would fix them"
        ),
        Warning::Adapted(Adaptation::Mirrored) => {
            "the posture model was learned with the other hand: its mirror image is used".to_owned()
        }
        Warning::Adapted(Adaptation::BothFromOne) => {
            "the posture model was learned with one hand: the second arm moves as the mirror image of the first"
                .to_owned()
        }
        Warning::Adapted(Adaptation::OnSeat) => {
            "the posture model was learned standing: on the seat its pelvis only turns".to_owned()
        }
        Warning::Adapted(Adaptation::PelvisFixed) => {
            "the pelvis is fixed, as the scenario says: the rest of the body is predicted given that".to_owned()
        }
        Warning::Adapted(Adaptation::OneWay) => {
            "the posture model tells straighter and bent knees apart by where people stand; the planner may choose \
             that here, so both are one broad way"
                .to_owned()
        }
        Warning::FacesAway(away) => format!(
            "the worker faces {:.0} deg away from the middle of the task; worker.facing_deg = {:.0} would \
             face it",
            away.off_deg, away.wanted_deg
        ),
        Warning::NoChecksum { file } => format!(
            "{file} carries no checksum: edits of its figures since it was written cannot be seen"
        ),
        Warning::OtherBody { body } => format!(
            "body `{body}` is not what `ergopath body` makes of its size: its lengths, masses and limits are those \
             of its files, as somebody or another version left them"
        ),
    }
}

/// That a user's path is another movement than the scenario's.
pub fn other_movement(path: &str, ends: &EndMismatch) -> String {
    format!(
        "path `{path}` {ends}: it is another movement, so it is scored but compared with no other path"
    )
}
