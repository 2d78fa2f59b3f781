//! `msm`: arguments, progress and exit codes. The only code that knows every crate.

mod advise;
mod backend;
mod bound;
mod cluster;
mod experiments;
mod interrupt;
mod manual;
mod outcome;
mod progress;
mod quantize;
mod render;
mod report;
mod reproduce;
mod run;
mod shader;
mod staging;
mod storage;
mod threads;

use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use outcome::Failure;
use std::process::ExitCode;

/// A laboratory for filterable shadow maps: moment bounds, certified and measured.
#[derive(Parser)]
#[command(name = "msm", version, max_term_width = 110)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

/// One file and one variant per verb.
#[derive(Subcommand)]
enum Verb {
    Advise(advise::Arguments),
    Bound(bound::Arguments),
    Quantize(quantize::Arguments),
    Render(render::Arguments),
    Run(run::Arguments),
    Cluster(cluster::Arguments),
    Report(report::Arguments),
    Reproduce(reproduce::Arguments),
    Completions(manual::Completions),
    Man(manual::Man),
    Shader(shader::Arguments),
}

impl Verb {
    fn execute(&self) -> Result<(), Failure> {
        match self {
            Self::Advise(arguments) => advise::execute(arguments),
            Self::Bound(arguments) => bound::execute(arguments),
            Self::Quantize(arguments) => quantize::execute(arguments),
            Self::Render(arguments) => render::execute(arguments),
            Self::Run(arguments) => run::execute(arguments),
            Self::Cluster(arguments) => cluster::execute(arguments),
            Self::Report(arguments) => report::execute(arguments),
            Self::Reproduce(arguments) => reproduce::execute(arguments),
            Self::Completions(arguments) => manual::completions(arguments, &mut Arguments::command()),
            Self::Man(arguments) => manual::man(arguments, &Arguments::command()),
            Self::Shader(arguments) => shader::execute(arguments),
        }
    }
}

/// Drivers of Mesa complain on standard error where the variable that names a user's socket folder is missing, although
/// nothing is shown on a screen.
fn quieten_drivers() {
    const SOCKETS: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(SOCKETS).is_none() {
        // SAFETY: the first thing that the program does; no other thread reads the environment.
        unsafe { std::env::set_var(SOCKETS, std::env::temp_dir()) };
    }
}

/// The arguments. What begins with a minus and a digit is a value: options are told what is wrong with negative numbers.
fn parsed() -> Result<Arguments, clap::Error> {
    let numbers = |verb: clap::Command| {
        verb.mut_args(|argument| match argument.get_action() {
            ArgAction::Set | ArgAction::Append => argument.allow_negative_numbers(true),
            _ => argument,
        })
    };
    let command = Arguments::command().mut_subcommands(numbers);
    Arguments::from_arg_matches(&command.try_get_matches()?)
}

/// Scenes are named in records, which are text.
pub(crate) fn scene_name() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().try_map(|name| {
        name.into_string().map_err(|name| {
            format!("its name {name:?} is no UTF-8: rename the file, or make a link to it of another name")
        })
    })
}

fn main() -> ExitCode {
    quieten_drivers();
    match parsed() {
        Ok(arguments) => outcome::exit_code(arguments.verb.execute()),
        Err(error) => outcome::usage(&error),
    }
}
