//! What the records of a quantisation experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::{Text, in_percent};
use evaluation::{
    BiasRecord, CodeRecord, ComparisonRecord, GainRecord, GainSample, HullRecord, QuantizationRecord,
    ViewRecord,
};
use moment_problem::Basis;

tables! {
    /// The recorded tables of a run.
    QuantizationTables {
        records: QuantizationRecord,
        gains: GainRecord,
        biases: BiasRecord,
        comparison: ComparisonRecord,
        hull: HullRecord,
        codes: CodeRecord,
        views: ViewRecord,
        samples: GainSample,
    }
}

/// A difference of less than so many standard errors is none.
const CERTAIN: f64 = 3.0;

impl QuantizationTables {
    /// Error of a bound whose moments are not quantised.
    pub(crate) fn exact(&self, bound: &str, kernel: &str) -> Option<f64> {
        let exact = |r: &&QuantizationRecord| r.target == "exact" && r.bound == bound && r.kernel == kernel;
        self.records.iter().find(exact).map(|r| r.l1_error)
    }

    /// The b* of least error for each bound, transform, format and filter, in the order of the records.
    pub(crate) fn best(&self) -> Vec<&BiasRecord> {
        let mut best: Vec<&BiasRecord> = Vec::new();
        for bias in &self.biases {
            match best.iter_mut().find(|b| same_storage(b, bias)) {
                Some(known) if bias.best_l1_error < known.best_l1_error => *known = bias,
                Some(_) => {}
                None => best.push(bias),
            }
        }
        best
    }

    /// The b* with which the least alpha makes nearly all moment vectors valid, for the same storage as `bias`.
    pub(crate) fn most_valid(&self, bias: &BiasRecord) -> Option<&BiasRecord> {
        let same = self.biases.iter().filter(|b| same_storage(b, bias));
        same.min_by(|a, b| a.alpha_999.total_cmp(&b.alpha_999))
    }

    pub(crate) fn seconds(&self, basis: &str, structure: &str) -> Option<f64> {
        let sample = self.samples.iter().find(|s| s.basis == basis && s.structure == structure)?;
        Some(sample.time_ns as f64 * 1e-9)
    }

    /// The answer to the experiment's question.
    pub(crate) fn answer(&self) -> Vec<Text> {
        let mut sentences: Vec<String> = Vec::new();
        for (m, word) in [(4, "Four"), (6, "Six")] {
            let basis = Basis::power(m).to_string();
            let of_order = || self.gains.iter().filter(|g| g.basis == basis);
            let gain = |g: &&GainRecord| g.gain_bits;
            let found = of_order().find(|g| g.bound_bits.is_some() && g.transform == "dense");
            let published =
                of_order().filter(|g| g.bound_bits.is_none()).filter_map(|g| gain(&g)).fold(0.0, f64::max);
            if let Some((gained, bound)) = found.and_then(|g| Some((g.gain_bits?, g.bound_bits?))) {
                sentences.push(format!(
                    "{word} power moments gain {gained:.4} bits (published {published:.4}), and no transform gains more \
                     than {bound:.2}."
                ));
            }
        }
        let four = |transform: &str| {
            self.best()
                .into_iter()
                .find(|b| b.bound == "Hamburger 4" && b.format == "unorm16" && b.transform == transform)
        };
        if let (Some(theta), Some(plain)) = (four("MSM15 theta_4"), four("plain"))
            && let Some(exact) = self.exact("Hamburger 4", &theta.kernel)
        {
            let pair = |b: &BiasRecord| {
                let valid = self.most_valid(b).unwrap_or(b);
                format!(
                    "{} % at the bias of least error and {} % where 99.9 % of the vectors are valid (alpha = {:.1e})",
                    percent(b.best_l1_error),
                    percent(valid.valid_l1_error),
                    valid.alpha_999
                )
            };
            sentences.push(format!(
                "Four moments err by {} %; with sixteen bits each and MSM15's transform by {}, without a transform by {}.",
                percent(exact),
                pair(theta),
                pair(plain)
            ));
        }
        for c in
            self.comparison.iter().filter(|c| c.bound == "Hamburger 6" && c.transform.starts_with("ours"))
        {
            let verdict = if c.difference.abs() < CERTAIN * c.standard_error {
                "buys nothing that this sample could show"
            } else if c.difference < 0.0 {
                "is better"
            } else {
                "is worse"
            };
            sentences.push(format!(
                "Our transform of six moments {verdict} in {}: {} % against {} % of the published one, difference {:.4} ± {:.4} points.",
                c.format,
                percent(c.l1_error),
                percent(c.baseline_l1_error),
                100.0 * c.difference,
                100.0 * c.standard_error
            ));
        }
        sentences.into_iter().map(Text::from).collect()
    }
}

fn same_storage(a: &BiasRecord, b: &BiasRecord) -> bool {
    (&a.bound, &a.transform, &a.format, &a.kernel, &a.range)
        == (&b.bound, &b.transform, &b.format, &b.kernel, &b.range)
}

/// In percent, with the digits that tell transforms apart.
pub(crate) fn percent(fraction: f64) -> String {
    in_percent(fraction, 3)
}
