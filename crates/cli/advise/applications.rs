//! Applications beside hard shadows, and what all of them share, for people.

use super::text::{blend, depth_bias, fraction, heading, notes, nothing, raced, rows, tolerance};
use evaluation::{
    MediumSetting, ScatteringAdvice, ScatteringChoice, SoftChoice, SoftShadowAdvice, Together,
    TranslucentCasterAdvice, TranslucentChoice,
};
use std::io::{self, Write};

pub(super) fn soft_name(choice: &SoftChoice) -> String {
    let storage = if choice.storage.is_empty() { String::new() } else { format!(" ({})", choice.storage) };
    let alpha = choice.alpha.map(|alpha| format!(", alpha {alpha:e}")).unwrap_or_default();
    format!(
        "{}, {}{storage}{alpha}, {size}x{size}, bias {} texels + {} slopes, {:.0} texels read, region {:.1}",
        choice.technique,
        choice.format,
        choice.bias_texels,
        choice.bias_slopes,
        choice.samples,
        choice.region,
        size = choice.size,
    )
}

pub(super) fn scattering_name(choice: &ScatteringChoice) -> String {
    let alpha = choice.alpha.map(|alpha| format!(", alpha {alpha:e}")).unwrap_or_default();
    let [columns, rows] = choice.map;
    format!(
        "{}, {}{alpha}{}, {columns}x{rows} from a shadow map of {size}x{size}",
        choice.technique,
        choice.format,
        blend(choice.beta, 0.0),
        size = choice.size,
    )
}

pub(super) fn translucent_name(choice: &TranslucentChoice) -> String {
    let alpha = choice.alpha.map(|alpha| format!(", alpha {alpha:e}")).unwrap_or_default();
    let order = if choice.ordered { ", drawn in order" } else { ", in any order" };
    format!(
        "{}, {}{alpha}{}, {size}x{size}, bias {} texels + {} slopes{order}",
        choice.technique,
        choice.format,
        blend(choice.beta, 0.0),
        choice.bias_texels,
        choice.bias_slopes,
        size = choice.size,
    )
}

pub(super) fn soft_shadows(out: &mut dyn Write, soft: &SoftShadowAdvice) -> io::Result<()> {
    writeln!(
        out,
        "\nsoft shadows: {}; {} receivers, {}; the truth by shadow rays, standard error {}",
        soft.views.join("; "),
        soft.fragments,
        tolerance(&soft.answer),
        fraction(soft.truth_standard_error)
    )?;
    writeln!(out)?;
    heading(out)?;
    nothing(out, soft.nothing.l1_error)?;
    let row = |choice: &SoftChoice| {
        (choice.error, choice.cost, choice.cost_ms, choice.map_bytes, soft_name(choice))
    };
    rows(out, &soft.answer, row)?;
    writeln!(out)?;
    notes(out, &soft.answer, |choice| choice.error)?;
    raced(out, &soft.answer, "all receivers")?;
    if let Some(choice) = &soft.answer.recommendation {
        depth_bias(out, (choice.bias_texels, choice.bias_slopes), &choice.depth_bias)?;
    }
    Ok(())
}

pub(super) fn scattering(out: &mut dyn Write, scattering: &ScatteringAdvice) -> io::Result<()> {
    let MediumSetting { extinction, albedo, anisotropy } = scattering.medium;
    writeln!(
        out,
        "\nsingle scattering: extinction {extinction} over half the diagonal, albedo {albedo}, g {anisotropy}; {} view rays of {} \
         cameras, {}; the truth from the whole shadow map",
        scattering.rays,
        scattering.views.len(),
        tolerance(&scattering.answer)
    )?;
    writeln!(out)?;
    heading(out)?;
    nothing(out, scattering.nothing)?;
    let row = |choice: &ScatteringChoice| {
        (choice.error, choice.cost, choice.cost_ms, choice.map_bytes, scattering_name(choice))
    };
    rows(out, &scattering.answer, row)?;
    writeln!(out)?;
    notes(out, &scattering.answer, |choice| choice.error)?;
    raced(out, &scattering.answer, "all view rays")
}

pub(super) fn translucent_casters(out: &mut dyn Write, casters: &TranslucentCasterAdvice) -> io::Result<()> {
    writeln!(
        out,
        "\ntranslucent casters: {}; {} opaque receivers and {} surfaces inside, {} of them drawn, {}; the truth from all surfaces, \
         tap by tap",
        casters.views.join(", "),
        casters.surfaces,
        casters.inside,
        casters.drawn,
        tolerance(&casters.answer)
    )?;
    writeln!(out)?;
    heading(out)?;
    nothing(out, casters.nothing)?;
    let row = |choice: &TranslucentChoice| {
        (choice.error, choice.cost, choice.cost_ms, choice.map_bytes, translucent_name(choice))
    };
    rows(out, &casters.answer, row)?;
    writeln!(out)?;
    notes(out, &casters.answer, |choice| choice.error)?;
    raced(out, &casters.answer, "all receivers drawn")?;
    if let Some(choice) = &casters.answer.recommendation {
        depth_bias(out, (choice.bias_texels, choice.bias_slopes), &choice.depth_bias)?;
    }
    Ok(())
}

pub(super) fn together(out: &mut dyn Write, together: &Together) -> io::Result<()> {
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    writeln!(
        out,
        "\ntogether: cost {:.3} ({:.3} ms) and {:.2} MiB, with what is shared counted once; {:.3} and {:.2} MiB apart",
        together.cost,
        together.cost_ms,
        mebibytes(together.bytes),
        together.cost_apart,
        mebibytes(together.bytes_apart)
    )?;
    together.members.iter().try_for_each(|member| writeln!(out, "  {member}"))?;
    together
        .shared
        .iter()
        .try_for_each(|shared| writeln!(out, "  shared: {}, {:.2} MiB", shared.name, mebibytes(shared.bytes)))
}
