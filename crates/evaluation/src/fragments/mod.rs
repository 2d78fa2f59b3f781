//! From a scene to the fragments of its light views: what every kind of experiment on scenes starts from.

mod camera;
pub(crate) mod light;
mod lighting;
mod reference;
mod settings;
mod truth;
mod view_record;

pub(crate) use camera::Seen;
pub use lighting::Lighting;
pub use reference::ReferenceRecord;
pub(crate) use reference::reference_records;
pub use settings::SceneSettings;
pub(crate) use settings::{MAX_SIZE, check_bias};
pub use truth::TruthSetting;
pub use view_record::ViewRecord;

use crate::error::EvaluationError;
use random_stream::Random;
use scenes::{LightView, Scene, load_scene};
use shadow_filtering::{DepthMap, FilteringError, Kernel, Receiver};
use shadow_renderer::{
    Backend, LightFrame, RenderError, ShadowMapStack, Spectrum, TranslucentStack, render_in_frame,
    render_translucent, render_view,
};
use std::borrow::Cow;
use std::path::Path;

/// What a shadow map is made from.
pub(crate) enum Source {
    Scene(Box<Scene>),
    /// A stack that was rendered before; its one view is called `stack`.
    Stack(ShadowMapStack),
}

type RenderedView<'a> = (Cow<'a, ShadowMapStack>, f64, Option<LightFrame>);

/// A light view's stack with opacities.
pub(crate) struct TranslucentView<'a> {
    pub(crate) stack: Cow<'a, ShadowMapStack>,
    /// The scene's triangle of each fragment; empty where all are opaque, and for a stack that was rendered before.
    pub(crate) triangles: Vec<u32>,
    pub(crate) texel_depth: f64,
    /// From the world to the map; unknown for a stack that was rendered before.
    pub(crate) frame: Option<LightFrame>,
}

/// A scene with its label and the views that are wanted.
pub(crate) struct LoadedScene<'a> {
    pub(crate) label: &'a str,
    pub(crate) source: Source,
    pub(crate) lights: Vec<LightView>,
}

/// A light view's stack with what every experiment makes of it.
pub(crate) struct Lit<'a> {
    pub(crate) stack: Cow<'a, ShadowMapStack>,
    pub(crate) map: DepthMap,
    pub(crate) texel_depth: f64,
    /// From the world to the map; unknown for a stack that was rendered before.
    pub(crate) frame: Option<LightFrame>,
    /// All fragments: light-facing entries whose kernel lies inside the map. Never empty.
    pub(crate) receivers: Vec<Receiver>,
}

impl LoadedScene<'_> {
    /// Reads all scenes. Without names of views, all views of a scene are wanted whose light has no extent.
    pub(crate) fn load_all<'a>(
        labels: &'a [String],
        views: &[String],
    ) -> Result<Vec<LoadedScene<'a>>, EvaluationError> {
        let load = |(index, label): (usize, &'a String)| {
            let (source, mut lights) = Source::load(label).map_err(|reason| EvaluationError::Key {
                key: format!("scenes[{index}]"),
                reason: format!("scene `{label}`: {reason}"),
            })?;
            let known: Vec<String> = lights.iter().map(|light| light.name.clone()).collect();
            lights.retain(|view| match views {
                [] => !view.light.has_extent(),
                named => named.contains(&view.name),
            });
            if lights.is_empty() {
                let reason = format!("views = {views:?} match none of {} of `{label}`", known.join(", "));
                return Err(EvaluationError::Key { key: "views".to_owned(), reason });
            }
            Ok(LoadedScene { label, source, lights })
        };
        let loaded: Vec<LoadedScene<'a>> = labels.iter().enumerate().map(load).collect::<Result<_, _>>()?;
        let is_known =
            |view: &&String| loaded.iter().any(|scene| scene.lights.iter().any(|light| light.name == **view));
        if let Some((i, view)) = views.iter().enumerate().find(|(_, view)| !is_known(view)) {
            let reason = format!("views: `{view}` is a view of none of {}", labels.join(", "));
            return Err(EvaluationError::Key { key: format!("views[{i}]"), reason });
        }
        Ok(loaded)
    }

    /// Renders one of its views.
    pub(crate) fn lit(
        &self,
        light: &LightView,
        size: u32,
        kernel: &Kernel,
    ) -> Result<Lit<'_>, EvaluationError> {
        let fail = |reason: String| {
            EvaluationError::Value(format!("scene `{}`, view `{}`: {reason}", self.label, light.name))
        };
        let (stack, texel_depth, frame) =
            self.source.stack(light, size).map_err(|error| fail(error.to_string()))?;
        let (width, height) = (stack.width as usize, stack.height as usize);
        let map = depth_map(&stack).map_err(|error| fail(error.to_string()))?;
        let receivers = fragments(&stack, kernel);
        if receivers.is_empty() {
            let side = kernel.size();
            let reason = format!(
                "scene `{}`, view `{}`: no light-facing fragment has its {side}x{side} kernel inside a map of \
                 {width}x{height} texels",
                self.label, light.name
            );
            return Err(EvaluationError::Key { key: "kernel.size".to_owned(), reason });
        }
        Ok(Lit { stack, map, texel_depth, frame, receivers })
    }
}

