//! `ergopath completions` and `ergopath man`: what a shell and a reader of manuals want.

use super::stdout::print_bytes;
use super::{Cli, Failure, Outcome};
use crate::files::{InputError, Outputs};
use clap::CommandFactory;
use clap_complete::Shell;
use clap_mangen::Man;
use std::path::{Path, PathBuf};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub(super) struct CompletionArgs {
    /// The shell.
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub(super) struct ManArgs {
    /// Folder to write ergopath.1 and a page for each command to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Prints the script.
pub(super) fn completions(args: &CompletionArgs) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "ergopath", &mut script);
    print_bytes(&script);
    Outcome::Done
}

/// Writes the pages.
pub(super) fn man(args: &ManArgs, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    page(&mut outputs, &args.output, &command, "ergopath")?;
    for sub in command.get_subcommands() {
        page(&mut outputs, &args.output, sub, &format!("ergopath-{}", sub.get_name()))?;
    }
    outputs.write()?;
    say!("{}", args.output.join("ergopath.1").display());
    Ok(Outcome::Done)
}

fn page(
    outputs: &mut Outputs,
    folder: &Path,
    command: &clap::Command,
    name: &str,
) -> Result<(), InputError> {
    let path = folder.join(format!("{name}.1"));
    let mut text = Vec::new();
    Man::new(command.clone())
        .render(&mut text)
        .map_err(|e| InputError::fault(&path, e.to_string()))?;
    outputs.file(&path, text)
}
