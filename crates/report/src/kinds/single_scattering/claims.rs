//! What BHS16 and its talk say about single scattering.

use super::summary::{ALL, ScatteringTables};
use crate::kinds::rows::least_time;
use crate::page::{Claim, Measured, Missing, Text, percent, recorded};
use evaluation::{ScatteringPictureRecord, ScatteringRecord, StoredBiasRecord};

/// Time with filtered resampling over that without, 1.1 ms / 0.71 ms.
const PUBLISHED_RATIO: f64 = 1.1 / 0.71;

pub(super) fn claims(tables: &ScatteringTables<'_>) -> Vec<Claim> {
    [
        Claim::new(
            "BHS16 2.5, Figure 5",
            "Six moments reduce the excessively sharp boundaries of four moments heavily",
            boundaries(tables),
        ),
        Claim::new(
            "BHS16 2.6",
            "16 bits per channel give six moments no significant advantage over 10 bits",
            bits(tables),
        ),
        Claim::new(
            "BHS16 2.5",
            "Six moments with 10 bits need a moment bias of 4e-3, no serious problem here",
            bias(tables),
        ),
        Claim::new(
            "BHS16 2.6, Figures 4 and 5",
            "Convolution shadow maps with 32 coefficients ring strongly, moments do not",
            ringing(tables),
        ),
        Claim::new("BHS16 2.4", "beta = 0.5 achieves a minimal worst-case error", blends(tables)),
        Claim::new(
            "BHS16 2.6",
            "Strong leaking at the epipole, shared by all prefiltered methods",
            epipole(tables),
        ),
        Claim::new(
            "BHS16 2.3, Figure 6",
            "Filtering while resampling reduces aliasing heavily",
            aliasing(tables),
        ),
        Claim::new(
            "BHS16 2.2",
            "One distance between samples, for the mean of the bounds of theta, suffices",
            spacing(tables),
        ),
        Claim::new(
            "BHS16 2.6",
            "Four moments should be used for subtle scattering only, six are high quality",
            orders(tables),
        ),
        Claim::new("GDC16", "Ray marching with 128 samples is the ground truth", marching(tables)),
        Claim::new(
            "GDC16",
            "Blending the bounds by the angle to the light keeps objectionable artefacts to a minimum",
            adaptive(tables),
        ),
        Claim::new(
            "BHS16 2.6",
            "Convolution shadow maps take 256 bits a texel, moments 64, and are substantially more expensive",
            expense(tables),
        ),
        Claim::new(
            "BHS16 2.6",
            "0.71 ms without and 1.1 ms with filtered resampling, 1.55 times (six moments, 1024², 1920x1080)",
            times(tables),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn error(row: &ScatteringRecord) -> String {
    percent(row.l1_error, 2)
}

fn signed(row: &ScatteringRecord) -> String {
    format!("{} ({:+.2})", error(row), 100.0 * row.signed_mean)
}

/// Rows of some roles in the first picture that has all of them.
fn pictured<'a, const N: usize>(
    tables: &'a ScatteringTables<'_>,
    roles: [&'static str; N],
) -> Measured<[&'a ScatteringPictureRecord; N]> {
    let mut names = Vec::new();
    for role in roles {
        names.push(tables.name(role)?);
    }
    let of = |picture: &str| {
        let row = |name: &&str| tables.pictures.iter().find(|r| r.picture == picture && r.technique == *name);
        names.iter().map(row).collect::<Option<Vec<_>>>()
    };
    let found = tables.experiment.picture.iter().find_map(|picture| of(&picture.id));
    recorded(found.and_then(|rows| rows.try_into().ok()))
}

fn boundaries(tables: &ScatteringTables<'_>) -> Measured<String> {
    let [four, six] = pictured(tables, ["four moments", "six moments"])?;
    Ok(format!(
        "In {} {} of smooth neighbours differ by more than 5 % with four, {} with six moments; their errors differ by {} and {} on \
         average",
        four.picture,
        percent(four.boundaries, 2),
        percent(six.boundaries, 2),
        percent(four.roughness, 2),
        percent(six.roughness, 2)
    ))
}

fn bits(tables: &ScatteringTables<'_>) -> Measured<String> {
    let (ten, sixteen) = (tables.playing("six moments", ALL)?, tables.playing("six moments, 16 bits", ALL)?);
    Ok(format!("Error (signed) {} with 10 bits, {} with 16", signed(ten), signed(sixteen)))
}

fn bias(tables: &ScatteringTables<'_>) -> Measured<String> {
    let asked = tables.experiment.stability.as_ref();
    if asked.is_none() {
        return Err(Missing::Unasked(Text::from("no stability")));
    }
    let rows: Vec<&StoredBiasRecord> =
        tables.stability.iter().filter(|r| r.bound == "hamburger6" && r.format == "unorm10").collect();
    let at = |wanted: f64| {
        let distance = |r: &&&StoredBiasRecord| (r.alpha / wanted).ln().abs();
        recorded(rows.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))))
    };
    let best = recorded(rows.iter().min_by(|a, b| a.l1_error.total_cmp(&b.l1_error)))?;
    let (near, low) = (at(4e-3)?, at(1e-3)?);
    let words = |r: &StoredBiasRecord| {
        let share = r.invalid as f64 / r.rays.max(1) as f64;
        format!("{} at {:.1e} ({} invalid)", percent(r.l1_error, 2), r.alpha, percent(share, 2))
    };
    let whole = |role| tables.playing(role, ALL).map(error);
    Ok(format!(
        "Over all views {} with 4e-3, {} with 1e-5; on some rays in single precision {}, {}, least {}",
        whole("six moments")?,
        whole("six moments, small bias")?,
        words(near),
        words(low),
        words(best)
    ))
}

