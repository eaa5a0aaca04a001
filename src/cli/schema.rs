//! `ergopath schema`: JSON Schemas of the files that people write, for editors.

use super::{Failure, Outcome};
use crate::batch::batch_schema;
use crate::files::{InputError, Outputs};
use crate::planner::planner_schema;
use crate::scenario::scenario_schema;
use crate::shift::shift_schema;
use clap::ValueEnum;
use std::path::PathBuf;

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Which file; without it all of them, to a folder.
    kind: Option<Kind>,
    /// Folder to write KIND.schema.json to; without it the schema is printed.
    #[arg(short, long, value_name = "DIR", required_unless_present = "kind")]
    output: Option<PathBuf>,
}

/// Files that people write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A workstation (TOML).
    Scenario,
    /// A planner's settings (TOML).
    Planner,
    /// Many runs (TOML).
    Batch,
    /// A worker's shift (TOML).
    Shift,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Planner => "planner",
            Self::Batch => "batch",
            Self::Shift => "shift",
        }
    }

    fn text(self) -> Result<String, InputError> {
        let mut schema = match self {
            Self::Scenario => scenario_schema(),
            Self::Planner => planner_schema(),
            Self::Batch => batch_schema(),
            Self::Shift => shift_schema(),
        };
        // By this a schema is known as one that may be replaced (`files::signature`).
        schema["$comment"] = "ergopath/schema/1".into();
        let text = serde_json::to_string_pretty(&schema);
        Ok(text.map_err(|e| InputError::new(self.name(), e.to_string()))? + "\n")
    }
}

/// Prints or writes.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let kinds = args.kind.map_or_else(|| Kind::value_variants().to_vec(), |k| vec![k]);
    let mut shown = Vec::new();
    for kind in kinds {
        let text = kind.text()?;
        if let Some(folder) = &args.output {
            let path = folder.join(format!("{}.schema.json", kind.name()));
            outputs.file(&path, text)?;
            shown.push(path.display().to_string());
        } else {
            shown.push(text.trim_end().to_owned());
        }
    }
    outputs.write()?;
    for text in shown {
        say!("{text}");
    }
    Ok(Outcome::Done)
}
