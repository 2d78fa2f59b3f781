//! `msm quantize`: the affine transform that makes moments fill the codes of a texel, with code to paste.

use crate::bound::input::parse_basis;
use crate::outcome::{Failure, Output};
use clap::{ArgGroup, ValueEnum};
use moment_problem::Basis;
use quantization::snippet::{Language, snippet};
use quantization::{DepthInterval, Search, Structure, optimise};
use serde::Serialize;
use std::io::{self, Write};
use std::time::Instant;

/// Optimise the affine transform in which moments are stored (MSM15 section 4.3), and bound what any could gain.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("functions").required(true).multiple(false).args(["order", "basis"]))]
pub(crate) struct Arguments {
    /// Number of power moments z, z^2, ..; short for --basis power:M.
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    order: Option<String>,
    /// power:M, trig:N, or formulas in z separated by commas, such as "z,z^2,exp(-2z)".
    #[arg(long, value_parser = parse_basis, allow_hyphen_values = true)]
    basis: Option<Basis>,
    /// dense: any matrix; parity: rows even or odd about the middle of the depth range, which with depths from -1 to 1
    /// leaves half of the entries zero.
    #[arg(long, value_enum, default_value = "dense")]
    structure: StructureName,
    /// Depths z: unit is from 0 to 1, signed from -1 to 1, or two numbers FROM,TO.
    #[arg(long, value_name = "unit|signed|FROM,TO", default_value = "unit", value_parser = parse_range,
          allow_hyphen_values = true)]
    depth_range: DepthInterval,
    /// Random starts of the search; without this as many as the order needs.
    #[arg(long)]
    starts: Option<usize>,
    /// Seed of the starts. The result depends on nothing else.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Language of the code in the human-readable form; JSON holds all.
    #[arg(long, value_enum, default_value = "wgsl")]
    language: LanguageName,
    #[command(flatten)]
    output: Output,
}

#[derive(Clone, Copy, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
enum StructureName {
    Dense,
    Parity,
}

