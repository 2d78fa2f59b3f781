//! Scenes from their cameras, with smoke and glass: the truth, then each technique, with magnified parts below, and grey maps of
//! G - F on opaque surfaces.

use super::records::TranslucentPictureRecord;
use super::run::Plan;
use super::settings::{TranslucentPicture, TranslucentShadowsExperiment};
use super::view::View;
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Seen, Source};
use crate::kinds::filterable::map_name;
use crate::pictures::{png, side_by_side, signed_grey};
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;
use applications::Application;
use image::{DynamicImage, GrayImage, RgbaImage};
use rayon::prelude::*;
use scenes::vector::{cross, dot, minus, normalize};
use scenes::{AlphaMask, Camera, LightView, Scene};
use shadow_filtering::Receiver;
use shadow_renderer::{Frame, LightFrame, ViewRays};
use std::sync::Arc;

/// Most translucent triangles that pictures show; each is tried for each pixel.
const MOST_TRIANGLES: usize = 4096;

/// Light that reaches smoke and glass in shadow, as a share; the same from all sides, as they scatter it.
const AMBIENT: f32 = 0.4;

/// Rejects pictures of scenes or views that are not evaluated.
pub(super) fn check(
    experiment: &TranslucentShadowsExperiment,
    scenes: &[LoadedScene<'_>],
) -> Result<(), EvaluationError> {
    for (i, picture) in experiment.picture.iter().enumerate() {
        if found(picture, scenes).is_none() {
            let reason = format!(
                "picture `{}`: view `{}` of scene `{}` is not evaluated, or is a stack, which has no camera",
                picture.id, picture.view, picture.scene
            );
            return Err(EvaluationError::key(format!("picture[{i}].scene"), reason));
        }
    }
    Ok(())
}

fn found<'a>(
    picture: &TranslucentPicture,
    scenes: &'a [LoadedScene<'a>],
) -> Option<(&'a LoadedScene<'a>, &'a Scene, &'a LightView)> {
    let loaded = scenes.iter().find(|loaded| loaded.label == picture.scene)?;
    let light = loaded.lights.iter().find(|light| picture.view.is_empty() || light.name == picture.view)?;
    match &loaded.source {
        Source::Scene(scene) => Some((loaded, scene.as_ref(), light)),
        Source::Stack(_) => None,
    }
}

/// All pictures with their error maps and pictures.csv.
pub(super) fn draw(
    plan: &Plan<'_>,
    scenes: &[LoadedScene<'_>],
) -> Result<Vec<RecordedFile>, EvaluationError> {
    let (mut files, mut rows) = (Vec::new(), Vec::new());
    for (index, picture) in plan.experiment.picture.iter().enumerate() {
        let Some(found) = found(picture, scenes) else { continue };
        draw_one(plan, (index, picture), found, (&mut files, &mut rows))?;
    }
    if !rows.is_empty() {
        files.push(RecordedFile::csv("pictures.csv", &rows)?);
    }
    Ok(files)
}

/// A translucent surface in a pixel.
struct Veil {
    distance: f64,
    /// What passes, by channel.
    through: [f32; 3],
    albedo: [f32; 3],
    receiver: Option<Receiver>,
}

/// What a camera sees.
struct Sight {
    frame: Frame,
    /// Nearest first, in front of the opaque surface of each pixel.
    veils: Vec<Vec<Veil>>,
    /// Opaque surfaces that face the light.
    receivers: Vec<Option<Receiver>>,
}

fn draw_one(
    plan: &Plan<'_>,
    (index, picture): (usize, &TranslucentPicture),
    (loaded, scene, light): (&LoadedScene<'_>, &Scene, &LightView),
    (files, rows): (&mut Vec<RecordedFile>, &mut Vec<TranslucentPictureRecord>),
) -> Result<(), EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("picture `{}`: {reason}", picture.id));
    let experiment = plan.experiment;
    let view = View::new(experiment, &plan.kernel, (loaded, light), 0)?;
    let frame = view.frame.ok_or_else(|| fail("a stack has no camera".to_owned()))?;
    let fov = 2.0 * ((0.5 * f64::from(scene.camera.vertical_fov)).tan() / picture.zoom).atan();
    let camera = Camera { vertical_fov: fov as f32, ..scene.camera };
    let sight = Sight::new(scene, &camera, picture.output, &frame).map_err(|e| fail(e.to_string()))?;
    let shadow = view.shadow(experiment, &plan.kernel);
    let truth = sight.answers(&|receiver| shadow.truth(receiver));
    let mut columns = vec![sight.shade(light, &truth)];
    let techniques = experiment.named(&picture.techniques, &format!("picture[{index}].techniques"))?;
    for technique in techniques {
        let (of, method) = (&experiment.technique[technique], &plan.methods[technique]);
        let named = |reason: String| fail(format!("technique `{}`: {reason}", of.name));
        let ranks = view.ranks(of.order).map_err(named)?;
        let prepared = method
            .prepare(&view.map, &plan.kernel, ranks, experiment.scenery.seed)
            .map_err(|error| named(error.to_string()))?;
        let answer = |receiver: &Receiver| {
            prepared.unclamped(&shadow, receiver).map_or(0.0, |shadow| shadow.clamp(0.0, 1.0))
        };
        let found = sight.answers(&answer);
        columns.push(sight.shade(light, &found));
        let errors = found.0.iter().zip(&truth.0).map(|(found, truth)| Some((*found)? - (*truth)?));
        let errors: Vec<Option<f64>> = errors.collect();
        let [width, height] = picture.output;
        let grey = GrayImage::from_fn(width, height, |x, y| {
            signed_grey(errors[(y * width + x) as usize].unwrap_or(0.0))
        });
        files.push(png(map_name(&picture.id, &light.name, &of.name), grey.into())?);
        let pairs = found.1.iter().zip(&truth.1);
        let on_veils = pairs.flat_map(|(found, truth)| found.iter().zip(truth)).map(|(a, b)| (a - b).abs());
        let on_veils: Vec<f64> = on_veils.collect();
        let mean = |values: &[f64]| rounded(values.iter().sum::<f64>() / values.len().max(1) as f64);
        let magnitudes: Vec<f64> = errors.iter().flatten().map(|error| error.abs()).collect();
        rows.push(TranslucentPictureRecord {
            picture: picture.id.clone(),
            technique: of.name.clone(),
            pixels: magnitudes.len(),
            l1_error: mean(&magnitudes),
            veils: on_veils.len(),
            veil_error: mean(&on_veils),
        });
    }
    let all = side_by_side(&columns, picture.output, &picture.insets);
    files.push(png(format!("{}.png", picture.id), DynamicImage::from(all).to_rgb8().into())?);
    Ok(())
}

