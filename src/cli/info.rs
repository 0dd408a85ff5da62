//! `firstlight info`.

use std::path::PathBuf;

use clap::Args;

use super::{CliError, ExitStatus, point::print, say};
use crate::{headless::HeadlessError, info::Info, source};

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// LAS and LAZ files, and folders of them
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// Print JSON: one object for one file, a list for several files or a folder
    #[arg(long)]
    json: bool,
}

pub fn run(args: InfoArgs) -> Result<ExitStatus, CliError> {
    let (files, errors) = source::list_files(&args.inputs);
    let mut errors: Vec<_> = errors.into_iter().map(|(_, error)| error).collect();
    let mut infos = Vec::new();
    for file in &files {
        match Info::read(file) {
            Ok(info) => infos.push(info),
            Err(error) => errors.push(error),
        }
    }
    if infos.is_empty() && errors.len() == 1 {
        return Err(HeadlessError::Input(errors.remove(0)).into());
    }
    // What is known comes first: errors are read at the end.
    print(&text(&args, &infos))?;
    errors.iter().for_each(|error| say(&format!("firstlight: {error}")));
    Ok(match (infos.is_empty(), errors.is_empty()) {
        (_, true) => ExitStatus::Ok,
        (false, false) => ExitStatus::Partial,
        (true, false) => ExitStatus::Input,
    })
}

fn text(args: &InfoArgs, infos: &[Info]) -> String {
    if !args.json {
        let texts: Vec<String> = infos.iter().map(|info| format!("{}\n", info.to_string().trim_end())).collect();
        return texts.join("\n");
    }
    let json = match (&args.inputs[..], infos) {
        ([input], [info]) if !input.is_dir() => serde_json::to_string_pretty(info),
        _ => serde_json::to_string_pretty(infos),
    };
    format!("{}\n", json.expect("strings, numbers and lists are always JSON"))
}
