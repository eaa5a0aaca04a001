//! Batch files, and what a batch leaves in its folder, in words.

use super::check::Explained;
use crate::batch::{Batch, Jobs, Manifest, read_batch};
use crate::files::InputError;
use std::path::Path;

/// A batch file; every cell of it is checked.
pub(super) fn batch(path: &Path) -> Result<Explained, InputError> {
    let batch = read_batch(path)?;
    Manifest::of(&batch, &Jobs::of(&batch)?)?;
    Ok(explained(&batch))
}

fn explained(batch: &Batch) -> Explained {
    let mut explained =
        Explained::new(format!("a batch of {} cells, `{}`", batch.cells.len(), batch.name))
            .saying(format!("each cell is run as by `ergopath {}`", batch.mode.verb()));
    for factor in &batch.factors {
        let levels: Vec<&str> = factor.levels.iter().map(|l| l.label.as_str()).collect();
        explained = explained.saying(format!("`{}`: {}", factor.name, levels.join("; ")));
    }
    explained
}

/// The plan of a batch, in its folder.
pub(super) fn plan(path: &Path) -> Result<Explained, InputError> {
    let plan = Manifest::read(path.parent().unwrap_or(Path::new("")))?;
    Ok(Explained::new(format!(
        "the plan of a batch of {} cells, `{}`",
        plan.cells.len(),
        plan.name
    )))
}
