//! `msm bound`: sharp bounds for one moment vector and one fragment depth, with their proof.

mod batch;
pub(crate) mod input;
mod plot;

use crate::outcome::{Failure, Output};
use crate::storage::{self, Stored};
use anyhow::anyhow;
use clap::ArgGroup;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use input::{Input, parse_basis};
use moment_problem::{Basis, Certificate, Interval, Solver, method};
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// Bound the shadow intensity F(z_f) = Z(z < z_f) that moments leave possible.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("input").required(true).multiple(false).args(["atoms", "moments", "batch"]))]
pub(crate) struct Arguments {
    /// power:M, trig:N, or formulas in z separated by commas, such as "z,z^2,exp(-2z)".
    #[arg(long, value_parser = parse_basis, allow_hyphen_values = true)]
    basis: Basis,
    /// Admissible depths: unit is [0, 1], real the whole line.
    #[arg(long, default_value = Interval::Unit.name(), value_parser = interval_parser())]
    interval: Interval,
    /// The depths in the filter kernel and their weights, as depth:weight separated by commas.
    #[arg(long, allow_hyphen_values = true)]
    atoms: Option<String>,
    /// The filtered moments, the means of b_1 to b_m, separated by commas.
    #[arg(long, allow_hyphen_values = true, value_name = "B1,B2,..")]
    moments: Option<String>,
    /// Many bounds at once: rows of m moments and z_f, as a .npy array of n x (m + 1) floats, as CSV, or CSV from standard
    /// input for `-`. Without --out CSV goes to standard output.
    #[arg(long, value_name = "FILE|-", conflicts_with_all = ["depth", "plot", "storage", "alpha"])]
    batch: Option<PathBuf>,
    /// Where the bounds of --batch go: .npz with the arrays lower, upper, lower_proved, upper_proved and ok, else CSV.
    #[arg(long, value_name = "FILE", requires = "batch")]
    out: Option<PathBuf>,
    /// Depth z_f of the fragment to be shaded.
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    depth: Option<f64>,
    /// lp: MSM15 Algorithm 1; fast: certified exchange simplex on [0, 1]; closed: the closed form. Without this,
    /// closed where it exists, else fast.
    #[arg(long, value_parser = solver_parser())]
    solver: Option<Solver>,
    /// Write an SVG of the bounds at all fragment depths; with --atoms also F and, for comparison, power:2 and power:4
    /// on the line, power:4 and trig:2 on [0, 1].
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    storage: storage::Arguments,
    #[command(flatten)]
    output: Output,
}

fn interval_parser() -> impl TypedValueParser<Value = Interval> {
    PossibleValuesParser::new(Interval::ALL.map(Interval::name)).try_map(|name| name.parse::<Interval>())
}

fn solver_parser() -> impl TypedValueParser<Value = Solver> {
    PossibleValuesParser::new(Solver::ALL.map(Solver::name)).try_map(|name| name.parse::<Solver>())
}

/// The result as recorded in JSON; docs/moment-problem.md says what each key holds.
#[derive(Serialize)]
struct Answer {
    lower: f64,
    upper: f64,
    lower_proved: f64,
    upper_proved: f64,
    support: Vec<f64>,
    weights: Vec<f64>,
    solver: &'static str,
    basis: String,
    interval: Interval,
    depth: f64,
    worst_slack: f64,
    /// What storage and bias made of the moments, if they were asked for.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    stored: Option<Stored>,
    /// PCF: mass strictly before z_f, if the distribution is known.
    #[serde(rename = "F", skip_serializing_if = "Option::is_none")]
    mass_before: Option<f64>,
    /// Mass up to and including z_f, if the distribution is known.
    #[serde(rename = "F_le", skip_serializing_if = "Option::is_none")]
    mass_up_to: Option<f64>,
    /// How much rounding the moments to doubles moves the proved bounds (to first order), if they were given: by so much the
    /// bounds may exclude the F of the kernel whose moments these were.
    #[serde(skip_serializing_if = "Option::is_none")]
    moment_rounding: Option<f64>,
}

/// Half a unit in the last place of each moment, as the dual functions weigh it.
fn rounding(moments: &[f64], certificate: &Certificate) -> f64 {
    let size = |dual: &[f64]| dual.iter().skip(1).zip(moments).map(|(y, b)| (y * b).abs()).sum::<f64>();
    0.5 * f64::EPSILON * size(&certificate.lower_dual).max(size(&certificate.upper_dual))
}

