//! What BHS16 says about soft shadows.

use super::summary::SoftTables;
use crate::kinds::rows::least_time;
use crate::page::{Claim, Measured, Missing, Text, percent, player, recorded};
use evaluation::{Population, SoftPictureRecord, SoftRecord, SweepRecord};

const ALL: (&str, &str) = ("all", "all");

/// Time with interpolation over that without, 3.48 ms / 2.7 ms.
const PUBLISHED_RATIO: f64 = 3.48 / 2.7;

pub(super) fn claims(tables: &SoftTables<'_>) -> Vec<Claim> {
    [
        Claim::new(
            "BHS16 3.3",
            "The choice epsilon = 0.01 worked well in all experiments",
            sweep(tables, "epsilon", "four moments", 0.01),
        ),
        Claim::new(
            "BHS16 3.4",
            "alpha = 5e-6 is enough for a 32-bit summed-area table",
            sweep(tables, "alpha", "four moments, single precision", 5e-6),
        ),
        Claim::new(
            "BHS16 3.6, Figure 11c",
            "Without interpolation visible stripes at hard shadow boundaries; interpolation eliminates them",
            stripes(tables),
        ),
        Claim::new(
            "BHS16 3.4",
            "Randomised dithering in place of interpolation: the noise is too strong at hard shadow boundaries",
            noise(tables),
        ),
        Claim::new(
            "BHS16 3.5",
            "The umbra shortcut with a threshold of 0.99 works robustly",
            shortcut(tables),
        ),
        Claim::new(
            "BHS16 3.6, Figure 11b",
            "Naive variance soft shadow mapping leaks objectionably where moments hardly do",
            leaks(tables),
        ),
        Claim::new(
            "BHS16 3.6, Figure 13",
            "Occluders behind each other are fused wrongly by all methods, and light leaking of moments strengthens it",
            fusion(tables),
        ),
        Claim::new(
            "BHS16 3.6",
            "Limited search regions make long-range shadows of percentage-closer soft shadows too hard",
            limited(tables),
        ),
        Claim::new(
            "BHS16 3.6",
            "Interpolation takes the frame from 2.7 to 3.48 ms, 1.29 times",
            interpolation(tables),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn error(row: &SoftRecord) -> String {
    percent(row.mean_error, 2)
}

/// A value of a sweep beside the best and the extremes.
fn sweep(tables: &SoftTables<'_>, id: &str, role: &'static str, published: f64) -> Measured<String> {
    let name = &player(&tables.experiment.technique, role)?.name;
    if !tables.experiment.sweep.iter().any(|sweep| sweep.id == id && sweep.techniques.contains(name)) {
        return Err(Missing::Unasked(Text::from(format!("no sweep \"{id}\" of {name}"))));
    }
    let of = |r: &&SweepRecord| r.sweep == id && r.technique == *name && r.class == "all";
    let rows: Vec<&SweepRecord> = tables.sweeps.iter().filter(of).collect();
    let at = recorded(rows.iter().find(|r| r.value == Some(published)))?;
    let best = recorded(rows.iter().min_by(|a, b| a.mean_error.total_cmp(&b.mean_error)))?;
    let listed: Vec<String> =
        rows.iter().map(|r| format!("{} at {}", percent(r.mean_error, 2), r.setting)).collect();
    Ok(format!(
        "{} errs by {} there, {} of its answers changed visibly by rounding; the least is {} at {}: {}",
        name,
        percent(at.mean_error, 2),
        percent(at.changed as f64 / at.receivers.max(1) as f64, 2),
        percent(best.mean_error, 2),
        best.setting,
        listed.join(", ")
    ))
}

/// Rows of two roles in the first picture that has both.
fn pictured<'a>(
    tables: &'a SoftTables<'_>,
    roles: [&'static str; 2],
) -> Measured<[&'a SoftPictureRecord; 2]> {
    let [a, b] = roles.map(|role| player(&tables.experiment.technique, role));
    let (a, b) = (&a?.name, &b?.name);
    let row = |picture: &str, name: &str| {
        tables.pictures.iter().find(|r| r.picture == picture && r.technique == name)
    };
    let mut pictures = tables.experiment.picture.iter();
    recorded(pictures.find_map(|picture| Some([row(&picture.id, a)?, row(&picture.id, b)?])))
}

fn stripes(tables: &SoftTables<'_>) -> Measured<String> {
    let [without, with] = pictured(tables, ["four moments, not interpolated", "four moments"])?;
    let narrow = |role| tables.playing(role, Population::Camera, ("width", "1-4"));
    let (hard, smooth) = (narrow("four moments, not interpolated")?, narrow("four moments")?);
    Ok(format!(
        "Error differs between neighbours by {} without, {} with interpolation ({}); in penumbrae of 1 to 4 texels it is {} and {}",
        percent(without.roughness, 2),
        percent(with.roughness, 2),
        without.picture,
        error(hard),
        error(smooth)
    ))
}

fn noise(tables: &SoftTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, Population::Camera, ALL);
    let narrow = |role| tables.playing(role, Population::Camera, ("width", "1-4"));
    let (dithered, interpolated) = (of("dithered corners")?, of("four moments")?);
    Ok(format!(
        "By blue noise {} on average, {} interpolated; in penumbrae of 1 to 4 texels {} and {}",
        error(dithered),
        error(interpolated),
        error(narrow("dithered corners")?),
        error(narrow("four moments")?)
    ))
}

fn shortcut(tables: &SoftTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, Population::Fragments, ALL);
    let (with, without) = (of("four moments")?, of("four moments, no shortcut")?);
    Ok(format!(
        "Error {} with, {} without it, signed mean {} and {}",
        error(with),
        error(without),
        percent(with.signed_mean, 2),
        percent(without.signed_mean, 2)
    ))
}

fn leaks(tables: &SoftTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, Population::Camera, ALL);
    let (two, four, first) = (of("two moments")?, of("four moments")?, of("PCSS")?);
    Ok(format!(
        "Signed mean on what the camera sees: {} with two moments, {} with four, {} of percentage-closer soft shadows; error {}, {} and {}",
        percent(two.signed_mean, 2),
        percent(four.signed_mean, 2),
        percent(first.signed_mean, 2),
        error(two),
        error(four),
        error(first)
    ))
}

