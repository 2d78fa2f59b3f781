//! Opacities of translucent surfaces, by texel.
//!
//! Both backends find the same fragments, and their opacities are evaluated here, once, where fragments become a stack; so
//! stacks with opacities agree bit for bit as others do.

use rayon::prelude::*;
use scenes::{AlphaTexture, InvalidScene, Opacity, Scene};

use crate::RenderError;
use crate::stack::assemble::Band;
use crate::stack::fixed_point::Plane;
use crate::stack::prepare::{
    PreparedTriangle, PreparedTriangles, Projected, mask_coordinates, plane_corners, plane_through,
};

/// Which light is asked about: glass of a colour takes some of it and lets the rest through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spectrum {
    /// What the eye makes of red, green and blue.
    #[default]
    Luminance,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
}

/// Luminance of linear red, green and blue (ITU-R BT.709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

impl Spectrum {
    /// Share of a colour.
    fn of(self, colour: [f32; 3]) -> f64 {
        let [r, g, b] = colour.map(f64::from);
        match self {
            // Grey stays what it is, whatever the weights round to.
            Self::Luminance if r == g && g == b => r,
            Self::Luminance => LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b,
            Self::Red => r,
            Self::Green => g,
            Self::Blue => b,
        }
    }
}

/// How surfaces that let light through are rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Casters {
    /// Where their alpha is at least one half, as opaque ones.
    Opaque,
    /// All that are not clear, with their opacity.
    Translucent(Spectrum),
}

/// What a translucent triangle's opacity is read from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Veil {
    /// Texture coordinates.
    pub u: Plane,
    pub v: Plane,
    /// Alpha of the vertices.
    pub alpha: Plane,
    pub material: u32,
}

/// Opacity of a material in one kind of light.
#[derive(Clone, Debug)]
struct Coat {
    opacity: Opacity,
    transmission: f64,
}

impl Coat {
    /// At the texel of each texture that `wrapped` tells by its size, under the vertices' alpha.
    fn opacity(&self, alpha: f64, wrapped: impl Fn([u32; 2]) -> [u32; 2]) -> f32 {
        let value = |texture: &AlphaTexture| {
            let [column, row] = wrapped([texture.width, texture.height]);
            texture.value(column, row)
        };
        let of = |texture: &Option<std::sync::Arc<AlphaTexture>>| texture.as_deref().map_or(1.0, value);
        let Opacity { factor, texture, transmission_texture, tested, .. } = &self.opacity;
        // Alpha of vertices takes part in the test of a mask, and is nothing besides.
        let covered = if *tested { 1.0 } else { f64::from(*factor) * of(texture) * alpha.clamp(0.0, 1.0) };
        let through =
            if self.transmission == 0.0 { 0.0 } else { self.transmission * of(transmission_texture) };
        (covered * (1.0 - through)) as f32
    }
}

/// Marks triangles that are opaque.
const NO_VEIL: u32 = u32::MAX;

/// The translucent surfaces of a scene on a map; empty where there are none, or where they are not wanted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Veils {
    /// By material.
    coats: Vec<Option<Coat>>,
    veils: Vec<Veil>,
    /// By prepared triangle.
    of_triangle: Vec<u32>,
    /// In perspective, by prepared triangle: that of the scene.
    sources: Vec<u32>,
}

impl Veils {
    pub(crate) fn new(scene: &Scene, casters: Casters) -> Result<Self, InvalidScene> {
        let spectrum = match casters {
            Casters::Opaque => return Ok(Self::default()),
            Casters::Translucent(spectrum) => spectrum,
        };
        let mut coats = Vec::new();
        for material in &scene.materials {
            let Some(opacity) = &material.opacity else {
                coats.push(None);
                continue;
            };
            if let Some(fault) = opacity.fault() {
                return Err(scene.inconsistent(format!("opacity of material '{}' {fault}", material.name)));
            }
            let transmission = spectrum.of(opacity.transmission);
            coats.push(Some(Coat { opacity: opacity.clone(), transmission }));
        }
        let any = coats.iter().any(Option::is_some);
        Ok(if any { Self { coats, ..Self::default() } } else { Self::default() })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.coats.is_empty()
    }

    /// The material, if it is translucent.
    pub(super) fn of_material(&self, material: u32) -> Option<u32> {
        self.coats.get(material as usize).and_then(Option::as_ref).map(|_| material)
    }

    /// Alpha of a triangle's corners.
    pub(super) fn alphas(&self, scene: &Scene, triangle: usize) -> [f64; 3] {
        let alpha = |i: u32| scene.colors.get(i as usize).map_or(1.0, |color| f64::from(color[3]));
        scene.triangles[triangle].map(alpha)
    }

    /// Planes of all translucent triangles of a scene under a directional light.
    pub(super) fn set_up(
        &mut self,
        scene: &Scene,
        projected: &[Projected],
        triangles: &[PreparedTriangle],
    ) -> Result<(), RenderError> {
        if self.is_empty() {
            return Ok(());
        }
        self.of_triangle = vec![NO_VEIL; triangles.len()];
        for (source, triangle) in triangles.iter().enumerate() {
            let Some(material) = self.of_material(scene.triangle_material[source]) else { continue };
            let [x0, y0, x1, y1] = triangle.bounds;
            if x0 >= x1 || y0 >= y1 {
                continue;
            }
            let corners = plane_corners(&scene.triangles[source].map(|i| projected[i as usize]));
            let reference = [f64::from(x0) + 0.5, f64::from(y0) + 0.5];
            let plane = |values: [f64; 3]| {
                let (value, step) = plane_through(corners, values, reference);
                Plane::new(value, step)
            };
            let uv = mask_coordinates(scene, source)?;
            let [u, v] = [0, 1].map(|k| plane(uv.map(|c| c[k])));
            let alpha = plane(self.alphas(scene, source));
            self.of_triangle[source] = self.veils.len() as u32;
            self.veils.push(Veil { u, v, alpha, material });
        }
        Ok(())
    }