fn ringing(tables: &ScatteringTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, ALL);
    let (convolution, four, six) = (of("convolution")?, of("four moments")?, of("six moments")?);
    let errors =
        format!("Error (signed) {}, four moments {}, six {}", signed(convolution), signed(four), signed(six));
    match pictured(tables, ["convolution", "six moments"]) {
        Ok([rings, smooth]) => Ok(format!(
            "{errors}; errors of smooth neighbours differ by {} and with six moments by {} ({})",
            percent(rings.roughness, 2),
            percent(smooth.roughness, 2),
            rings.picture
        )),
        Err(_) => Ok(errors),
    }
}

fn blends(tables: &ScatteringTables<'_>) -> Measured<String> {
    let words = |role| -> Measured<String> {
        let row = tables.playing(role, ALL)?;
        Ok(format!("{}, p95 {}, largest {}", error(row), percent(row.p95, 1), percent(row.maximum, 1)))
    };
    Ok(format!(
        "Six moments: beta 0: {}; 0.5: {}; 1: {}",
        words("beta 0")?,
        words("six moments")?,
        words("beta 1")?
    ))
}

fn epipole(tables: &ScatteringTables<'_>) -> Measured<String> {
    let words = |role| -> Measured<String> {
        let of = |class| tables.playing(role, ("epipole", class));
        Ok(format!("{} within 5 degrees, {} beyond 60", signed(of("0-5")?), signed(of("60-90")?)))
    };
    Ok(format!(
        "Error (signed): six moments {}; exact distributions {}; 128 samples {}",
        words("six moments")?,
        words("exact")?,
        words("128 samples")?
    ))
}

fn aliasing(tables: &ScatteringTables<'_>) -> Measured<String> {
    if tables.experiment.aliasing.is_none() {
        return Err(Missing::Unasked(Text::from("no aliasing")));
    }
    let flicker = |role| -> Measured<f64> { recorded(tables.flicker(tables.name(role)?)) };
    let (without, with) = (flicker("six moments")?, flicker("six moments, filtered")?);
    Ok(format!(
        "Beside what the truth does pictures change by {} without, {} with a filter, {:.2} times less, while the camera moves by parts of a pixel",
        percent(without, 3),
        percent(with, 3),
        without / with
    ))
}

fn spacing(tables: &ScatteringTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, ALL).map(error);
    Ok(format!(
        "With exact distributions in place of moments {}; {} for the mean of each row's bounds, {} for the mean sine between them, {} \
         for that of its rays, {} by two maps, {} with each ray's own",
        of("exact, mean")?,
        of("exact, bounds")?,
        of("exact")?,
        of("exact, rays")?,
        of("exact, two")?,
        of("exact, own")?
    ))
}

fn orders(tables: &ScatteringTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, ALL).map(signed);
    Ok(format!(
        "Error (signed) two {}, four {}, six {}, eight {}",
        of("two moments")?,
        of("four moments")?,
        of("six moments")?,
        of("eight moments")?
    ))
}

fn marching(tables: &ScatteringTables<'_>) -> Measured<String> {
    let words = |role| -> Measured<String> {
        let row = tables.playing(role, ALL)?;
        Ok(format!("{}, p95 {}", error(row), percent(row.p95, 2)))
    };
    Ok(format!(
        "128 samples err by {}; 32 by {}; 256 by {}",
        words("128 samples")?,
        words("32 samples")?,
        words("256 samples")?
    ))
}

fn adaptive(tables: &ScatteringTables<'_>) -> Measured<String> {
    let words = |role| -> Measured<String> {
        let near = tables.playing(role, ("epipole", "0-5"));
        let near = near.map_or_else(
            |_| String::new(),
            |row| format!(", within 5 degrees of the epipole {}", signed(row)),
        );
        Ok(format!("{}{near}", signed(tables.playing(role, ALL)?)))
    };
    Ok(format!("Error (signed) adaptive {}; beta 0.5 {}", words("adaptive")?, words("six moments")?))
}

fn expense(tables: &ScatteringTables<'_>) -> Measured<String> {
    let of = |role| -> Measured<_> {
        let name = tables.name(role)?;
        let cost = recorded(tables.costs.iter().find(|cost| cost.technique == name))?;
        Ok((cost, recorded(tables.pooled(name, ALL))?.bits_per_texel))
    };
    let ((convolution, bits), (six, few)) = (of("convolution")?, of("six moments")?);
    Ok(format!(
        "{bits} and {few} bits; modelled cost of a frame {:.0} and {:.0} MB, {:.2} times",
        convolution.total,
        six.total,
        convolution.total / six.total
    ))
}

fn times(tables: &ScatteringTables<'_>) -> Measured<String> {
    let time = |role| -> Measured<f64> {
        let name = tables.name(role)?;
        let of = |stage| recorded(least_time(&tables.samples, name, stage));
        Ok(of("resample")? + of("prefix")?)
    };
    let (without, with) = (time("six moments")?, time("six moments, filtered")?);
    let on_gpu = tables.gpu_time(tables.name("six moments")?);
    let on_gpu = on_gpu.map_or_else(String::new, |time| {
        format!("; without a filter {time:.2} ms on the graphics processor")
    });
    Ok(format!(
        "On one core {without:.0} and {with:.0} ns a texel of the rectified map, {:.2} times (published {PUBLISHED_RATIO:.2} with the look-ups){on_gpu}",
        with / without
    ))
}
