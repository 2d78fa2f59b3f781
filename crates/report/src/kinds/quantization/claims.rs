//! What the papers publish about transforms, formats and biases of stored moments.

use super::summary::QuantizationTables;
use crate::page::{Claim, Measured, Missing, Text, recorded};
use evaluation::MomentBound;
use moment_problem::Basis;

pub(crate) fn claims(tables: &QuantizationTables<'_>) -> Vec<Claim> {
    let needed = |bound, transform, format| needed(tables, bound, transform, format);
    [
        Claim::new("MSM15 4.3", "An affine transform of two moments gains 2 bits", gain(tables, 2)),
        Claim::new(
            "MSM15 4.3, Figure 5",
            "Three moments gain 6.2 bits; the hull's volume becomes 0.41, 73.9 times larger",
            hull(tables),
        ),
        Claim::new("MSM15 4.3", "Four moments gain 12.3 bits", gain(tables, 4)),
        Claim::new(
            "BHS16 2.5",
            "Six moments gain 30.5 bits, \"almost certainly not the global maximum\"",
            gain(tables, 6),
        ),
        Claim::new("in circulation", "Eight moments gain 55.98 bits", gain(tables, 8)),
        Claim::new(
            "MSM15 4.3",
            "Four moments in 16 bits require alpha = 3e-5",
            needed(MomentBound::Hamburger4, "MSM15 theta_4", "unorm16"),
        ),
        Claim::new(
            "BHS16 3",
            "Four moments in a summed-area table of 32-bit integers require alpha = 5e-6",
            needed(MomentBound::Hamburger4, "MSM15 theta_4", "u32"),
        ),
        Claim::new(
            "BHS16 2.5",
            "Six moments in 10 bits require alpha = 4e-3",
            needed(MomentBound::Hamburger6, "GDC16 six moments", "unorm10"),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn gain(tables: &QuantizationTables<'_>, m: usize) -> Measured<String> {
    let basis = Basis::power(m).to_string();
    let mut gains = tables.gains.iter();
    let found = gains.find(|g| g.basis == basis && g.bound_bits.is_some() && g.transform == "dense");
    let unasked = || Missing::Unasked(Text::from("no gain is sought for ").code(&basis));
    let found = found.ok_or_else(unasked)?;
    let (gain, bound) = recorded(found.gain_bits.zip(found.bound_bits))?;
    Ok(format!("{gain:.4} bits; no transform gains more than {bound:.4}, proved"))
}

fn hull(tables: &QuantizationTables<'_>) -> Measured<String> {
    let volume = |curve| recorded(tables.hull.iter().find(|h| h.curve == curve).map(|h| h.hull_volume));
    let (gain, after, before) = (gain(tables, 3)?, volume("transformed")?, volume("original")?);
    Ok(format!("{gain}; volume {after:.4}, {:.1} times larger", after / before))
}

/// The least bias of a bound whose moments are stored by a transform in a format of this family.
fn needed(
    tables: &QuantizationTables<'_>,
    bound: MomentBound,
    transform: &str,
    format: &str,
) -> Measured<String> {
    let of = tables
        .biases
        .iter()
        .filter(|b| b.bound == bound.name() && b.transform == transform && b.format.starts_with(format));
    let least = of.min_by(|a, b| a.alpha_999.total_cmp(&b.alpha_999));
    let unasked = || {
        let what = format!("{} is not stored by ", bound.name());
        Missing::Unasked(Text::from(what).code(transform).and(" in ").code(format))
    };
    let least = least.ok_or_else(unasked)?;
    Ok(format!(
        "{:.1e} keeps 99.9 % of the scenes' vectors valid, {:.1e} all of them",
        least.alpha_999, least.alpha_all
    ))
}
