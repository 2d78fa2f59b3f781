//! `msm completions` and `msm man`: what shells and `man` want to know of the arguments.

use crate::outcome::{Failure, print};
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
    let Some(folder) = &arguments.out else {
        let mut bytes = Vec::new();
        clap_mangen::Man::new(command.clone()).render(&mut bytes).context("writing the manual page")?;
        return print(&bytes);
    };
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    clap_mangen::generate_to(command.clone(), folder).with_context(|| folder.display().to_string())?;
    print(format!("the manual pages of msm and its commands are in {}\n", folder.display()).as_bytes())
}