    /// Takes the pieces of triangles in perspective: how many there are, the translucent ones by their number, and the
    /// scene's triangle of each.
    pub(super) fn take_pieces(&mut self, pieces: usize, veils: Vec<(u32, Veil)>, sources: Vec<u32>) {
        if self.is_empty() {
            return;
        }
        self.of_triangle = vec![NO_VEIL; pieces];
        for (place, (piece, veil)) in veils.into_iter().enumerate() {
            self.of_triangle[piece as usize] = place as u32;
            self.veils.push(veil);
        }
        self.sources = sources;
    }

    fn opacity(&self, prepared: &PreparedTriangles, index: u32, [x, y]: [u32; 2]) -> f32 {
        let place = self.of_triangle[index as usize];
        if place == NO_VEIL {
            return 1.0;
        }
        let veil = &self.veils[place as usize];
        let Some(coat) = &self.coats[veil.material as usize] else { return 1.0 };
        let weight = prepared.weights.get(index as usize);
        let [x0, y0, ..] = prepared.triangles[index as usize].bounds.map(u32::from);
        let (x, y) = (x - x0, y - y0);
        coat.opacity(veil.alpha.number_at(weight, x, y), |[width, height]| {
            [veil.u.wrapped_texel_at(weight, x, y, width), veil.v.wrapped_texel_at(weight, x, y, height)]
        })
    }

    /// The fragments that are not clear, with their opacities and the scene's triangles that they are of; both lists are empty
    /// where every fragment is opaque.
    pub(super) fn covered(prepared: &PreparedTriangles, bands: Vec<Band>) -> (Vec<Band>, Vec<f32>, Vec<u32>) {
        let veils = &prepared.veils;
        if veils.is_empty() {
            return (bands, Vec::new(), Vec::new());
        }
        let mut first_texel = 0;
        let firsts: Vec<usize> = bands
            .iter()
            .map(|band| {
                let next = first_texel + band.starts.len();
                std::mem::replace(&mut first_texel, next)
            })
            .collect();
        let filtered: Vec<(Band, Vec<f32>)> = bands
            .into_par_iter()
            .zip(firsts)
            .map(|(band, first)| veils.covered_of(prepared, &band, first))
            .collect();
        let opacities: Vec<f32> = filtered.iter().flat_map(|(_, opacities)| opacities).copied().collect();
        let bands: Vec<Band> = filtered.into_iter().map(|(band, _)| band).collect();
        if opacities.iter().all(|&opacity| opacity == 1.0) {
            return (bands, Vec::new(), Vec::new());
        }
        let source = |key: &u64| veils.sources.get(*key as u32 as usize).copied().unwrap_or(*key as u32);
        let sources = bands.iter().flat_map(|band| band.keys.iter().map(source)).collect();
        (bands, opacities, sources)
    }

    fn covered_of(&self, prepared: &PreparedTriangles, band: &Band, first: usize) -> (Band, Vec<f32>) {
        let mut kept = Band { starts: Vec::with_capacity(band.starts.len()), keys: Vec::new() };
        let mut opacities = Vec::with_capacity(band.keys.len());
        for (texel, &start) in band.starts.iter().enumerate() {
            let end = band.starts.get(texel + 1).map_or(band.keys.len(), |&next| next as usize);
            let place = (first + texel) as u32;
            let at = [place % prepared.width, place / prepared.width];
            kept.starts.push(kept.keys.len() as u32);
            for &key in &band.keys[start as usize..end] {
                let opacity = self.opacity(prepared, key as u32, at);
                if opacity > 0.0 {
                    kept.keys.push(key);
                    opacities.push(opacity);
                }
            }
        }
        (kept, opacities)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn coat(opacity: Opacity, spectrum: Spectrum) -> Coat {
        Coat { transmission: spectrum.of(opacity.transmission), opacity }
    }

    #[test]
    fn opacity_is_alpha_less_what_passes() {
        let texture = Arc::new(AlphaTexture { width: 2, height: 1, alpha: vec![51, 255] });
        let blended = Opacity::blended(0.5, Some(texture.clone()));
        let of = |opacity: &Opacity, spectrum, alpha, column| {
            coat(opacity.clone(), spectrum).opacity(alpha, |size| {
                assert_eq!(size, [2, 1]);
                [column, 0]
            })
        };
        assert_eq!(of(&blended, Spectrum::Luminance, 1.0, 0), 0.1);
        assert_eq!(of(&blended, Spectrum::Red, 0.5, 1), 0.25);
        // Extrapolation at a sliver's edge.
        assert_eq!(of(&blended, Spectrum::Red, -0.1, 1), 0.0);
        let glass = Opacity {
            transmission: [1.0, 0.5, 0.0],
            transmission_texture: Some(texture),
            tested: true,
            ..Opacity::blended(1.0, None)
        };
        let channels = [Spectrum::Red, Spectrum::Green, Spectrum::Blue].map(|s| of(&glass, s, 0.3, 0));
        assert_eq!(channels, [0.8, 0.9, 1.0]);
        let grey = of(&glass, Spectrum::Luminance, 1.0, 1);
        assert!((f64::from(grey) - (1.0 - 0.2126 - 0.5 * 0.7152)).abs() < 1e-7);
        assert!(Opacity::blended(f32::NAN, None).fault().unwrap().contains("NaN"));
        assert!(Opacity::blended(1.5, None).fault().unwrap().contains("1.5"));
    }
}