fn fusion(tables: &SoftTables<'_>) -> Measured<String> {
    let of = |role, class| tables.playing(role, Population::Fragments, ("layers", class));
    let classes = |role| -> Measured<String> {
        let rows = ["1", "2", "3+"].map(|class| of(role, class));
        let [one, two, more] = rows;
        let with_sign = |row: &SoftRecord| format!("{} ({:+.2})", error(row), 100.0 * row.signed_mean);
        Ok(format!("{}, {}, {}", with_sign(one?), with_sign(two?), with_sign(more?)))
    };
    Ok(format!(
        "Error (signed) with 1, 2 and 3 or more layers: percentage-closer {}; four moments {}; two moments {}",
        classes("PCSS")?,
        classes("four moments")?,
        classes("two moments")?
    ))
}

fn limited(tables: &SoftTables<'_>) -> Measured<String> {
    let of = |role| tables.playing(role, Population::Fragments, ("width", "16+"));
    let sizes = ["PCSS, 9x9", "PCSS, 15x15", "PCSS, 27x27", "PCSS"];
    let errors = sizes.map(|role| of(role).map(error));
    let [nine, fifteen, many, full] = errors;
    Ok(format!(
        "In penumbrae of over 16 texels {} with 9x9, {} with 15x15, {} with 27x27, {} with the whole region",
        nine?, fifteen?, many?, full?
    ))
}

fn interpolation(tables: &SoftTables<'_>) -> Measured<String> {
    let time = |role| {
        let name = &player(&tables.experiment.technique, role)?.name;
        recorded(least_time(&tables.samples, name, "shade"))
    };
    let roles = ["four moments", "four moments, not interpolated"];
    let (with, without) = (time(roles[0])?, time(roles[1])?);
    let core = format!("On one core {with:.0} and {without:.0} ns a fragment, {:.2} times", with / without);
    let passes = roles.map(|role| tables.gpu_time(&player(&tables.experiment.technique, role).ok()?.name));
    let [Some(with), Some(without)] = passes else {
        return Ok(format!("{core} (published {PUBLISHED_RATIO:.2} for whole frames)"));
    };
    Ok(format!(
        "All passes on {} take {with:.3} and {without:.3} ms, {:.2} times (published {PUBLISHED_RATIO:.2} for whole frames). {core}",
        tables.adapter(),
        with / without
    ))
}
