//! What BHS16 and the papers it builds on say about translucent occluders.

use super::summary::TranslucentTables;
use crate::page::{Claim, Measured, percent, recorded};
use evaluation::TranslucentRecord;

pub(super) fn claims(tables: &TranslucentTables<'_>) -> Vec<Claim> {
    [
        Claim::new(
            "BHS16 4.3, Figure 15",
            "Blending into a moment shadow map gives plausible shadows of smoke on everything",
            quality(tables),
        ),
        Claim::new("BHS16 4", "For simple scenarios it is adequate at almost no cost", cost(tables)),
        Claim::new(
            "BHS16 4.3",
            "With variance shadow maps light leaking is unacceptable",
            variance(tables),
        ),
        Claim::new(
            "BHS16 4.3",
            "Ringing, an issue of Fourier opacity maps and convolution, cannot occur",
            ringing(tables),
        ),
        Claim::new(
            "BHS16 4.3, Figure 16",
            "Light leaking is no longer restricted to silhouettes, and grows with the complexity of what casts",
            complexity(tables),
        ),
        Claim::new(
            "BHS16 4.3",
            "No filtering is needed to avoid noise, an advantage over stochastic shadow maps",
            noise(tables),
        ),
        Claim::new(
            "BHS16 4.1",
            "Translucent surfaces are sorted back to front; any order-independent transparency should work",
            order(tables),
        ),
        Claim::new(
            "BHS16 4.3",
            "Coloured occluders take one moment shadow map a channel",
            colour(tables),
        ),
        Claim::new(
            "BHS16 4.2",
            "The optimised transform for 16 bits still has to be applied; no other moment bias is named",
            bias(tables),
        ),
        Claim::new(
            "BHS16 4.1",
            "Absorption needs one more channel and has no place for opaque occluders",
            absorption(tables),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn error(row: &TranslucentRecord) -> String {
    percent(row.l1_error, 2)
}

fn both(tables: &TranslucentTables<'_>, role: &'static str) -> Measured<String> {
    let (surfaces, inside) = (tables.playing(role, "surfaces")?, tables.playing(role, "inside")?);
    Ok(format!("{} and {}", error(surfaces), error(inside)))
}

fn quality(tables: &TranslucentTables<'_>) -> Measured<String> {
    Ok(format!(
        "On surfaces and inside smoke and glass four moments err by {}, with both bounds mixed by {}, six moments so by {}; all \
         opaque by {}",
        both(tables, "four moments")?,
        both(tables, "four moments, middle")?,
        both(tables, "six moments, middle")?,
        both(tables, "opaque")?
    ))
}

fn cost(tables: &TranslucentTables<'_>) -> Measured<String> {
    let own = tables.costs("four moments")?;
    Ok(format!(
        "Modelled: as many bytes a texel as without ({:.0}) and as many operations a receiver ({:.0}); each of {:.2} surfaces in a \
         texel moves {:.0} bytes and takes {:.0} operations",
        own.bytes_per_texel,
        own.operations_per_receiver,
        own.layers,
        own.bytes_per_layer,
        own.operations_per_layer
    ))
}

fn variance(tables: &TranslucentTables<'_>) -> Measured<String> {
    let leak = |role| -> Measured<String> {
        let row = tables.playing(role, "all")?;
        Ok(format!("{} of {} receivers", percent(row.leak, 2), percent(row.leak_share, 0)))
    };
    Ok(format!(
        "Mean leak and where: variance {}, four moments {}, six {}",
        leak("variance")?,
        leak("four moments")?,
        leak("six moments")?
    ))
}

fn ringing(tables: &TranslucentTables<'_>) -> Measured<String> {
    let ring = |role| -> Measured<String> {
        let row = tables.playing(role, "all")?;
        let above = percent(row.above_share, 1);
        Ok(format!("{above} (outside of [0, 1]: {})", percent(row.outside_share, 1)))
    };
    Ok(format!(
        "Receivers darker than the truth by 1 %: Fourier 16 {}, Fourier 32 {}, convolution {}, four moments {}, mixed bounds {}",
        ring("Fourier 16")?,
        ring("Fourier 32")?,
        ring("convolution")?,
        ring("four moments")?,
        ring("four moments, middle")?
    ))
}

fn complexity(tables: &TranslucentTables<'_>) -> Measured<String> {
    let name = recorded(tables.named("four moments"))?;
    let rows = tables.groups.iter().filter(|g| g.by == "layers" && g.technique == name);
    let all: Vec<String> = rows.map(|g| format!("{} layers {}", g.group, percent(g.l1_error, 1))).collect();
    recorded(
        (!all.is_empty()).then(|| format!("Error of four moments by layers in front: {}", all.join(", "))),
    )
}

fn noise(tables: &TranslucentTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, "all").map(error);
    Ok(format!(
        "With 1, 4, 8 and 16 samples a texel stochastic maps err by {}, {}, {} and {} after the 9x9 filter; four moments by {}",
        of("stochastic 1")?,
        of("stochastic 4")?,
        of("stochastic 8")?,
        of("stochastic 16")?,
        of("four moments")?
    ))
}

fn order(tables: &TranslucentTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, "all").map(error);
    Ok(format!(
        "Exact order {}, by triangles' centres {}, unsorted {}; moments of absorbance, which need no order, {}",
        of("four moments")?,
        of("centre")?,
        of("unsorted")?,
        of("absorbance 4")?
    ))
}

fn colour(tables: &TranslucentTables<'_>) -> Measured<String> {
    let name = recorded(tables.named("four moments"))?;
    let rows: Vec<_> = tables.colour.iter().filter(|r| r.technique == name).collect();
    let mean = |value: &dyn Fn(&evaluation::ColourRecord) -> f64| {
        rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64
    };
    recorded((!rows.is_empty()).then(|| {
        format!(
            "Behind stained glass, mean over red, green and blue: {} with a map a channel, {} with one for the luminance",
            percent(mean(&|r| r.l1_error), 2),
            percent(mean(&|r| r.one_map_error), 2)
        )
    }))
}

fn bias(tables: &TranslucentTables<'_>) -> Measured<String> {
    let setting = recorded(tables.experiment.stability.as_ref())?;
    let rows = tables.stability.iter().filter(|r| r.bound == "hamburger4" && r.format == "unorm16");
    let of = |case: &str| -> Measured<String> {
        let rows: Vec<_> = rows.clone().filter(|r| r.case == case).collect();
        let worst = recorded(rows.iter().max_by_key(|r| r.invalid))?;
        let needed = recorded(rows.iter().filter_map(|r| r.smallest_alpha).max_by(f64::total_cmp))?;
        Ok(format!(
            "up to {} ({} layers of opacity {}), {needed:.1e} is enough",
            percent(worst.invalid as f64 / worst.trials.max(1) as f64, 1),
            worst.layers,
            worst.opacity
        ))
    };
    Ok(format!(
        "Invalid texels of four moments in 16 bits with alpha = {:.0e}: at random depths {}; coincident layers {}",
        setting.alpha,
        of("spread")?,
        of("coincident")?
    ))
}

fn absorption(tables: &TranslucentTables<'_>) -> Measured<String> {
    let bits = |role| tables.playing(role, "all").map(|row| format!("{:.0}", row.bits_per_texel));
    Ok(format!(
        "Four moments of absorbance with opaque surfaces apart err by {} in {} bits, with them within by {} in {}; of transmittance \
         by {} in {}, six of them by {} in {}, bounds mixed",
        both(tables, "absorbance 4")?,
        bits("absorbance 4")?,
        both(tables, "absorbance 4, within")?,
        bits("absorbance 4, within")?,
        both(tables, "four moments, middle")?,
        bits("four moments, middle")?,
        both(tables, "six moments, middle")?,
        bits("six moments, middle")?
    ))
}
