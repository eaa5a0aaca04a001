//! Why two runs have not the same repetitions, in words.

use crate::planner::Apart;

/// What differs.
pub fn apart(why: &Apart) -> String {
    match why {
        Apart::Seeds([a, b]) => format!("seeds {a} and {b}"),
        Apart::Models([a, b]) => format!("posture models {a} and {b}"),
        Apart::Bodies([a, b]) => format!("bodies {a} and {b}"),
        Apart::TwoBodies(name) => format!("two bodies named {name}"),
        Apart::Versions([a, b]) => format!("ergopath {a} and {b}"),
    }
}