impl LoadedScene<'_> {
    /// Renders one of its views with opacities.
    pub(crate) fn translucent(
        &self,
        light: &LightView,
        size: u32,
        spectrum: Spectrum,
    ) -> Result<TranslucentView<'_>, EvaluationError> {
        self.source.translucent(light, size, spectrum).map_err(|error| {
            EvaluationError::Value(format!("scene `{}`, view `{}`: {error}", self.label, light.name))
        })
    }

    /// Whether light may pass through some surface.
    pub(crate) fn may_be_translucent(&self) -> bool {
        match &self.source {
            Source::Scene(scene) => {
                scene.materials.iter().flat_map(|material| &material.opacity).any(|opacity| !opacity.tested)
            }
            Source::Stack(stack) => stack.opacities.iter().any(|&opacity| opacity < 1.0),
        }
    }

    /// Width of the map where the scene is a stack, which has no other size.
    pub(crate) fn own_size(label: &str) -> Result<Option<u32>, EvaluationError> {
        if !is_stack(label) {
            return Ok(None);
        }
        match Source::load(label) {
            Ok((Source::Stack(stack), _)) => Ok(Some(stack.width)),
            Ok(_) => Ok(None),
            Err(reason) => Err(EvaluationError::Value(format!("scene `{label}`: {reason}"))),
        }
    }

    /// The shadow map of the same frame with the side divided; `None` for a stack, whose scene is unknown.
    pub(crate) fn divided_map(
        &self,
        light: &LightView,
        size: u32,
        divisor: u32,
    ) -> Result<Option<DepthMap>, EvaluationError> {
        let Source::Scene(scene) = &self.source else { return Ok(None) };
        let fail = |reason: String| {
            EvaluationError::Value(format!("scene `{}`, view `{}`: {reason}", self.label, light.name))
        };
        let whole = LightFrame::of_view(scene, light, size, size).map_err(|e| fail(e.to_string()))?;
        let scale = f64::from(divisor);
        let frame = LightFrame {
            texels_per_unit: whole.texels_per_unit.map(|texels| texels / scale),
            origin_texel: whole.origin_texel.map(|texel| texel / scale),
            width: size / divisor,
            height: size / divisor,
            ..whole
        };
        let (stack, _) =
            render_in_frame(scene, &frame, Backend::Cpu).map_err(|error| fail(error.to_string()))?;
        depth_map(&stack).map(Some).map_err(|error| fail(error.to_string()))
    }
}

/// Whether a scene can be read: a procedural name, a scene file or a stack.
///
/// # Errors
/// [`EvaluationError::Value`] with the reason.
pub fn check_scene(label: &str) -> Result<(), EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("scene `{label}`: {reason}"));
    Source::load(label).map(|_| ()).map_err(fail)
}

pub(crate) fn is_stack(label: &str) -> bool {
    Path::new(label).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npz"))
}

pub(crate) fn depth_map(stack: &ShadowMapStack) -> Result<DepthMap, FilteringError> {
    let depths = stack.shadow_map().into_iter().map(|depth| depth.unwrap_or(1.0)).collect();
    DepthMap::new(stack.width as usize, stack.height as usize, depths)
}

impl Source {
    /// Reads a procedural scene, a scene file or a stack, with its views.
    fn load(label: &str) -> Result<(Self, Vec<LightView>), String> {
        let path = Path::new(label);
        if is_stack(label) {
            let stack = ShadowMapStack::load(path).map_err(|error| error.to_string())?;
            // A stack's depth grows along its own axis.
            let view = LightView::directional("stack", [0.0, 0.0, 1.0]);
            return Ok((Self::Stack(stack), vec![view]));
        }
        let scene = load_scene(label).map_err(|error| error.to_string())?;
        let views = scene.views.clone();
        Ok((Self::Scene(Box::new(scene)), views))
    }