impl From<StructureName> for Structure {
    fn from(name: StructureName) -> Self {
        match name {
            StructureName::Dense => Self::Dense,
            StructureName::Parity => Self::Parity,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum LanguageName {
    Wgsl,
    Hlsl,
    Rust,
}

impl From<LanguageName> for Language {
    fn from(name: LanguageName) -> Self {
        match name {
            LanguageName::Wgsl => Self::Wgsl,
            LanguageName::Hlsl => Self::Hlsl,
            LanguageName::Rust => Self::Rust,
        }
    }
}

fn parse_range(text: &str) -> Result<DepthInterval, String> {
    match text.trim() {
        "unit" => return Ok(DepthInterval::UNIT),
        "signed" => return Ok(DepthInterval::SIGNED),
        _ => {}
    }
    let numbers = text.split_once(',').and_then(|(from, to)| {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        Some((number(from)?, number(to)?))
    });
    let Some((from, to)) = numbers else {
        return Err("known are unit, signed and two numbers FROM,TO".to_owned());
    };
    DepthInterval::new(from, to).map_err(|error| error.to_string())
}

/// The result as recorded in JSON.
#[derive(Serialize)]
struct Answer {
    gain_bits: f64,
    /// One array a row.
    matrix: Vec<Vec<f64>>,
    offset: Vec<f64>,
    range_min: f64,
    range_max: f64,
    bound_bits: f64,
    seconds: f64,
    inverse: Vec<Vec<f64>>,
    order: usize,
    basis: String,
    structure: StructureName,
    depth_range: [f64; 2],
    /// Depths over which the functions run: those of `depth_range`, or where these are to be mapped first.
    transform_depths: [f64; 2],
    starts: usize,
    starts_at_best: usize,
    seed: u64,
    snippets: Snippets,
}

#[derive(Serialize)]
struct Snippets {
    wgsl: String,
    hlsl: String,
    rust: String,
}

/// Optimises, prints.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let fail = |error: anyhow::Error| Failure::Input(error);
    let basis = match (&arguments.order, &arguments.basis) {
        (Some(order), _) => format!("power:{order}").parse::<Basis>().map_err(|error| fail(error.into()))?,
        (None, Some(basis)) => basis.clone(),
        (None, None) => return Err(fail(anyhow::anyhow!("give --order or --basis"))),
    };
    let interval = arguments.depth_range;
    let search =
        Search { structure: arguments.structure.into(), starts: arguments.starts, seed: arguments.seed };
    let begin = Instant::now();
    // A basis, a range or a number of starts that cannot work: nothing here depends on the machine.
    let optimum = optimise(&basis, interval, &search).map_err(|error| fail(error.into()))?;
    let seconds = begin.elapsed().as_secs_f64();
    let theta = &optimum.transform;
    let m = theta.order();
    let rows = |entries: &[f64]| -> Vec<Vec<f64>> { entries.chunks_exact(m).map(<[f64]>::to_vec).collect() };
    let code = |language| snippet(language, &basis, interval, optimum.depths, theta);
    let answer = Answer {
        gain_bits: optimum.gain_bits,
        matrix: rows(theta.matrix()),
        offset: theta.offset().to_vec(),
        range_min: optimum.range_min,
        range_max: optimum.range_max,
        bound_bits: optimum.bound_bits,
        seconds,
        inverse: rows(theta.inverse()),
        order: m,
        basis: basis.to_string(),
        structure: arguments.structure,
        depth_range: [interval.start(), interval.end()],
        transform_depths: [optimum.depths.start(), optimum.depths.end()],
        starts: optimum.starts,
        starts_at_best: optimum.hits,
        seed: arguments.seed,
        snippets: Snippets {
            wgsl: code(Language::Wgsl),
            hlsl: code(Language::Hlsl),
            rust: code(Language::Rust),
        },
    };
    arguments.output.emit(&answer, |out| {
        write_table(out, &answer)?;
        writeln!(out)?;
        write!(out, "{}", code(arguments.language.into()))
    })
}

fn write_table(out: &mut dyn Write, answer: &Answer) -> io::Result<()> {
    let [from, to] = answer.depth_range;
    writeln!(out, "basis    {} on [{from}, {to}]", answer.basis)?;
    writeln!(out, "gain     {:.6} bits", answer.gain_bits)?;
    // What is printed must be proved too: round it to the safe side.
    let bound = (answer.bound_bits * 1e6).ceil() / 1e6;
    let gap = bound - answer.gain_bits;
    writeln!(out, "bound    {bound:.6} bits, so that no transform gains more than {gap:.6} bits on top")?;
    writeln!(out, "range    from {:.1e} to 1 + {:.1e}, proved", answer.range_min, answer.range_max - 1.0)?;
    let (hits, starts) = (answer.starts_at_best, answer.starts);
    writeln!(out, "search   {starts} starts, {hits} of them came as far, {:.2} s", answer.seconds)?;
    if answer.transform_depths != answer.depth_range {
        let [from, to] = answer.transform_depths;
        writeln!(
            out,
            "depths   are mapped to [{from}, {to}] first: the matrix of their own powers cannot be rounded"
        )?;
    }
    writeln!(out)?;
    let entries = || answer.matrix.iter().flatten().filter(|v| **v != 0.0);
    // Nine decimals, unless they would hide the digits.
    let decimals = entries().all(|v| (1e-3..1e9).contains(&v.abs()));
    let written = |v: f64| if decimals { format!("{v:.9}") } else { format!("{v:.9e}") };
    let width = answer.matrix.iter().flatten().map(|v| written(*v).len()).max().unwrap_or(1);
    for (row, offset) in answer.matrix.iter().zip(&answer.offset) {
        let entries: Vec<String> = row.iter().map(|v| format!("{:>width$}", written(*v))).collect();
        writeln!(out, "  {}   + {offset:.9}", entries.join(" "))?;
    }
    Ok(())
}
