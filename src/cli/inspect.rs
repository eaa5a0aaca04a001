//! `ergopath inspect`: a chain, its limits, and its kinematics at given postures; or an imported motion.

use super::inspect_motion;
use super::{Failure, Outcome};
use crate::files::{InputError, NumericTable, Outputs, suggest};
use crate::kinematics::{Frames, Linkage, Model, read_urdf};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// URDF file, or the motion (CSV) of an import.
    #[arg(value_name = "FILE")]
    pub(super) file: PathBuf,
    /// Chain of a URDF as BASE:TIP, by link names; BASE must be an ancestor of TIP.
    #[arg(long, value_name = "BASE:TIP")]
    chain: Option<String>,
    /// Body of a motion; by default the one that its import wrote beside it.
    #[arg(long, value_name = "BODY", conflicts_with = "chain")]
    pub(super) body: Option<String>,
    /// Draw a motion: the person, main angles, residuals.
    #[arg(long, value_name = "FILE.png", conflicts_with = "chain")]
    pub(super) figure: Option<PathBuf>,
    /// Postures: CSV with a header of joint names, values in rad (m for sliding joints).
    #[arg(long, value_name = "Q.csv", requires = "chain")]
    at: Option<PathBuf>,
    /// Print JSON at full precision.
    #[arg(long)]
    pub(super) json: bool,
}

/// Prints the chain, or the motion.
pub(super) fn run(args: &Args, outputs: Outputs) -> Result<Outcome, Failure> {
    let is_csv = args.file.extension().is_some_and(|x| x.eq_ignore_ascii_case("csv"));
    let Some(named) = &args.chain else {
        if is_csv {
            return inspect_motion::run(args, outputs);
        }
        return Err(InputError::new(&args.file, "is shown by a chain of its links")
            .remedy("add --chain BASE:TIP, or give the motion (CSV) of an import")
            .into());
    };
    let model = read_urdf(&args.file)?;
    let linkage = chain(&model, &args.file, named)?;
    let postures = match &args.at {
        Some(path) => postures(&model, &linkage, path)?,
        None => Vec::new(),
    };
    for warning in model.warnings.iter().chain(&linkage.warnings) {
        complain!("warning: {warning}");
    }
    warn_of_limits(&linkage, &postures);
    if args.json {
        print_json(&linkage, &postures);
    } else {
        print_text(&model, &linkage, named, &postures);
    }
    Ok(Outcome::Done)
}

fn chain(model: &Model, file: &Path, named: &str) -> Result<Linkage, InputError> {
    // Link names may hold colons as well as spaces: try every way to split.
    let splits = named.match_indices(':').map(|(i, _)| (&named[..i], &named[i + 1..]));
    let known = |n: &str| model.link_index(n).is_some();
    let best = splits.clone().find(|(b, t)| known(b) && known(t)).or_else(|| splits.clone().next());
    let Some((base, tip)) = best else {
        return Err(InputError::new("--chain", format!("`{named}` is not of the form BASE:TIP"))
            .remedy(format!("for example --chain {}:TIP", model.root())));
    };
    Linkage::chain(model, base, tip).map_err(|e| {
        InputError::new(file, e.to_string()).remedy(format!("the root link is `{}`", model.root()))
    })
}

/// The columns of the table in chain order; columns of other joints of the model are allowed.
fn postures(model: &Model, linkage: &Linkage, path: &PathBuf) -> Result<Vec<Vec<f64>>, InputError> {
    let table = NumericTable::read(path)?;
    for column in &table.columns {
        let joints = || model.joints.iter().map(|j| j.name.as_str());
        if !joints().any(|j| j == column) {
            let error =
                InputError::new(path, format!("column `{column}` is no joint of the model"));
            let help = suggest(column, joints());
            return Err(
                error.remedy(help.unwrap_or_else(|| "name the columns as the joints".into()))
            );
        }
    }
    let columns: Result<Vec<usize>, InputError> =
        linkage.joints().iter().map(|j| table.index(&j.name)).collect();
    let columns = columns?;
    Ok(table.rows.iter().map(|row| columns.iter().map(|&c| row[c]).collect()).collect())
}

