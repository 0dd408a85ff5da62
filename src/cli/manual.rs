//! `firstlight man` and `firstlight completions`: what the command line says of itself, for `man` and for shells.

use std::{fs, path::PathBuf};

use clap::{Arg, Args, Command, ValueHint};
use clap_complete::Shell;

use super::{CliError, ExitStatus, point::print};
use crate::headless::{HeadlessError, OutputError};

#[derive(Debug, Args)]
pub struct ManArgs {
    /// Folder to write the pages to, one for each command; without it, the first page is printed
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub fn man(args: ManArgs, command: Command) -> Result<ExitStatus, CliError> {
    let Some(folder) = args.folder else {
        let mut page = Vec::new();
        // As `generate_to` has it.
        let command = command.disable_help_subcommand(true);
        clap_mangen::Man::new(command).render(&mut page).expect("memory can be written to");
        print(&String::from_utf8_lossy(&page))?;
        return Ok(ExitStatus::Ok);
    };
    let written = fs::create_dir_all(&folder).and_then(|()| clap_mangen::generate_to(command, &folder));
    let error = |source| HeadlessError::Output(OutputError::Io { path: folder.clone(), source });
    written.map_err(error)?;
    Ok(ExitStatus::Ok)
}

pub fn completions(args: CompletionsArgs, command: Command) -> Result<ExitStatus, CliError> {
    let mut command = without_files(command);
    let mut script = Vec::new();
    let name = command.get_name().to_owned();
    clap_complete::generate(args.shell, &mut command, name, &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(ExitStatus::Ok)
}

/// Completions offer files for any value of which they know nothing: here, all that are paths say so by their type.
fn without_files(command: Command) -> Command {
    let typed = |arg: Arg| {
        let is_unknown = arg.get_action().takes_values() && arg.get_value_hint() == ValueHint::Unknown;
        if is_unknown { arg.value_hint(ValueHint::Other) } else { arg }
    };
    command.mut_args(typed).mut_subcommands(without_files)
}
