//! What the papers publish beside what runs measured.

use crate::error::ReportError;
use crate::quantization_summary::QuantizationTables;
use crate::search_summary::{SearchTables, error};
use crate::speed_summary::SpeedTables;
use crate::stability_summary::StabilityTables;
use crate::{filterable_summary, stability_claims};
use evaluation::{
    BiasRecord, Experiment, FilterableExperiment, Provenance, QuantizationExperiment, RunDirectory, Scale,
    SearchExperiment, SpeedAccuracyExperiment, StabilityExperiment,
};
use moment_problem::Basis;
use std::fmt::Write as _;

/// Error of four power moments over that of trigonometric moments, 2.19 % / 1.93 % (MSM15 section 3.2).
const PUBLISHED_RATIO: f64 = 2.19 / 1.93;

/// One published statement or number with its counterpart.
pub(crate) struct Published {
    /// Paper and section.
    pub(crate) source: &'static str,
    /// What it says.
    pub(crate) says: String,
    /// What the run says.
    pub(crate) measured: String,
}

fn row(source: &'static str, says: &str, measured: Option<String>) -> Option<Published> {
    Some(Published { source, says: says.to_owned(), measured: measured? })
}

/// The rows of one run; none where its records lack what is needed.
pub(crate) fn of_run(run: &RunDirectory) -> Result<Vec<Published>, ReportError> {
    let experiment = Experiment::read(&run.path().join("experiment.toml"), Scale::Quick, None)?;
    if let Some(filterable) = experiment.settings::<FilterableExperiment>() {
        Ok(of_filterable(&filterable_summary::Tables::read(run, filterable)?, filterable))
    } else if experiment.settings::<QuantizationExperiment>().is_some() {
        Ok(of_quantization(&QuantizationTables::read(run)?))
    } else if let Some(search) = experiment.settings::<SearchExperiment>() {
        Ok(of_search(&SearchTables::read(run)?, search, &run.provenance()?))
    } else if let Some(stability) = experiment.settings::<StabilityExperiment>() {
        Ok(stability_claims::published(&StabilityTables::read(run, stability)?))
    } else if let Some(speed) = experiment.settings::<SpeedAccuracyExperiment>() {
        Ok(of_speed(&SpeedTables::read(run, speed)?))
    } else {
        Ok(Vec::new())
    }
}