    /// The stack of a view, with the view's texel depth and frame.
    fn stack(&self, light: &LightView, size: u32) -> Result<RenderedView<'_>, RenderError> {
        match self {
            Self::Scene(scene) => {
                let (stack, report) = render_view(scene, light, size, size, Backend::Cpu)?;
                Ok((Cow::Owned(stack), texel_depth(&report.frame), Some(report.frame)))
            }
            // What knows no translucency takes surfaces as it would from their scene.
            Self::Stack(stack) if !stack.opacities.is_empty() => {
                Ok((Cow::Owned(stack.clone().opaque()), median_gradient(stack), None))
            }
            Self::Stack(stack) => Ok((Cow::Borrowed(stack), median_gradient(stack), None)),
        }
    }

    /// The same with opacities in one kind of light; a stack has one kind only.
    fn translucent(
        &self,
        light: &LightView,
        size: u32,
        spectrum: Spectrum,
    ) -> Result<TranslucentView<'_>, RenderError> {
        match self {
            Self::Scene(scene) => {
                let frame = LightFrame::of_view(scene, light, size, size)?;
                let (TranslucentStack { stack, triangles }, _) =
                    render_translucent(scene, &frame, spectrum, Backend::Cpu)?;
                let stack = Cow::Owned(stack);
                Ok(TranslucentView { stack, triangles, texel_depth: texel_depth(&frame), frame: Some(frame) })
            }
            Self::Stack(stack) => Ok(TranslucentView {
                stack: Cow::Borrowed(stack),
                triangles: Vec::new(),
                texel_depth: median_gradient(stack),
                frame: None,
            }),
        }
    }
}

/// The texel depth of a stack, which does not tell the size of its texels: the median length of its gradients, as if
/// half of all surfaces were inclined by more than 45 degrees to the light.
fn median_gradient(stack: &ShadowMapStack) -> f64 {
    let mut lengths: Vec<f64> =
        stack.gradients.iter().map(|g| f64::from(g[0]).hypot(f64::from(g[1]))).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or_default()
}

/// Side of a texel over the depth range: the geometric mean of both sides, which are fitted on their own. Under a local
/// light texels grow with the distance; the one in the middle counts.
pub(crate) fn texel_depth(frame: &LightFrame) -> f64 {
    let [x, y] = frame.texels_per_unit;
    let side = 1.0 / (x * y).sqrt();
    let growth = frame.eye.map_or(1.0, |_| (frame.near + 0.5 * frame.depth_range) / frame.near);
    growth * side / frame.depth_range
}

fn fragments(stack: &ShadowMapStack, kernel: &Kernel) -> Vec<Receiver> {
    let (width, height) = (stack.width as usize, stack.height as usize);
    let mut receivers = Vec::new();
    for y in 0..height {
        for x in (0..width).filter(|&x| kernel.fits(width, height, x, y)) {
            let layers = stack.layers(x as u32, y as u32).filter(|layer| layer.light_facing);
            receivers.extend(layers.map(|layer| Receiver {
                x,
                y,
                depth: f64::from(layer.depth),
                gradient: layer.gradient.map(f64::from),
            }));
        }
    }
    receivers
}

/// Ascending indices of `wanted` of `all` fragments, one at random from each of `wanted` equal parts; 0 takes all.
pub(crate) fn chosen(all: usize, wanted: usize, seed: u64, stream: usize) -> Vec<usize> {
    if wanted == 0 || wanted >= all {
        return (0..all).collect();
    }
    let mut random = Random::substream(seed, stream as u64, 0);
    let pick = |i: usize| ((i as f64 + random.unit()) * all as f64 / wanted as f64) as usize;
    let mut indices: Vec<usize> = (0..wanted).map(pick).map(|index| index.min(all - 1)).collect();
    // Rounding at the seam of two parts could name a fragment twice.
    indices.dedup();
    indices
}

/// Evenly spread indices, at most `wanted`.
pub(crate) fn spread(all: usize, wanted: usize) -> Vec<usize> {
    if wanted >= all {
        return (0..all).collect();
    }
    (0..wanted).map(|i| (2 * i + 1) * all / (2 * wanted)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_ascend_are_spread_and_depend_on_seed_and_view() {
        let indices = chosen(1000, 100, 1, 0);
        assert_eq!(indices.len(), 100);
        assert!(indices.windows(2).all(|w| w[0] < w[1]) && indices[99] < 1000);
        assert!(indices.iter().enumerate().all(|(i, index)| index / 10 == i));
        assert_eq!(indices, chosen(1000, 100, 1, 0));
        assert_ne!(indices, chosen(1000, 100, 1, 1));
        assert_ne!(indices, chosen(1000, 100, 2, 0));
        assert_eq!(chosen(5, 0, 1, 0).len(), 5);
        assert_eq!(chosen(5, 9, 1, 0).len(), 5);
    }
}
