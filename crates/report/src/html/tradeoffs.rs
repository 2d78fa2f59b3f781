//! Error against cost in every application, side by side: panels drawn here, which the script replaces by charts with filters.

use super::compact::compact;
use crate::drawing::{Family, Mark, Scatter, css, dark, escaped};
use crate::error::ReportError;
use crate::page::{Breaks, Page, Tradeoff, Tradeoffs, UNSTABLE, json, percent};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Size of a panel in pixels: three stand beside each other, and one on a phone without its words getting too small.
const PANEL: (u32, u32) = (330, 290);

/// What the script knows of an application.
#[derive(Serialize)]
struct Application<'a> {
    application: &'a str,
    cost: &'a str,
    error: &'a str,
    techniques: &'a [Tradeoff],
}

/// The applications of the pages, with what the stability experiment found of their techniques; the first run of each.
pub(super) fn applications(pages: &[Page]) -> Vec<Tradeoffs> {
    let breaks: Vec<&Breaks> = pages.iter().flat_map(|page| &page.content.breaks).collect();
    let mut all: Vec<Tradeoffs> = Vec::new();
    for of in pages.iter().filter_map(|page| page.content.tradeoffs.as_ref()) {
        let is_new = !all.iter().any(|known| known.application == of.application);
        let mut of = of.clone();
        of.techniques.retain(|p| p.cost > 0.0 && p.error.is_finite());
        for technique in &mut of.techniques {
            technique.breaks = technique.stored.as_ref().and_then(|(method, alpha)| {
                let known = breaks.iter().find(|of| of.method.eq_ignore_ascii_case(method))?;
                known.share(*alpha)
            });
        }
        if is_new && !of.techniques.is_empty() {
            all.push(of);
        }
    }
    all.sort_by_key(|of| ORDER.iter().position(|name| *name == of.application).unwrap_or(ORDER.len()));
    all
}

/// From what every scene has to what few have.
const ORDER: [&str; 6] = [
    "hard shadows",
    "soft shadows",
    "light over time",
    "light through a lens",
    "single scattering",
    "smoke and glass",
];

/// The figure; nothing without applications.
pub(super) fn figure(applications: &[Tradeoffs]) -> Result<String, ReportError> {
    if applications.is_empty() {
        return Ok(String::new());
    }
    let mut panels = String::new();
    for of in applications {
        let title = format!("{}: {}", of.application, of.error);
        let svg = compact(&panel(of)?);
        let svg = &svg[svg.find("<svg").unwrap_or_default()..];
        let label = escaped(&format!("error against {}, {}", of.cost, of.application));
        // Writing to a string cannot fail.
        let _ = writeln!(
            panels,
            "<figure class=\"figure\"><figcaption>{}</figcaption>{}</figure>",
            escaped(&title),
            svg.replacen("<svg", &format!("<svg role=\"img\" aria-label=\"{label}\""), 1)
        );
    }
    let known: Vec<Application<'_>> = applications
        .iter()
        .map(|of| Application {
            application: of.application,
            cost: of.cost,
            error: &of.error,
            techniques: &of.techniques,
        })
        .collect();
    let shown = |family: &&Family| {
        applications.iter().flat_map(|of| &of.techniques).any(|technique| technique.family == family.name)
    };
    let legend: Vec<String> = families()
        .filter(|(family, _)| shown(family))
        .map(|(family, variable)| {
            format!(
                "<span class=\"swatch\" style=\"background: var({variable})\"></span>{}",
                escaped(family.name)
            )
        })
        .collect();
    Ok(format!(
        "<div class=\"tradeoffs\" data-tradeoffs=\"{}\">\n{panels}</div>\n<p class=\"key\">{} The line joins what nothing cheaper \
         beats; pale: something is better in both; hatched: the bound, in its format with its moment bias, breaks on more than \
         {UNSTABLE:e} of a scene's fragments; disc, square, triangle: maps of full, half and a quarter of the side. PCF, \
         percentage-closer filtering, compares the depths of all texels of a kernel one by one and filters nothing in advance: \
         the truth of hard shadows.</p>\n",
        escaped(&json(&known)),
        legend.join(" ")
    ))
}

fn panel(of: &Tradeoffs) -> Result<String, ReportError> {
    let mut sizes: Vec<u32> = of.techniques.iter().filter_map(|technique| technique.size).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes.dedup();
    let mark = |p: &Tradeoff| Mark {
        name: p.name.clone(),
        colour: families()
            .find(|(family, _)| family.name == p.family)
            .map_or(Family::of("").colour, |(f, _)| f.colour),
        x: p.cost,
        x_range: None,
        y: p.error,
        y_margin: 0.0,
        shape: p.size.and_then(|size| sizes.iter().position(|known| *known == size)).unwrap_or_default()
            as u32,
        competes: p.competes,
        fails: p.is_unstable(),
        label: format!(
            "{}: error {}, {} {:.3}, {} bits a texel",
            p.name,
            percent(p.error, 2),
            of.cost,
            p.cost,
            p.bits
        ),
    };
    let scatter = Scatter {
        size: PANEL,
        title: "",
        x_label: of.cost.split(';').next().unwrap_or(of.cost),
        y_label: "error",
        unit: None,
        names: false,
        shapes: Vec::new(),
        legend: false,
    };
    let marks: Vec<Mark> = of.techniques.iter().map(mark).collect();
    scatter.svg(of.application, &marks)
}

/// Families with the names of their colours in the page's style.
fn families() -> impl Iterator<Item = (&'static Family, String)> {
    Family::all().enumerate().map(|(i, family)| (family, format!("--family-{i}")))
}

/// Colours of families on a white and on a dark page.
pub(super) fn style() -> String {
    let of = |page: fn(plotters::style::RGBColor) -> plotters::style::RGBColor| -> String {
        families().map(|(family, variable)| format!(" {variable}: {};", css(page(family.colour)))).collect()
    };
    format!(
        ":root {{{} }}\n@media (prefers-color-scheme: dark) {{\n:root {{{} }}\n{}}}\n",
        of(|colour| colour),
        of(dark),
        crate::drawing::dark_rules()
    )
}

/// The same for the script.
pub(super) fn script() -> String {
    let names: BTreeMap<&str, String> =
        families().map(|(family, variable)| (family.name, variable)).collect();
    format!("const UNSTABLE = {UNSTABLE:e};\nconst FAMILIES = {};\n", json(&names))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn technique(name: &str, error: f64, breaks: Option<f64>) -> Tradeoff {
        Tradeoff {
            name: name.to_owned(),
            family: Family::of(name).name,
            size: None,
            bits: 64,
            cost: 2.0,
            error,
            margin: 0.0,
            competes: true,
            stored: None,
            breaks,
        }
    }

    #[test]
    fn unstable_techniques_are_hatched_and_the_data_says_why() {
        let of = |breaks| {
            let techniques = vec![technique("VSM", 0.1, None), technique("Hamburger 4", 0.05, breaks)];
            figure(&[Tradeoffs {
                application: "hard shadows",
                cost: "cost",
                error: "error".to_owned(),
                techniques,
            }])
            .unwrap()
        };
        let strokes =
            |text: &str| text.matches("<path fill=\"none\" stroke=\"#000000\" stroke-width=\"4\"").count();
        let (stable, unstable) = (of(Some(0.0)), of(Some(2e-4)));
        assert!(strokes(&unstable) > strokes(&stable), "{unstable}");
        assert!(
            unstable.contains("&quot;breaks&quot;:0.0002") && stable.contains("PCF, percentage-closer"),
            "{stable}"
        );
        assert!(style().contains("--family-0: #") && script().contains("--family-0"));
    }
}