/// Shadows of opaque surfaces by pixel, and of the veils in front of them.
type Answers = (Vec<Option<f64>>, Vec<Vec<f64>>);

impl Sight {
    fn new(
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        light: &LightFrame,
    ) -> Result<Self, shadow_renderer::RenderError> {
        let frame = Frame::render_from(&without_veils(scene), camera, size)?;
        let rays = ViewRays::new(camera, size)?;
        let eye = camera.eye.map(f64::from);
        let forward = normalize(minus(camera.target.map(f64::from), eye));
        let triangles = veil_triangles(scene);
        let pixels = size[0] as usize * size[1] as usize;
        let veils = (0..pixels)
            .into_par_iter()
            .map(|pixel| {
                let at = [pixel as u32 % size[0], pixel as u32 / size[0]].map(|c| f64::from(c) + 0.5);
                let ray = (eye, rays.through(at));
                let behind = if frame.triangle[pixel] == shadow_renderer::NO_TRIANGLE {
                    f64::INFINITY
                } else {
                    dot(minus(frame.position[pixel].map(f64::from), eye), forward)
                };
                let met = triangles.iter().filter_map(|&triangle| veil(scene, triangle, ray, behind, light));
                let mut met: Vec<Veil> = met.collect();
                met.sort_by(|a, b| a.distance.total_cmp(&b.distance));
                met
            })
            .collect();
        let seen = Seen { frame: &frame, light };
        let facing = |pixel: usize| {
            let (receiver, _) = seen.receiver(pixel)?;
            seen.faces_light(pixel).then_some(receiver)
        };
        let receivers = (0..pixels).map(facing).collect();
        Ok(Self { frame, veils, receivers })
    }

    fn answers(&self, shadow: &(dyn Fn(&Receiver) -> f64 + Sync)) -> Answers {
        let surfaces = self.receivers.par_iter().map(|receiver| receiver.as_ref().map(shadow)).collect();
        let of_veil = |veil: &Veil| veil.receiver.as_ref().map_or(0.0, shadow);
        let veils = self.veils.par_iter().map(|veils| veils.iter().map(of_veil).collect()).collect();
        (surfaces, veils)
    }

    /// Opaque surfaces by their light, and the veils before them from the farthest to the nearest.
    fn shade(&self, light: &LightView, (surfaces, veils): &Answers) -> RgbaImage {
        // Surfaces that face away from the light are dark by their cosine.
        let visibility: Vec<f32> = surfaces.iter().map(|shadow| 1.0 - shadow.unwrap_or(0.0) as f32).collect();
        self.frame.shade_behind(light, &visibility, |pixel, linear| {
            let pairs = self.veils[pixel].iter().zip(&veils[pixel]);
            pairs.rev().fold(linear, |behind, (veil, shadow)| {
                let light = AMBIENT + (1.0 - AMBIENT) * (1.0 - *shadow as f32);
                [0, 1, 2]
                    .map(|k| veil.through[k] * behind[k] + (1.0 - veil.through[k]) * veil.albedo[k] * light)
            })
        })
    }
}

