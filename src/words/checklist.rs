//! What a path was checked for, in words.

use super::robot;
use crate::planner::{CheckState, Checked, Subject, Why};

/// What was checked, as it stands within a sentence.
pub fn subject(subject: Subject) -> &'static str {
    match subject {
        Subject::Speed => "the speed of the tool",
        Subject::Acceleration => "the acceleration of the tool",
        Subject::Jerk => "the jerk of the tool",
        Subject::AngularSpeed => "the angular speed of the tool",
        Subject::AngularAcceleration => "the angular acceleration of the tool",
        Subject::Rest => "the tool at rest at start and goal",
        Subject::Continuity => "a path without jumps",
        Subject::Workspace => "the tool in the workspace box",
        Subject::ToolClearance => "the tool's distance to obstacles",
        Subject::Corridor => "the corridor about the path",
        Subject::ReachBall => "the reach of the hands",
        Subject::Joints => "the robot's joints",
        Subject::Obstacles => "collisions of the robot with obstacles",
        Subject::Itself => "collisions of the robot with itself",
        Subject::Person => "the distance between robot and person",
        Subject::Hand => "the worker's hand on the path",
    }
}

/// Why something was not checked.
pub fn why(why: Why) -> String {
    match why {
        Why::Robot(why) => robot::not_checked(why),
        Why::TooFewRows => "the file has too few rows".to_owned(),
        Why::Refused => "the path was refused before".to_owned(),
        Why::NobodyFollows => "no repetition of the worker follows the path".to_owned(),
    }
}

/// How a check came out, in a cell of a table.
pub fn state(state: CheckState) -> String {
    match state {
        CheckState::Kept => "kept".to_owned(),
        CheckState::Broken => "broken".to_owned(),
        CheckState::NotChecked { why: reason } => format!("not checked: {}", why(reason)),
    }
}

/// How many checks were kept; which were not, and which were not made.
pub fn summary(list: &[Checked]) -> String {
    if list.is_empty() {
        return "no list of checks: the run is of an older version".to_owned();
    }
    let kept = list.iter().filter(|c| c.state == CheckState::Kept).count();
    let mut parts = vec![match (kept, list.len()) {
        (1, 1) => "1 check: kept".to_owned(),
        (kept, all) if kept == all => format!("{all} checks: all kept"),
        (kept, all) => format!("{kept} of {all} checks kept"),
    }];
    let broken: Vec<&Checked> = list.iter().filter(|c| c.state == CheckState::Broken).collect();
    if !broken.is_empty() {
        parts.push(format!("broken: {}", names(&broken)));
    }
    let mut reasons: Vec<Why> = Vec::new();
    for check in list {
        if let CheckState::NotChecked { why } = check.state
            && !reasons.contains(&why)
        {
            reasons.push(why);
        }
    }
    for reason in reasons {
        let state = CheckState::NotChecked { why: reason };
        let open: Vec<&Checked> = list.iter().filter(|c| c.state == state).collect();
        parts.push(format!("not checked: {} ({})", names(&open), why(reason)));
    }
    parts.join("; ")
}

/// Subjects by name, each once.
fn names(list: &[&Checked]) -> String {
    let mut all: Vec<&str> = list.iter().map(|c| subject(c.subject)).collect();
    all.dedup();
    all.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::NotChecked;

    fn check(subject: Subject, state: CheckState) -> Checked {
        Checked { subject, body: None, state }
    }

    #[test]
    fn what_was_not_checked_is_never_among_the_kept() {
        let blind = CheckState::NotChecked { why: Why::Robot(NotChecked::NoShapes) };
        let list = [
            check(Subject::Speed, CheckState::Kept),
            check(Subject::Rest, CheckState::Broken),
            check(Subject::Obstacles, blind),
            check(Subject::Itself, blind),
        ];
        assert_eq!(
            summary(&list),
            "1 of 4 checks kept; broken: the tool at rest at start and goal; not checked: collisions of the robot \
             with obstacles, collisions of the robot with itself (the robot has no collision shapes)"
        );
        assert_eq!(summary(&list[..1]), "1 check: kept");
        assert!(summary(&[]).starts_with("no list"));
    }
}
