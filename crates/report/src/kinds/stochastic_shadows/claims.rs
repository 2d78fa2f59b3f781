//! What SSSM15 says about stochastic soft shadow mapping.

use super::summary::StochasticTables;
use crate::kinds::rows::least_time;
use crate::page::{Claim, Measured, percent, player, recorded};
use evaluation::StochasticRecord;

pub(super) fn claims(tables: &StochasticTables<'_>) -> Vec<Claim> {
    [
        Claim::new(
            "SSSM15 8.2, Figure 13",
            "The soft shadows closely approximate the reference, with some loss of contact shadows",
            quality(tables),
        ),
        Claim::new(
            "SSSM15 1, 8.2",
            "Maps from one point give plausible results for small lights only; percentage-closer soft shadows come out too sharp",
            sizes(tables),
        ),
        Claim::new(
            "SSSM15 8.3, Figure 15",
            "Variance leaks light in penumbrae, which exponential variance largely alleviates",
            leaks(tables),
        ),
        Claim::new(
            "SSSM15 5.1",
            "A larger exponent alleviates leaking and causes numerical problems in wide penumbrae",
            exponents(tables),
        ),
        Claim::new(
            "SSSM15 5",
            "Any other pre-filterable basis may be used instead",
            other_bases(tables),
        ),
        Claim::new(
            "SSSM15 6, Figures 7 and 17",
            "One plane is sufficient near itself; more planes improve contacts",
            planes(tables),
        ),
        Claim::new(
            "SSSM15 7.3",
            "Taking a texel's middle for the circle's costs slight overblurring",
            centres(tables),
        ),
        Claim::new(
            "SSSM15 7.3, Figure 10",
            "Leaving out every second sample and smoothing over 3x3 texels gives nearly identical shadows at a quarter of the cost",
            interleaving(tables),
        ),
        Claim::new(
            "SSSM15 7.2",
            "Coarse levels extend the reach of the filter: two of them are used",
            levels(tables),
        ),
        Claim::new(
            "SSSM15 8.1, Figure 12",
            "Smooth shadows even from a low-resolution map; details approach the ray-traced image with the resolution",
            resolution(tables),
        ),
        Claim::new(
            "SSSM15 8.2, Figure 14",
            "Turning an upper grid modulates the light field, which maps from one point cannot emulate",
            modulation(tables),
        ),
        Claim::new(
            "SSSM15 8.3, Figure 18",
            "Temporal noise falls with the resolution of the map",
            noise(tables),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn error(row: &StochasticRecord) -> String {
    percent(row.l1_error, 2)
}

fn with_sign(row: &StochasticRecord) -> String {
    format!("{} ({:+.2})", error(row), 100.0 * row.signed_mean)
}

/// What is said of every light, one after the other.
fn by_light(tables: &StochasticTables<'_>, say: impl Fn(&str) -> Measured<String>) -> Measured<String> {
    let all: Vec<String> = tables
        .lights()
        .map(|light| Ok(format!("{light} light {}", say(light)?)))
        .collect::<Measured<Vec<String>>>()?;
    Ok(all.join("; "))
}

fn quality(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role, class| tables.playing(role, light, class).map(error);
        Ok(format!("{}, {} at contacts", of("published", "all")?, of("published", "contact")?))
    })?;
    Ok(format!("Exponential variance on four planes errs by: {text}"))
}

fn sizes(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "all").map(with_sign);
        Ok(format!("{} against {} and {}", of("PCSS")?, of("published")?, of("mended")?))
    })?;
    Ok(format!(
        "Percentage-closer soft shadows against the stochastic map as published and with all mends, error (signed): {text}"
    ))
}

fn leaks(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "penumbra").map(with_sign);
        Ok(format!("{}, {}, {}", of("variance")?, of("published")?, of("four moments")?))
    })?;
    Ok(format!("In penumbrae variance, exponential variance and four moments, error (signed): {text}"))
}

fn exponents(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "all").map(with_sign);
        Ok(format!("{} with c = 40, {} with c = 10", of("published")?, of("smaller exponent")?))
    })?;
    Ok(format!("Error (signed): {text}; every answer is a number in [0, 1]"))
}

