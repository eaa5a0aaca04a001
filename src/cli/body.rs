//! `ergopath body`: writes a digital human of given size.

use super::{Failure, Outcome};
use crate::files::{InputError, Outputs};
use crate::human::{BodySize, Sex, generate};
use std::path::PathBuf;

/// Arguments of `body`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Sex, as far as published proportions distinguish it.
    #[arg(long, value_parser = parse_sex, value_name = "f|m")]
    sex: Sex,
    /// Stature, m.
    #[arg(long, value_name = "M")]
    stature_m: f64,
    /// Body mass, kg.
    #[arg(long, value_name = "KG")]
    mass_kg: f64,
    /// URDF to write; sizes and trunk limits go to FILE.body.toml beside it.
    #[arg(short, long, value_name = "FILE.urdf")]
    output: PathBuf,
}

fn parse_sex(text: &str) -> Result<Sex, String> {
    match text.to_lowercase().as_str() {
        "f" | "female" | "woman" => Ok(Sex::Female),
        "m" | "male" | "man" => Ok(Sex::Male),
        _ => Err("use f or m".to_owned()),
    }
}

/// Writes the two files.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let size = BodySize { sex: args.sex, stature_m: args.stature_m, mass_kg: args.mass_kg };
    let path = &args.output;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    if path.extension().is_none_or(|x| x != "urdf") {
        return Err(InputError::new(path, "the name of a body ends in .urdf").into());
    }
    let files = generate(&name, size).map_err(|e| InputError::new("body", e))?;
    let sheet = path.with_extension("body.toml");
    outputs.file(&sheet, files.sheet)?;
    outputs.file(path, files.urdf)?;
    outputs.write()?;
    say!("{}: {} of {} m, {} kg", path.display(), size.sex, size.stature_m, size.mass_kg);
    say!("  66 joints, pelvis to right hand 24; palms forward at zero; limits: AAOS ranges");
    say!("{}: sizes and trunk limits", sheet.display());
    Ok(Outcome::Done)
}
