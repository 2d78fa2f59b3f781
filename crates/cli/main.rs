//! `msm`: arguments, progress and exit codes. The only code that knows every crate.

mod advise;
mod backend;
mod bound;
mod cluster;
mod outcome;
mod progress;
mod quantize;
mod render;
mod report;
mod reproduce;
mod run;
mod staging;
mod storage;

use clap::{Parser, Subcommand};
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
        }
    }
}

fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(arguments) => outcome::exit_code(arguments.verb.execute()),
        Err(error) => outcome::usage(&error),
    }
}
