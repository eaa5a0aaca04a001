//! `ergopath inspect`: a chain, its limits, and its kinematics at given postures.

use super::{Failure, Outcome};
use crate::files::{InputError, NumericTable, suggest};
use crate::kinematics::{Frames, Linkage, Model, read_urdf};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// URDF file.
    urdf: PathBuf,
    /// Chain as BASE:TIP, by link names; BASE must be an ancestor of TIP.
    #[arg(long, value_name = "BASE:TIP")]
    chain: String,
    /// Postures: CSV with a header of joint names, values in rad (m for sliding joints).
    #[arg(long, value_name = "Q.csv")]
    at: Option<PathBuf>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Prints the chain.
pub(super) fn run(args: &Args) -> Result<Outcome, Failure> {
    let model = read_urdf(&args.urdf)?;
    let linkage = chain(&model, args)?;
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
        print_text(&model, &linkage, &args.chain, &postures);
    }
    Ok(Outcome::Done)
}

fn chain(model: &Model, args: &Args) -> Result<Linkage, InputError> {
    // Link names may hold colons as well as spaces: try every way to split.
    let splits =
        args.chain.match_indices(':').map(|(i, _)| (&args.chain[..i], &args.chain[i + 1..]));
    let known = |n: &str| model.link_index(n).is_some();
    let best = splits.clone().find(|(b, t)| known(b) && known(t)).or_else(|| splits.clone().next());
    let Some((base, tip)) = best else {
        return Err(InputError::new(
            "--chain",
            format!("`{}` is not of the form BASE:TIP", args.chain),
        )
        .remedy(format!("for example --chain {}:TIP", model.root())));
    };
    Linkage::chain(model, base, tip).map_err(|e| {
        InputError::new(&args.urdf, e.to_string())
            .remedy(format!("the root link is `{}`", model.root()))
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