fn other_bases(tables: &StochasticTables<'_>) -> Measured<String> {
    let light = recorded(tables.largest())?;
    let of = |role| tables.playing(role, light, "all").map(error);
    Ok(format!(
        "Under the {light} light exponential variance {}, four moments {} ({} in 16 bits), Hausdorff {}, trigonometric {}, six \
         moments {}, eight {}",
        of("published")?,
        of("four moments")?,
        of("four moments, 16 bits")?,
        of("Hausdorff")?,
        of("trigonometric")?,
        of("six moments")?,
        of("eight moments")?
    ))
}

fn planes(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| -> Measured<String> {
            let (all, contact) =
                (tables.playing(role, light, "all")?, tables.playing(role, light, "contact")?);
            Ok(format!("{} ({})", error(all), error(contact)))
        };
        Ok(format!(
            "{}, {}, {}, {}, at receivers {}",
            of("one plane")?,
            of("two planes")?,
            of("four moments")?,
            of("eight planes")?,
            of("planes at receivers")?
        ))
    })?;
    Ok(format!(
        "Error (at contacts) with one, two, four and eight planes of an even partition, and four where receivers are: {text}"
    ))
}

fn centres(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "penumbra").map(with_sign);
        Ok(format!("{} and {}", of("four moments")?, of("projected")?))
    })?;
    Ok(format!("In penumbrae with texels' middles and with projected centres, error (signed): {text}"))
}

fn interleaving(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "all").map(error);
        Ok(format!("{} and {}", of("four moments")?, of("every sample")?))
    })?;
    let time = |role| -> Measured<f64> {
        let name = &player(&tables.experiment.technique, role)?.name;
        recorded(least_time(&tables.samples, name, "filter"))
    };
    Ok(format!(
        "Error of every second and of every sample: {text}; all planes take {:.0} and {:.0} ns a texel on one core",
        time("four moments")?,
        time("every sample")?
    ))
}

fn levels(tables: &StochasticTables<'_>) -> Measured<String> {
    let cut = |light: &str| -> Measured<f64> {
        let name = &player(&tables.experiment.technique, "published")?.name;
        let rows = tables.planes.iter().filter(|r| r.light == light && r.technique == *name);
        recorded(rows.map(|r| r.cut_off).max_by(f64::total_cmp))
    };
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "all").map(error);
        let share = percent(cut(light)?, 1);
        Ok(format!(
            "{} and {} (up to {share} of a plane's samples cut off)",
            of("four moments")?,
            of("six levels")?
        ))
    })?;
    Ok(format!("Error with two and six coarse levels: {text}"))
}

fn resolution(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| tables.playing(role, light, "all").map(error);
        Ok(format!("{}, {}, {}", of("quarter")?, of("four moments")?, of("double")?))
    })?;
    let size = |role| tables.playing(role, recorded(tables.largest())?, "all").map(|row| row.size);
    Ok(format!(
        "Error with sides of {}, {} and {} texels: {text}",
        size("quarter")?,
        size("four moments")?,
        size("double")?
    ))
}

fn modulation(tables: &StochasticTables<'_>) -> Measured<String> {
    let light = recorded(tables.largest())?;
    let of = |role| -> Measured<String> {
        let name = &player(&tables.experiment.technique, role)?.name;
        let row = recorded(tables.modulation.iter().find(|r| r.light == light && r.technique == *name))?;
        Ok(format!("{:.2}", row.correlation))
    };
    Ok(format!(
        "Correlation with the true change under the {light} light: {} as published, {} with all mends, {} percentage-closer, {} moment \
         soft shadows",
        of("published")?,
        of("mended")?,
        of("PCSS")?,
        of("moment soft shadows")?
    ))
}

fn noise(tables: &StochasticTables<'_>) -> Measured<String> {
    let text = by_light(tables, |light| {
        let of = |role| -> Measured<String> {
            Ok(percent(recorded(tables.playing(role, light, "all")?.noise)?, 2))
        };
        Ok(format!("{}, {}, {}", of("quarter")?, of("four moments")?, of("double")?))
    })?;
    Ok(format!("Mean difference of two maps with a quarter, all and four times the texels: {text}"))
}
