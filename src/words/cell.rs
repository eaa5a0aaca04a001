//! Inputs of the scores, changes of the cell and postures to look at.

use crate::human::Hands;
use crate::planner::{
    Alternative, CellChange, MomentKind, Recommendation, ScoreInput, StandingPlace, Way,
};
use crate::scenario::{Origin, OtherArm};
use crate::survey::NeckRule;

/// How the head is held.
fn neck(rule: NeckRule) -> &'static str {
    match rule {
        NeckRule::Predicted => "the head as recorded people hold it, given trunk and hand",
        NeckRule::Looking => "the head turned as far as the eyes need to see the part",
        NeckRule::Neutral => "the head in line with the trunk",
        NeckRule::Gaze => "the head turned to the hand",
    }
}

/// REBA's classes of coupling.
fn coupling(class: u8) -> &'static str {
    ["good", "fair", "poor", "unacceptable"][usize::from(class.min(3))]
}

/// Name and value of an input.
pub fn input(i: &ScoreInput) -> (&'static str, String) {
    let (name, value) = match i {
        ScoreInput::ArmAndTrunk(Hands::Right) => {
            ("right arm, shoulder girdle, trunk", "posture model")
        }
        ScoreInput::ArmAndTrunk(Hands::Left) => {
            ("left arm, shoulder girdle, trunk", "posture model")
        }
        ScoreInput::ArmAndTrunk(Hands::Both) => {
            ("both arms, shoulder girdles, trunk", "posture model")
        }
        ScoreInput::LegsThatStep => ("pelvis and legs", "posture model, on feet that step"),
        ScoreInput::Legs(true) => ("pelvis and legs", "posture model, on feet that stay"),
        ScoreInput::Legs(false) => ("pelvis and legs", "at rest, knees straight"),
        ScoreInput::OtherArm(OtherArm::Predicted) => ("other arm", "hangs under its shoulder"),
        ScoreInput::OtherArm(OtherArm::Unknown) => ("other arm", "not scored"),
        ScoreInput::OtherArm(OtherArm::Hanging) => ("other arm", "hanging"),
        ScoreInput::Neck(rule) => ("neck", neck(*rule)),
        ScoreInput::Seated(true) => ("support", "seated, feet supported"),
        ScoreInput::Seated(false) => ("support", "standing on both feet"),
        ScoreInput::ArmSupported(true) => ("arm support", "supported"),
        ScoreInput::ArmSupported(false) => ("arm support", "none"),
        ScoreInput::Load([load, part, share, extra]) => {
            let value = format!("{load:.2} kg (part {part} kg x share {share}, plus {extra} kg)");
            return ("load", value);
        }
        ScoreInput::LoadShare(share) => return ("worker's share of the load", share.to_string()),
        ScoreInput::MuscleUse(true) => ("muscle use", "repeated or static"),
        ScoreInput::MuscleUse(false) => ("muscle use", "neither repeated nor static"),
        ScoreInput::Coupling(class) => ("coupling (REBA)", coupling(*class)),
        ScoreInput::Shock(true) => ("shock", "yes"),
        ScoreInput::Shock(false) => ("shock", "none"),
    };
    (name, value.to_owned())
}

/// Another value of an input.
pub fn alternative(a: &Alternative) -> String {
    match a {
        Alternative::Neck(rule) => neck(*rule).to_owned(),
        Alternative::OneLeg => "the weight on one leg".to_owned(),
        Alternative::Load(kg) => format!("{kg} kg"),
        Alternative::Repeated => "repeated more than 4 times a minute".to_owned(),
        Alternative::Coupling(class) => coupling(*class).to_owned(),
    }
}

/// Where an input comes from.
pub fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Measured => "measured",
        Origin::Predicted => "predicted by the posture model",
        Origin::FromTheTask => "from the task",
        Origin::Assumed => "assumed",
        Origin::Unknown => "unknown, not scored",
    }
}

/// A standing place from which fewer repetitions reach only just.
pub fn standing_place(place: &StandingPlace) -> String {
    let [now, then] = place.stretched_share.map(super::number::percent);
    format!(
        "In {now} of the repetitions people would step. {}, and they would in {then}.",
        super::number::capital(&cell_change(&CellChange::MoveWorker {
            way: place.way,
            by_m: place.by_m,
            seated: false
        }))
    )
}

/// The moment about L5/S1 without and with a change, where it was looked at.
pub fn low_back(r: &Recommendation) -> Option<String> {
    let [now, then] = r.l5s1_peak_nm?;
    Some(format!("peak moment about L5/S1 {now:.0} \u{2192} {then:.0} N m"))
}

/// A change of the cell, as an instruction.
pub fn cell_change(c: &CellChange) -> String {
    match c {
        CellChange::MoveWorker { way, by_m, seated } => {
            let place = if *seated { "seat the worker" } else { "let the worker stand" };
            let way = match way {
                Way::Nearer => "closer to the task (forwards)",
                Way::Farther => "farther back",
                Way::Left => "farther to the left",
                Way::Right => "farther to the right",
            };
            format!("{place} {:.0} cm {way}", 100.0 * by_m)
        }
        CellChange::RaiseWorker { by_m, seated } => {
            let cm = 100.0 * by_m.abs();
            match (seated, *by_m > 0.0) {
                (false, true) => {
                    format!("raise the worker by {cm:.0} cm (platform), or lower the cell")
                }
                (false, false) => format!("raise the cell by {cm:.0} cm"),
                (true, true) => format!("raise the seat by {cm:.0} cm"),
                (true, false) => format!("lower the seat by {cm:.0} cm"),
            }
        }
        CellChange::RaiseEnd { end, by_m } => {
            let verb = if *by_m > 0.0 { "raise" } else { "lower" };
            format!("{verb} the {} by {:.0} cm", super::end(*end), 100.0 * by_m.abs())
        }
        CellChange::TurnWorker { by_rad: by } => {
            let side = if *by > 0.0 { "left" } else { "right" };
            format!("turn the worker by {:.0} deg to the {side}", by.to_degrees().abs())
        }
        CellChange::TurnHandle { by_rad: by } => {
            format!("turn the handle on the tool by {:+.0} deg about its bar", by.to_degrees())
        }
        CellChange::HalveLoad { load_kg: kg } => {
            format!("let the robot carry half of the load ({kg:.1} kg now)")
        }
    }
}

/// What a posture to look at shows.
pub fn moment(kind: MomentKind) -> &'static str {
    match kind {
        MomentKind::TypicalAtHardest => "typical posture at the hardest moment",
        MomentKind::HeldLongest => "posture that a typical repetition holds longest",
        MomentKind::Hardest => "hardest posture of all repetitions",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_of_the_cell_is_written_and_read_back() {
        let (by_m, seated) = (0.05, false);
        for change in [
            CellChange::MoveWorker { way: Way::Nearer, by_m, seated },
            CellChange::RaiseWorker { by_m, seated },
            CellChange::RaiseEnd { end: crate::path::End::Start, by_m: 0.2 },
            CellChange::TurnWorker { by_rad: -0.2 },
            CellChange::TurnHandle { by_rad: 0.1 },
            CellChange::HalveLoad { load_kg: 1.5 },
        ] {
            let text = serde_json::to_string(&change).unwrap();
            assert_eq!(serde_json::from_str::<CellChange>(&text).unwrap(), change, "{text}");
            assert!(!cell_change(&change).is_empty());
        }
    }
}
