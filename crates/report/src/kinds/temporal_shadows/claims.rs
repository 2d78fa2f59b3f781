//! What TC09 says about soft shadows over time.

use super::summary::TemporalTables;
use crate::kinds::rows::least_time;
use crate::page::{Claim, Measured, percent, player, recorded};
use evaluation::TemporalRecord;

pub(super) fn claims(tables: &TemporalTables<'_>) -> Vec<Claim> {
    [
        Claim::new(
            "TC09 1",
            "Dense sampling of the light gives correct soft shadows; high quality needs 256 samples or more",
            sampling(tables),
        ),
        Claim::new(
            "TC09 3.1",
            "The standard error judges the quality of n samples",
            standard_error(tables),
        ),
        Claim::new(
            "TC09 3.2, Figure 2",
            "For small n sampling alone has large errors; the new algorithm converges from the first frames on",
            first_frames(tables),
        ),
        Claim::new(
            "TC09 3.3, Figure 3",
            "Percentage-closer soft shadows as the first sample greatly increase convergence, with n = 4 faster than with 1",
            start(tables),
        ),
        Claim::new(
            "TC09 3.3",
            "Smoothing over the penumbra's width avoids flickering in the frames after a disocclusion",
            flicker(tables),
        ),
        Claim::new(
            "TC09 3.4",
            "Restarts where a texel's sign says that it moves, and the neighbourhood filter, handle moving objects",
            moving(tables),
        ),
        Claim::new(
            "TC09 4",
            "A shadow buffer of four 16-bit floats holds rho, n, depth and average blocker depth",
            half_floats(tables),
        ),
        Claim::new(
            "TC09 4",
            "Better quality than percentage-closer soft shadows with 16 and 16 lookups",
            quality(tables),
        ),
        Claim::new(
            "TC09 4, Figure 4",
            "Faster than percentage-closer soft shadows with 16 and 16 lookups, considerably faster than with 32 and 32",
            cost(tables),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn error(row: &TemporalRecord) -> String {
    percent(row.l1_error, 2)
}

fn sampling(tables: &TemporalTables<'_>) -> Measured<String> {
    let still = recorded(tables.still())?;
    let errors = |role| -> Measured<String> {
        let of = |&frame: &usize| tables.playing(role, Some(still), Some(frame), "penumbra").map(error);
        Ok(still.judged.iter().map(of).collect::<Measured<Vec<String>>>()?.join(", "))
    };
    let frames: Vec<String> = still.judged.iter().map(ToString::to_string).collect();
    Ok(format!(
        "In penumbrae after {} frames {} with maps, {} by shadow rays: what is left with maps are their texels and biases",
        frames.join(", "),
        errors("sampling")?,
        errors("sampling by rays")?
    ))
}

fn standard_error(tables: &TemporalTables<'_>) -> Measured<String> {
    let still = recorded(tables.still())?;
    let mut parts = Vec::new();
    for &frame in &still.judged {
        let row = tables.playing("sampling", Some(still), Some(frame), "penumbra")?;
        parts.push(format!(
            "{frame}: {} of {}, {} falsely certain",
            percent(recorded(row.believed_rms)?, 1),
            percent(recorded(row.estimate_rms)?, 1),
            percent(recorded(row.falsely_certain)?, 0)
        ));
    }
    let cautious = tables.playing("sampling by rays", Some(still), None, "penumbra")?;
    Ok(format!(
        "Believed of true error in penumbrae by frames: {}. With one more test to either side and exact tests {} of pixels lie \
         within it after {} frames (68 % would be right)",
        parts.join("; "),
        percent(recorded(cautious.within)?, 0),
        cautious.frame
    ))
}

fn first_frames(tables: &TemporalTables<'_>) -> Measured<String> {
    let still = recorded(tables.still())?;
    let mut parts = Vec::new();
    for &frame in &still.judged {
        let of = |role| tables.playing(role, Some(still), Some(frame), "all").map(error);
        parts.push(format!("{frame}: {}, {}, {}", of("sampling")?, of("published")?, of("mended")?));
    }
    Ok(format!("Error of sampling alone, as published and with all mends, by frames: {}", parts.join("; ")))
}

fn start(tables: &TemporalTables<'_>) -> Measured<String> {
    let still = recorded(tables.still())?;
    let mut parts = Vec::new();
    for &frame in still.judged.iter().take(4) {
        let of = |role| -> Measured<String> {
            let row = tables.playing(role, Some(still), Some(frame), "penumbra")?;
            Ok(percent(recorded(row.estimate_error)?, 1))
        };
        parts.push(format!(
            "{frame}: {}, {}, {}",
            of("sampling")?,
            of("start of weight 1")?,
            of("published")?
        ));
    }
    Ok(format!(
        "Error in penumbrae before any filter, without a start, with one of weight 1 and of weight 4, by frames: {}",
        parts.join("; ")
    ))
}

fn flicker(tables: &TemporalTables<'_>) -> Measured<String> {
    let mut parts = Vec::new();
    for path in tables.steady() {
        let of = |role| -> Measured<String> {
            let row = tables.playing(role, Some(path), None, "all")?;
            Ok(percent(recorded(row.flicker)?, 2))
        };
        let (alone, published, mended) = (of("sampling")?, of("published")?, of("mended")?);
        parts.push(format!("{}: {alone}, {published}, {mended}", path.name));
    }
    recorded((!parts.is_empty()).then_some(()))?;
    Ok(format!(
        "Change from frame to frame where the truth stays, of sampling alone, as published, with all mends: {}",
        parts.join("; ")
    ))
}

fn moving(tables: &TemporalTables<'_>) -> Measured<String> {
    let path = recorded(tables.moving())?;
    let of = |role| tables.playing(role, Some(path), None, "changed").map(error);
    Ok(format!(
        "Error where moving shadows are and were: {} sampling alone, {} as published, {} with casters searched, {} with all mends, \
         {} percentage-closer soft shadows of each frame",
        of("sampling")?,
        of("published")?,
        of("casters searched")?,
        of("mended")?,
        of("PCSS 16/16")?
    ))
}

fn half_floats(tables: &TemporalTables<'_>) -> Measured<String> {
    let counted = |role| -> Measured<String> {
        let name = &player(&tables.experiment.technique, role)?.name;
        let rows = tables.counts.iter().filter(|r| r.technique == *name);
        let all: Vec<String> =
            rows.map(|r| format!("{} ({:.0}, {})", r.frames, r.tests, percent(r.mean_error, 2))).collect();
        recorded((!all.is_empty()).then(|| all.join(", ")))
    };
    Ok(format!(
        "Frames (n, mean error of a pixel): {} in 16 bits; {} in 32 bits; {} in 16 bits with n capped at 512",
        counted("published")?,
        counted("published in f32")?,
        counted("capped")?
    ))
}

fn quality(tables: &TemporalTables<'_>) -> Measured<String> {
    let mut parts = Vec::new();
    for path in &tables.experiment.path {
        let of = |role| tables.playing(role, Some(path), None, "all").map(error);
        let (published, mended, few, more) =
            (of("published")?, of("mended")?, of("PCSS 16/16")?, of("PCSS 32/32")?);
        parts.push(format!("{}: {published}, {mended}; {few}, {more}", path.name));
    }
    Ok(format!(
        "Error as published and with all mends; of percentage-closer soft shadows with 16/16 and 32/32: {}",
        parts.join(". ")
    ))
}

fn cost(tables: &TemporalTables<'_>) -> Measured<String> {
    let mut parts = Vec::new();
    for path in &tables.experiment.path {
        let row = tables.playing("published", Some(path), None, "all")?;
        let restarted = percent(recorded(row.restarted)?, 0);
        parts.push(format!("{} {:.1} ({restarted} restarted)", path.name, row.lookups));
    }
    let time = |role| -> Measured<f64> {
        let name = &player(&tables.experiment.technique, role)?.name;
        recorded(least_time(&tables.samples, name, "frame"))
    };
    let (own, few, more) = (time("published")?, time("PCSS 16/16")?, time("PCSS 32/32")?);
    Ok(format!(
        "Lookups of a pixel: {}; percentage-closer 32 and 64. On one core {own:.0} ns a pixel with a history, {few:.0} and {more:.0} \
         of percentage-closer",
        parts.join(", ")
    ))
}
