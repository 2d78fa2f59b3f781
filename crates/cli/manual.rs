//! `msm completions` and `msm man`: what shells and `man` want to know of the arguments.

use crate::outcome::{Failure, print};
use crate::staging::Staging;
use anyhow::Context;
use clap::Command;
use clap_complete::Shell;
use std::path::PathBuf;

/// Print completions for a shell; `msm completions bash > ~/.local/share/bash-completion/completions/msm`, for example.
#[derive(clap::Args)]
pub(crate) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Print the manual page, or write it with one page a command into a folder.
#[derive(clap::Args)]
pub(crate) struct Man {
    /// Folder for msm.1 and the pages of all commands, such as ~/.local/share/man/man1; created where it is missing.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(crate) fn completions(arguments: &Completions, command: &mut Command) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    clap_complete::generate(arguments.shell, command, "msm", &mut bytes);
    print(&bytes)
}

pub(crate) fn man(arguments: &Man, command: &Command) -> Result<(), Failure> {
    let page = |command: &Command| -> Result<Vec<u8>, Failure> {
        let mut bytes = Vec::new();
        clap_mangen::Man::new(command.clone()).render(&mut bytes).context("writing the manual page")?;
        Ok(bytes)
    };
    let Some(folder) = &arguments.out else { return print(&page(command)?) };
    let verbs = command.get_subcommands().map(|verb| {
        let name = format!("msm-{}", verb.get_name());
        (format!("{name}.1"), verb.clone().name(name.clone()).display_name(name))
    });
    let pages: Vec<(String, Command)> = [("msm.1".to_owned(), command.clone())].into_iter().chain(verbs).collect();
    let names: Vec<String> = pages.iter().map(|(name, _)| name.clone()).collect();
    let staging = Staging::new(folder, &names)?;
    for (name, command) in &pages {
        std::fs::write(staging.path(name), page(command)?).with_context(|| name.clone())?;
    }
    let written: Vec<String> =
        staging.publish(&names)?.iter().map(|path| format!("{}\n", path.display())).collect();
    print(written.concat().as_bytes())
}
