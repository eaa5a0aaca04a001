//! `ergopath completions` and `ergopath man`: what a shell and a reader of manuals want.

use super::{Cli, Failure, Outcome};
use crate::files::{InputError, write_whole};
use clap::CommandFactory;
use clap_complete::Shell;
use clap_mangen::Man;
use std::io::Write as _;
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
    // A reader that has gone is no reason to fail.
    let _ = std::io::stdout().write_all(&script);
    Outcome::Done
}

/// Writes the pages.
pub(super) fn man(args: &ManArgs) -> Result<Outcome, Failure> {
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    page(&args.output, &command, "ergopath")?;
    for sub in command.get_subcommands() {
        page(&args.output, sub, &format!("ergopath-{}", sub.get_name()))?;
    }
    say!("{}", args.output.join("ergopath.1").display());
    Ok(Outcome::Done)
}

fn page(folder: &Path, command: &clap::Command, name: &str) -> Result<(), InputError> {
    let path = folder.join(format!("{name}.1"));
    let mut text = Vec::new();
    Man::new(command.clone())
        .render(&mut text)
        .map_err(|e| InputError::new(&path, e.to_string()))?;
    write_whole(&path, &text)
}