fn warn_of_limits(linkage: &Linkage, postures: &[Vec<f64>]) {
    for (i, joint) in linkage.joints().iter().enumerate() {
        let outside = |q: &&Vec<f64>| q[i] < joint.lower || q[i] > joint.upper;
        let count = postures.iter().filter(outside).count();
        if let Some(first) = postures.iter().position(|q| outside(&q)) {
            complain!(
                "warning: {} is outside {} to {} in {count} of {} rows (first: row {}, {}); computed \
                 all the same",
                joint.name,
                joint.lower,
                joint.upper,
                postures.len(),
                first + 1,
                postures[first][i]
            );
        }
    }
}

fn print_json(linkage: &Linkage, postures: &[Vec<f64>]) {
    let mut frames = Frames::default();
    let poses: Vec<serde_json::Value> = postures
        .iter()
        .map(|q| {
            linkage.forward(q, &mut frames);
            let (p, r) = linkage.tip_frame(&frames, 0);
            let jacobian = linkage.jacobian(&frames, 0);
            let rows = |m: &nalgebra::DMatrix<f64>| -> Vec<Vec<f64>> {
                m.row_iter().map(|row| row.iter().copied().collect()).collect()
            };
            json!({
                "position": [p.x, p.y, p.z],
                "rotation": rows(&nalgebra::DMatrix::from_column_slice(3, 3, r.as_slice())),
                "jacobian": rows(&nalgebra::DMatrix::from_column_slice(6, linkage.dof(), jacobian.as_slice())),
            })
        })
        .collect();
    let names: Vec<&str> = linkage.joints().iter().map(|j| j.name.as_str()).collect();
    // JSON has no infinity: a missing bound is null.
    let bound = |x: f64| x.is_finite().then_some(x);
    let limits: Vec<_> = linkage
        .joints()
        .iter()
        .map(|j| json!({"lower": bound(j.lower), "upper": bound(j.upper), "velocity": bound(j.velocity)}))
        .collect();
    say!("{}", json!({"joints": names, "limits": limits, "poses": poses}));
}

fn print_text(model: &Model, linkage: &Linkage, chain: &str, postures: &[Vec<f64>]) {
    say!("{}: {chain}, {} joints", model.name, linkage.dof());
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(["", "joint", "lower", "upper", "velocity", "unit"]);
    for (i, j) in linkage.joints().iter().enumerate() {
        let number = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "none".to_owned() };
        let unit = if j.is_prismatic { "m" } else { "rad" };
        table.add_row([
            i.to_string(),
            j.name.clone(),
            number(j.lower),
            number(j.upper),
            number(j.velocity),
            unit.to_owned(),
        ]);
    }
    for column in [0, 2, 3, 4] {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    say!("{table}");
    let mut frames = Frames::default();
    for (row, q) in postures.iter().enumerate() {
        linkage.forward(q, &mut frames);
        let (p, r) = linkage.tip_frame(&frames, 0);
        say!("\nrow {}: tip in `{}`", row + 1, linkage.base());
        say!("  position  {:10.6} {:10.6} {:10.6} m", p.x, p.y, p.z);
        for i in 0..3 {
            let head = if i == 0 { "rotation" } else { "" };
            say!("  {head:8}  {:10.6} {:10.6} {:10.6}", r[(i, 0)], r[(i, 1)], r[(i, 2)]);
        }
        let jacobian = linkage.jacobian(&frames, 0);
        for (i, name) in ["vx", "vy", "vz", "wx", "wy", "wz"].into_iter().enumerate() {
            let cells: Vec<String> = jacobian.row(i).iter().map(|v| format!("{v:8.4}")).collect();
            say!("  J {name}      {}", cells.join(" "));
        }
    }
}
