//! Names of paths that say what they do, and what is chosen with them.

use crate::path::Family;
use crate::planner::{Bend, Bought, CandidateResult, Price, RunResult};
use crate::scenario::Chosen;

/// Departure from the straight line below which a path is called almost straight, m.
const STRAIGHT_M: f64 = 0.015;
/// Part of the largest departure from which a second one is named.
const SECOND: f64 = 0.4;

/// What a path is called where its id stands beside it: what it does, or whose it is.
pub fn path_name(c: &CandidateResult) -> String {
    match c.family {
        Family::Straight => "straight line".to_owned(),
        Family::StraightRetimed => "straight line, timing optimised".to_owned(),
        Family::Drawn => "your path".to_owned(),
        Family::ExpertArc => "an expert's arc".to_owned(),
        Family::Shortest => "shortest feasible path".to_owned(),
        Family::BestRandom | Family::SinglePosturePlain | Family::SinglePostureLearned => {
            family(c.family).to_owned()
        }
        Family::Held => {
            let fixed = match c.id.strip_prefix("without ") {
                None | Some("any freedom") => "nothing but the path free".to_owned(),
                Some(freedom) => format!("the {freedom} fixed"),
            };
            format!("{}, planned with {fixed}", bend_words(c))
        }
        Family::Lifted | Family::Lowered | Family::TowardBody | Family::Away | Family::Sampled => {
            bend_words(c)
        }
    }
}

/// The name with the id behind it.
pub fn path_and_id(c: &CandidateResult) -> String {
    format!("{} (`{}`)", path_name(c), c.id)
}

/// The same by the id; the id alone for a path that is not in the result.
pub fn named(result: &RunResult, id: &str) -> String {
    let found = result.candidates.iter().find(|c| c.id == id);
    match found.map(|c| (c.family, path_name(c))) {
        Some((Family::Straight, _)) => "the straight path".to_owned(),
        Some((Family::StraightRetimed, _)) => "the straight path with optimised timing".to_owned(),
        Some((Family::Drawn, _)) => format!("your path `{id}`"),
        Some((_, name)) => format!("`{id}` ({name})"),
        None => format!("`{id}`"),
    }
}

/// Where a path bends: "8 cm towards the body, 3 cm lower".
fn bend_words(c: &CandidateResult) -> String {
    c.bend.as_ref().map_or_else(|| "not drawn".to_owned(), bend)
}

/// Where a path bends, largest first.
pub fn bend(b: &Bend) -> String {
    let mut parts = [
        (b.toward_body_m, ["towards the body", "away from the body"]),
        (b.up_m, ["higher", "lower"]),
        (b.left_m, ["to the left", "to the right"]),
    ];
    parts.sort_by(|x, y| y.0.abs().total_cmp(&x.0.abs()));
    let largest = parts[0].0.abs();
    let least = STRAIGHT_M.max(SECOND * largest);
    let told: Vec<String> = parts
        .iter()
        .take(2)
        .filter(|(by, _)| by.abs() >= least)
        .map(|(by, [plus, minus])| {
            format!("{:.0} cm {}", 100.0 * by.abs(), if *by > 0.0 { plus } else { minus })
        })
        .collect();
    if told.is_empty() { "almost straight".to_owned() } else { told.join(", ") }
}

/// How a path was made, in a few words.
pub fn family(family: Family) -> &'static str {
    match family {
        Family::Straight => "straight line",
        Family::StraightRetimed => "straight line, timing optimised",
        Family::Lifted => "above the straight line",
        Family::Lowered => "below the straight line",
        Family::TowardBody => "closer to the body",
        Family::Away => "farther from the body",
        Family::Sampled => "found by the search",
        Family::Drawn => "your own",
        Family::ExpertArc => "what an expert would draw",
        Family::Shortest => "shortest feasible path",
        Family::BestRandom => "best of the random paths",
        Family::SinglePosturePlain => "one-posture plan, plain pseudo-inverse",
        Family::SinglePostureLearned => "one-posture plan, learned model",
        Family::Held => "planned with a freedom fixed",
    }
}

/// Something that was chosen besides the path.
pub fn chosen(c: &Chosen) -> String {
    let at = |p: &[f64; 3]| format!("({:.3}, {:.3}, {:.3}) m", p[0], p[1], p[2]);
    let deg = |a: &f64| format!("{:.1} deg", a.to_degrees());
    match c {
        Chosen::StartAt(p) => format!("start at {}", at(p)),
        Chosen::StartTurned(a) => format!("start turned by {}", deg(a)),
        Chosen::GoalAt(p) => format!("goal at {}", at(p)),
        Chosen::GoalTurned(a) => format!("goal turned by {}", deg(a)),
        Chosen::BaseAt(p) => format!("robot base at {}", at(p)),
        Chosen::BaseTurned(a) => format!("robot base turned by {}", deg(a)),
        Chosen::GripTurned(a) => format!("grip turned by {}", deg(a)),
        Chosen::WorkerAt([x, y]) => format!("worker at ({x:.3}, {y:.3}) m"),
        Chosen::WorkerFacing(a) => format!("worker facing {}", deg(a)),
        Chosen::Duration(s) => format!("duration {s:.2} s"),
        Chosen::Rest(s) => format!("a rest of {s:.2} s on the way"),
    }
}

/// Why a lower mean is not taken.
pub fn bought(b: &Bought) -> String {
    let with = match b.with {
        Price::Peak => "peak",
        Price::PerMetre => "score per metre of hand travel",
    };
    format!(
        "its {} {with} is {:.2} higher than on the straight path (95 % interval {:.2} to {:.2})",
        b.method.name(),
        b.difference.mean,
        b.difference.low95,
        b.difference.high95
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bends_are_named_by_what_matters() {
        let b = |toward_body_m, left_m, up_m| bend(&Bend { toward_body_m, left_m, up_m });
        assert_eq!(b(0.081, 0.01, -0.05), "8 cm towards the body, 5 cm lower");
        assert_eq!(b(0.081, 0.01, -0.02), "8 cm towards the body");
        assert_eq!(b(-0.02, 0.0, 0.12), "12 cm higher");
        assert_eq!(b(0.005, -0.03, 0.0), "3 cm to the right");
        assert_eq!(b(0.005, 0.003, 0.01), "almost straight");
    }
}
