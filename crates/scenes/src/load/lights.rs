//! Lights of a file as views.

use super::FileLight;
use super::warnings::{WarningKind, Warnings};
use crate::fit::Bounds;
use crate::vector::{cross, norm, normalize};
use crate::{AreaLight, LightView, Outline};

/// Radius of the disc that stands for a spot light, which has none, as a share of the scene's radius.
const SPOT_RADIUS: f64 = 1e-3;

/// Names that scenes have anyhow.
const TAKEN: [&str; 2] = ["wide", "lamp"];

/// Adds the directional lights, and the spot lights as small discs; what is left out is told.
pub(super) fn add_views(
    views: &mut Vec<LightView>,
    lights: &[FileLight],
    origin: [f64; 3],
    bounds: &Bounds,
    warnings: &mut Warnings,
) {
    for light in lights {
        let direction = light.direction;
        let usable = norm(direction).is_normal();
        let name = unused_name(views, &light.name);
        let unused = |why: &str| format!("light {:?} is not used: {why}", light.name);
        match light.kind.as_str() {
            "directional" if usable => {
                let direction = normalize(direction).map(|c| c as f32);
                views.push(LightView::directional(name, direction));
            }
            "spot" if usable => {
                let centre = [0, 1, 2].map(|k| light.position[k] - origin[k]);
                let forward = normalize(direction);
                let least = (0..3).min_by(|&a, &b| f64::total_cmp(&forward[a].abs(), &forward[b].abs()));
                let mut across = [0.0; 3];
                across[least.unwrap_or(0)] = 1.0;
                let u = normalize(cross(forward, across));
                let v = cross(forward, u);
                let radius = SPOT_RADIUS * bounds.radius();
                let half_axes = [u, v].map(|axis| axis.map(|c| radius * c));
                match AreaLight::local(Outline::Disc, centre, half_axes) {
                    Ok(area) => views.push(LightView::new(name, area, [0.0; 3])),
                    Err(error) => {
                        warnings.add(WarningKind::Light, &light.name, || unused(&error.to_string()));
                    }
                }
            }
            "point" => warnings.add(WarningKind::Light, &light.name, || {
                unused("a point light shines to all sides, and a view has but one")
            }),
            "directional" | "spot" => {
                warnings.add(WarningKind::Light, &light.name, || unused("its node has no direction"));
            }
            other => warnings
                .add(WarningKind::Light, &light.name, || unused(&format!("its type {other:?} is not known"))),
        }
    }
}

fn unused_name(views: &[LightView], wanted: &str) -> String {
    let wanted = if wanted.trim().is_empty() { "light" } else { wanted };
    let taken = |name: &str| TAKEN.contains(&name) || views.iter().any(|view| view.name == name);
    if !taken(wanted) {
        return wanted.to_owned();
    }
    // As many numbers as names: one is free.
    let numbered = (2..views.len() + 4).map(|number| format!("{wanted} {number}"));
    numbered.into_iter().find(|name| !taken(name)).unwrap_or_else(|| format!("{wanted} of the file"))
}