/// Computes, prints.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (basis, interval) = (&arguments.basis, arguments.interval);
    if let Some(batch) = &arguments.batch {
        let method =
            method(basis, interval, arguments.solver).map_err(|error| Failure::Input(error.into()))?;
        return batch::execute((batch, arguments.out.as_deref()), &method, arguments.output);
    }
    let input = Input::parse(arguments.atoms.as_deref(), arguments.moments.as_deref())?;
    let method = method(basis, interval, arguments.solver).map_err(|error| input.failure(error))?;
    // Required without a batch.
    let z_f = arguments.depth.unwrap_or_default();
    if let Some(path) = arguments.plot.as_ref().filter(|path| !plot::is_drawn(path)) {
        return Err(Failure::Input(anyhow!(
            "--plot {}: plots are SVG; give a file that ends in .svg, which browsers and vector programs turn into others",
            path.display()
        )));
    }
    let (mass_before, mass_up_to) = match &input {
        Input::Atoms(z) => (Some(z.cdf(z_f)), Some(z.cdf_inclusive(z_f))),
        Input::Moments(_) => (None, None),
    };
    let stored = arguments.storage.stored(basis, &input)?;
    let input = match &stored {
        Some(stored) => Input::Moments(stored.moments.clone()),
        None => input,
    };
    let bounds = input.bounds(method.as_ref(), z_f).map_err(|error| match &input {
        Input::Moments(moments) => {
            let hint = arguments.storage.repair(&method, moments, stored.as_ref(), z_f, &error);
            match (input.failure(error), hint) {
                (Failure::Input(error), Some(hint)) => Failure::Input(anyhow!("{error:#}; {hint}")),
                (failure, _) => failure,
            }
        }
        Input::Atoms(_) => input.failure(error),
    })?;
    if let Some(path) = &arguments.plot {
        plot::write(path, &input, &method, z_f, &bounds)?;
    }
    let moment_rounding = match &input {
        Input::Atoms(_) => None,
        Input::Moments(moments) => Some(rounding(moments, &bounds.certificate)),
    };
    let gap = bounds.gap().max(0.0);
    let answer = Answer {
        // Adding zero turns a negative zero into zero.
        lower: bounds.lower + 0.0,
        upper: bounds.upper,
        lower_proved: bounds.certificate.lower_proved,
        upper_proved: bounds.certificate.upper_proved,
        support: bounds.support,
        weights: bounds.weights,
        solver: method.name(),
        basis: basis.to_string(),
        interval,
        depth: z_f,
        worst_slack: bounds.certificate.worst_slack,
        stored,
        mass_before,
        mass_up_to,
        moment_rounding,
    };
    arguments.output.emit(&answer, |out| write_table(out, &answer, gap))
}

fn write_table(out: &mut dyn Write, answer: &Answer, gap: f64) -> io::Result<()> {
    writeln!(out, "basis    {} on {}", answer.basis, answer.interval)?;
    writeln!(out, "method   {}", answer.solver)?;
    writeln!(out, "z_f      {}", answer.depth)?;
    if let Some(stored) = &answer.stored {
        stored.write(out)?;
    }
    writeln!(out)?;
    writeln!(out, "                            attained          proved")?;
    // What is printed must be proved too: round it to the safe side.
    let lower_proved = (answer.lower_proved * 1e12).floor() / 1e12;
    let upper_proved = (answer.upper_proved * 1e12).ceil() / 1e12;
    writeln!(out, "  lower bound of Z(z < z_f)  {:<16.12}  {lower_proved:.12}", answer.lower)?;
    writeln!(out, "  upper bound of Z(z <= z_f) {:<16.12}  {upper_proved:.12}", answer.upper)?;
    if let (Some(before), Some(up_to)) = (answer.mass_before, answer.mass_up_to) {
        writeln!(out, "  F = Z(z < z_f), by PCF     {before:.12}")?;
        writeln!(out, "      Z(z <= z_f)            {up_to:.12}")?;
    }
    writeln!(out, "  certificate gap {gap:.1e}, worst dual slack {:.1e}", answer.worst_slack)?;
    if let Some(rounding) = answer.moment_rounding {
        writeln!(
            out,
            "  rounding moments to doubles moves a bound by up to {rounding:.1e}; the kernel's F may"
        )?;
        writeln!(out, "  lie outside the proved bounds by that much")?;
    }
    writeln!(out)?;
    writeln!(out, "  a distribution with these moments that attains the lower bound")?;
    writeln!(out, "  depth             weight")?;
    for (&z, &weight) in answer.support.iter().zip(&answer.weights) {
        let side = match z.total_cmp(&answer.depth) {
            std::cmp::Ordering::Less => "before z_f",
            std::cmp::Ordering::Equal => "at z_f",
            std::cmp::Ordering::Greater => "behind z_f",
        };
        writeln!(out, "  {z:<16.12}  {weight:<14.12}  {side}")?;
    }
    let missing = 1.0 - answer.weights.iter().sum::<f64>();
    if missing > 1e-9 {
        writeln!(out, "  -infinity         {missing:<14.12}  in the limit")?;
    }
    Ok(())
}
