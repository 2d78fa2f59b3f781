//! What the papers publish about transforms, formats and biases of stored moments.

use super::summary::QuantizationTables;
use crate::page::Claim;
use evaluation::BiasRecord;
use moment_problem::Basis;

pub(crate) fn claims(tables: &QuantizationTables) -> Vec<Claim> {
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
        Claim::new("MSM15 4.3", "An affine transform of two moments gains 2 bits", gain(2)),
        Claim::new(
            "MSM15 4.3, Figure 5",
            "Three moments gain 6.2 bits; the hull's volume becomes 0.41, 73.9 times larger",
            gain(3).zip(volume("transformed")).zip(volume("original")).map(|((gain, after), before)| {
                format!("{gain}; volume {after:.4}, {:.1} times larger", after / before)
            }),
        ),
        Claim::new("MSM15 4.3", "Four moments gain 12.3 bits", gain(4)),
        Claim::new(
            "BHS16 2.5",
            "Six moments gain 30.5 bits, \"almost certainly not the global maximum\"",
            gain(6),
        ),
        Claim::new("in circulation", "Eight moments gain 55.98 bits", gain(8)),
        Claim::new(
            "MSM15 4.3",
            "Four moments in 16 bits require alpha = 3e-5",
            alpha("Hamburger 4", "MSM15 theta_4", "unorm16").map(needed),
        ),
        Claim::new(
            "BHS16 3",
            "Four moments in a summed-area table of 32-bit integers require alpha = 5e-6",
            alpha("Hamburger 4", "MSM15 theta_4", "u32").map(needed),
        ),
        Claim::new(
            "BHS16 2.5",
            "Six moments in 10 bits require alpha = 4e-3",
            alpha("Hamburger 6", "GDC16 six moments", "unorm10").map(needed),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}