/// Whether a material is drawn in front of what is opaque.
fn is_veil(scene: &Scene, triangle: usize) -> bool {
    let opacity = &scene.materials[scene.triangle_material[triangle] as usize].opacity;
    opacity.as_ref().is_some_and(|opacity| !opacity.tested)
}

/// Triangles of translucent surfaces; none where there are too many.
fn veil_triangles(scene: &Scene) -> Vec<usize> {
    let all: Vec<usize> = (0..scene.triangles.len()).filter(|&triangle| is_veil(scene, triangle)).collect();
    if all.len() > MOST_TRIANGLES { Vec::new() } else { all }
}

fn without_veils(scene: &Scene) -> Scene {
    let mut opaque = scene.clone();
    let nowhere = Arc::new(AlphaMask { width: 1, height: 1, alpha: vec![0], cutoff: 1 });
    for material in &mut opaque.materials {
        if material.opacity.as_ref().is_some_and(|opacity| !opacity.tested) {
            material.mask = Some(nowhere.clone());
        }
    }
    opaque
}

/// Where a ray, of length 1 along the view, meets a translucent triangle in front of `behind`.
fn veil(
    scene: &Scene,
    triangle: usize,
    (eye, direction): ([f64; 3], [f64; 3]),
    behind: f64,
    light: &LightFrame,
) -> Option<Veil> {
    let corners = scene.triangles[triangle].map(|i| scene.vertices[i as usize]);
    let [a, b, c] = corners.map(|vertex| vertex.position.map(f64::from));
    let (ab, ac) = (minus(b, a), minus(c, a));
    let across = cross(direction, ac);
    let determinant = dot(ab, across);
    if determinant == 0.0 {
        return None;
    }
    let from_a = minus(eye, a);
    let v = dot(from_a, across) / determinant;
    let up = cross(from_a, ab);
    let w = dot(direction, up) / determinant;
    let distance = dot(ac, up) / determinant;
    if v < 0.0 || w < 0.0 || v + w > 1.0 || distance <= 0.0 || distance >= behind {
        return None;
    }
    let weights = [1.0 - v - w, v, w];
    let material = &scene.materials[scene.triangle_material[triangle] as usize];
    let opacity = material.opacity.as_ref()?;
    let uv = [0, 1].map(|k| (0..3).map(|i| weights[i] * f64::from(corners[i].uv[k])).sum::<f64>());
    let alpha: f64 = (0..3)
        .map(|i| {
            let color = scene.colors.get(scene.triangles[triangle][i] as usize);
            weights[i] * color.map_or(1.0, |color| f64::from(color[3]))
        })
        .sum();
    let value = |texture: &scenes::AlphaTexture| {
        let texel = |t: f64, size: u32| ((t.rem_euclid(1.0) * f64::from(size)) as u32).min(size - 1);
        texture.value(texel(uv[0], texture.width), texel(uv[1], texture.height))
    };
    let covered = f64::from(opacity.factor) * opacity.texture.as_deref().map_or(1.0, value) * alpha;
    let passing = opacity.transmission_texture.as_deref().map_or(1.0, value);
    let through = opacity.transmission.map(|t| (1.0 - covered * (1.0 - f64::from(t) * passing)) as f32);
    if through == [1.0; 3] {
        return None;
    }
    let position = [0, 1, 2].map(|k| eye[k] + distance * direction[k]);
    let [x, y, depth] = light.project(position);
    let gradient = light.gradient(position, normalize(cross(ab, ac)));
    let gradient = gradient.map(|slope| if slope.is_finite() { slope } else { 0.0 });
    let on_map = |t: f64, size: u32| t >= 0.0 && t < f64::from(size);
    let receiver = (on_map(x, light.width) && on_map(y, light.height) && (0.0..=1.0).contains(&depth))
        .then_some(Receiver { x: x as usize, y: y as usize, depth, gradient });
    Some(Veil { distance, through, albedo: material.albedo, receiver })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The camera looks through smoke onto the ground.
    #[test]
    fn smoke_is_seen_before_what_is_opaque() {
        let scene = scenes::load_scene("smoke").unwrap();
        let view = scene.views[0].clone();
        let light = LightFrame::of_view(&scene, &view, 64, 64).unwrap();
        let sight = Sight::new(&scene, &scene.camera, [40, 30], &light).unwrap();
        let most = sight.veils.iter().map(Vec::len).max().unwrap();
        assert!((3..=15).contains(&most), "{most}");
        assert!(sight.veils.iter().all(|veils| veils.windows(2).all(|w| w[0].distance <= w[1].distance)));
        let dark = sight.shade(&view, &sight.answers(&|_| 1.0));
        let lit = sight.shade(&view, &sight.answers(&|_| 0.0));
        let sum = |image: &RgbaImage| image.pixels().map(|p| u64::from(p[0])).sum::<u64>();
        assert!(sum(&dark) < sum(&lit));
    }
}
