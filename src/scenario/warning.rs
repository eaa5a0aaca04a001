//! What the reader of a scenario should know, as facts. How it is said is the business of
//! [`crate::words`], which stands above.

use super::check::FacesAway;
use super::plausible::Doubt;
use super::worker::Adaptation;
use serde::{Deserialize, Serialize};

/// Something that is no error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "warning", rename_all = "snake_case")]
pub enum Warning {
    /// The part's mass is given and the worker's share of it is not: the worker carries all of it.
    WholeLoad {
        /// Mass of the part, kg.
        mass_kg: f64,
    },
    /// A value that looks like a mistake and may be meant.
    Doubtful {
        /// The user's path in whose file it stands; none for the scenario itself.
        path: Option<String>,
        /// The value.
        doubt: Doubt,
    },
    /// A user's path gives the TCP only, so that the arm's postures are chosen here.
    OnlyTcp {
        /// Name of the path.
        path: String,
    },
    /// The posture model is used with other contacts than it was learned with.
    Adapted(Adaptation),
    /// The worker looks past the task.
    FacesAway(FacesAway),
    /// A file of ergopath without its checksum: whether it was edited cannot be seen.
    NoChecksum {
        /// Name of the file.
        file: String,
    },
    /// A body file that is not what the program makes of its size.
    OtherBody {
        /// Name of the body.
        body: String,
    },
}