pub(crate) fn of_search(
    tables: &SearchTables,
    experiment: &SearchExperiment,
    provenance: &Provenance,
) -> Vec<Published> {
    let all = tables.of(4).len();
    let programs: u64 = tables.stages.iter().map(|stage| stage.programs).sum();
    let ratio = |trigonometric: f64, power: f64| format!("{:.3} times", power / trigonometric);
    let both = tables.trigonometric().zip(tables.power());
    let rank = |r: &evaluation::SearchRecord| {
        format!("rank {} ({} to {}) with {}", r.rank, r.rank_low, r.rank_high, error(r))
    };
    [
        row(
            "MSM15 3.2",
            "66 045 bases of four of 37 functions; 392 billion linear programs, several weeks on a cluster",
            (all > 0).then(|| {
                format!(
                    "{all} bases of four of {} functions; {:.0} million certified programs, as bases that cannot win leave \
                     early; {:.0} s on {} threads ({})",
                    experiment.functions().map_or(0, |f| f.len()),
                    programs as f64 / 1e6,
                    provenance.seconds,
                    provenance.threads,
                    provenance.cpu
                )
            }),
        ),
        row(
            "MSM15 3.2",
            "The trigonometric moment problem realises the minimal error, 1.93 %",
            tables.trigonometric().zip(tables.of(4).first()).map(|(trigonometric, best)| {
                format!("{}; the best, `{}`, {}", rank(trigonometric), best.basis, error(best))
            }),
        ),
        row(
            "MSM15 3.2",
            &format!(
                "Four power moments err by 2.19 %, {PUBLISHED_RATIO:.3} times the trigonometric ones; both are among \
                 the smallest"
            ),
            both.map(|(t, p)| format!("{}, {}", rank(p), ratio(t.l1_error, p.l1_error))),
        ),
        row(
            "MSM15 Figure 4",
            "Many candidates perform similarly well",
            tables.of(4).first().map(|best| {
                let near = tables.of(4).iter().filter(|r| r.l1_error <= 1.1 * best.l1_error).count();
                format!("{near} are within a tenth of the best one's error")
            }),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub(crate) fn of_filterable(
    tables: &filterable_summary::Tables,
    experiment: &FilterableExperiment,
) -> Vec<Published> {
    // An experiment about the reference itself is not what the papers measured.
    if experiment.bias.iter().any(|bias| bias.reference != experiment.bias[0].reference) {
        return Vec::new();
    }
    let pooled = |name: &str| tables.row(("all", "all"), name, 0, "all").map(|r| r.l1_error);
    let percent = |value: f64| format!("{:.2} %", 100.0 * value);
    let (hamburger, trigonometric) = (pooled("Hamburger 4"), pooled("Trigonometric 4"));
    let best = tables.pooled(0);
    let others: Vec<String> = ["VSM", "EVSM 4, c = 10", "ESM, c = 80", "CSM, M = 16"]
        .iter()
        .filter_map(|name| Some(format!("{name} {}", percent(pooled(name)?))))
        .collect();
    let agreements = tables.agreements();
    [
        row(
            "MSM15 3.2",
            "Mean distance from percentage-closer filtering: 1.93 % for trigonometric moments, 2.19 % for power moments \
             (scenes and depth bias not public)",
            hamburger.zip(trigonometric).map(|(hamburger, trigonometric)| {
                format!(
                    "{} and {} by the closed forms ({:.3} times, published {PUBLISHED_RATIO:.3})",
                    percent(trigonometric),
                    percent(hamburger),
                    hamburger / trigonometric
                )
            }),
        ),
        row(
            "MSM15 5",
            "Four moments produce less artifacts than other filterable shadow maps; trigonometric moments leak as much as \
             Hausdorff",
            hamburger.zip(pooled("Hausdorff 4")).zip(trigonometric).map(|((hamburger, hausdorff), t)| {
                format!(
                    "Hamburger 4 {}, Hausdorff 4 {}, trigonometric 4 {}; {}",
                    percent(hamburger),
                    percent(hausdorff),
                    percent(t),
                    others.join(", ")
                )
            }),
        ),
        row(
            "MSM15 4",
            "The closed forms of Hausdorff and trigonometric moments solve Problem 1",
            (!agreements.is_empty() && experiment.agreement_fragments > 0).then(|| {
                let of = |a: &filterable_summary::Agreement| {
                    format!("{} within {:.1e} on {} fragments", a.technique, a.largest, a.fragments)
                };
                let all: Vec<String> = agreements.iter().map(of).collect();
                format!("Against the certified linear program: {}", all.join(", "))
            }),
        ),
        row(
            "MSM15 3",
            "Solutions of Problem 1 never overestimate the shadow",
            best.iter().any(|r| r.unbiased_violations.is_some()).then(|| {
                let checked = best.iter().filter(|r| r.unbiased_violations.is_some());
                let (mut violations, mut fragments) = (0, 0);
                for r in checked {
                    violations += r.unbiased_violations.unwrap_or_default();
                    fragments += r.fragments;
                }
                format!("{violations} of {fragments} comparisons without biases do")
            }),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub(crate) fn of_quantization(tables: &QuantizationTables) -> Vec<Published> {
    let gain = |m: usize| {
        let basis = Basis::power(m).to_string();
        let found = tables
            .gains
            .iter()
            .find(|g| g.basis == basis && g.bound_bits.is_some() && g.transform == "dense")?;
        Some(format!(
            "{:.4} bits; no transform gains more than {:.4}, proved",
            found.gain_bits?, found.bound_bits?
        ))
    };
    let volume = |curve: &str| tables.hull.iter().find(|h| h.curve == curve).map(|h| h.hull_volume);
    let alpha = |bound: &str, transform: &str, format: &str| -> Option<&BiasRecord> {
        let of =
            |b: &&BiasRecord| b.bound == bound && b.transform == transform && b.format.starts_with(format);
        tables.biases.iter().filter(of).min_by(|a, b| a.alpha_999.total_cmp(&b.alpha_999))
    };
    let needed = |b: &BiasRecord| {
        format!(
            "{:.1e} keeps 99.9 % of the scenes' vectors valid, {:.1e} all of them",
            b.alpha_999, b.alpha_all
        )
    };
    [
        row("MSM15 4.3", "An affine transform of two moments gains 2 bits", gain(2)),
        row(
            "MSM15 4.3, Figure 5",
            "Three moments gain 6.2 bits; the hull's volume becomes 0.41, 73.9 times larger",
            gain(3).zip(volume("transformed")).zip(volume("original")).map(|((gain, after), before)| {
                format!("{gain}; volume {after:.4}, {:.1} times larger", after / before)
            }),
        ),
        row("MSM15 4.3", "Four moments gain 12.3 bits", gain(4)),
        row("BHS16 2.5", "Six moments gain 30.5 bits, \"almost certainly not the global maximum\"", gain(6)),
        row("in circulation", "Eight moments gain 55.98 bits", gain(8)),
        row(
            "MSM15 4.3",
            "Four moments in 16 bits require alpha = 3e-5",
            alpha("Hamburger 4", "MSM15 theta_4", "unorm16").map(needed),
        ),
        row(
            "BHS16 3",
            "Four moments in a summed-area table of 32-bit integers require alpha = 5e-6",
            alpha("Hamburger 4", "MSM15 theta_4", "u32").map(needed),
        ),
        row(
            "BHS16 2.5",
            "Six moments in 10 bits require alpha = 4e-3",
            alpha("Hamburger 6", "GDC16 six moments", "unorm10").map(needed),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub(crate) fn of_speed(tables: &SpeedTables) -> Vec<Published> {
    let adapter = tables.gpu.as_ref().map(|gpu| gpu.adapter.clone()).unwrap_or_default();
    let time = |technique: &str, format: &str| tables.gpu_time(technique, format).map(|t| t.1);
    let pair = |[a, b]: [(&str, &str); 2]| {
        let (x, y) = (time(a.0, a.1)?, time(b.0, b.1)?);
        Some(format!("{x:.2} and {y:.2} ms, {:.2} times, on {adapter}", y / x))
    };
    [
        row(
            "MSM15 5, Figure 7",
            "A frame with VSM in 32 bits and with four moments in 16 bits takes almost identical times",
            pair([("VSM", "f32"), ("Hamburger 4", "unorm16")]),
        ),
        row(
            "MSM15 5",
            "VSM in 16 bits performs identical to ESM",
            pair([("ESM, c = 80", "f32"), ("VSM", "unorm16")]),
        ),
        row(
            "MSM15 5",
            "In 16 bits Hausdorff 4MSM is only slightly slower than Hamburger 4MSM",
            pair([("Hamburger 4", "unorm16"), ("Hausdorff 4", "unorm16")]),
        ),
        row(
            "MSM15 5",
            "The frame time for filterable shadow maps is governed by the memory per texel",
            tables.times_by_bits(),
        ),
        row(
            "MSM15 5",
            "Hamburger 4MSM outperforms PCF for large output resolutions, large filter kernels and small shadow maps",
            tables.faster_than_comparison(("Hamburger 4", "unorm16")),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The rows as a table; nothing without rows.
pub(crate) fn table(rows: &[Published]) -> String {
    let mut text = String::new();
    if rows.is_empty() {
        return text;
    }
    text.push_str("| source | published | here |\n|---|---|---|\n");
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {} | {} | {} |", row.source, row.says, row.measured);
    }
    text
}

/// What the papers publish about applications that msm does not have yet.
const NOT_BUILT: [(&str, &str); 2] = [
    (
        "BHS16 2",
        "Single scattering with six moments takes 0.71 ms, 1.1 ms with filtering (1920x1080, 1024² map, GTX 980)",
    ),
    ("BHS16 3", "Moment soft shadows take 2.7 ms, 3.48 ms interpolated (same setting)"),
];

/// One table over several runs: what was published, what was measured, and by which command.
///
/// # Errors
/// [`ReportError::Records`] for records that cannot be read.
pub fn comparison(runs: &[RunDirectory]) -> Result<String, ReportError> {
    let mut text = "| source | published | here | by `msm` ... |\n|---|---|---|---|\n".to_owned();
    for run in runs {
        let command = run.provenance()?.command;
        let command = command.strip_prefix("msm ").unwrap_or(&command).to_owned();
        for row in of_run(run)? {
            let _ = writeln!(text, "| {} | {} | {} | `{command}` |", row.source, row.says, row.measured);
        }
    }
    for (source, says) in NOT_BUILT {
        let _ = writeln!(text, "| {source} | {says} | not built yet | |");
    }
    Ok(text)
}
