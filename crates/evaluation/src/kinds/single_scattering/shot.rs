//! A camera under a light: its rays, its frustum, and the rectified maps for it.

use super::settings::SingleScatteringExperiment;
use super::view::LitScene;
use crate::error::EvaluationError;
use applications::scattering::{
    FilteredDepths, Frustum, LightMap, Rectification, RectifiedMap, SingleScattering, ViewRay,
};
use applications::soft_shadow::BlueNoise;
use scenes::Camera;
use scenes::vector::{dot, minus, norm, normalize};
use shadow_filtering::{ChannelMap, Technique};
use shadow_renderer::{Frame, NO_TRIANGLE, ViewRays};

/// A camera under a light.
pub(super) struct Shot<'a> {
    pub(super) view: SingleScattering<'a>,
    pub(super) frustum: Frustum,
    /// One a pixel.
    pub(super) rays: Vec<ViewRay>,
    pub(super) camera: Camera,
    pub(super) frame: Frame,
}

/// The moment shadow map that is resampled with a filter.
pub(super) struct Source<'a> {
    pub(super) technique: &'a Technique,
    pub(super) stored: &'a ChannelMap<f64>,
}

/// Rectified maps of a camera by whether they are filtered and their guard band.
pub(super) struct Maps {
    all: Vec<(bool, f64, RectifiedMap)>,
}

/// Streams of shadow rays of one camera.
const STREAMS: u64 = 1 << 32;

/// How much farther than its farthest ray a frustum ends.
const MARGIN: f64 = 1.0 + 1e-9;

impl<'a> Shot<'a> {
    /// `number` counts cameras over all views.
    pub(super) fn new(
        lit: &'a LitScene<'_>,
        camera: Camera,
        size: [u32; 2],
        (noise, number): (&BlueNoise, usize),
    ) -> Result<Self, EvaluationError> {
        let fail = |error: String| EvaluationError::Value(format!("{}: {error}", lit.words()));
        let frame = Frame::render_from(lit.scene, &camera, size).map_err(|error| fail(error.to_string()))?;
        let through = ViewRays::new(&camera, size).map_err(|error| fail(error.to_string()))?;
        let apex = camera.eye.map(f64::from);
        let [width, height] = size.map(f64::from);
        let view =
            SingleScattering { light: lit.light_map(), axes: lit.axes, medium: lit.medium, camera: apex };
        let ray = |pixel: usize| {
            let at = [pixel % size[0] as usize, pixel / size[0] as usize];
            let direction = normalize(through.through(at.map(|place| place as f64 + 0.5)));
            let length = if frame.triangle[pixel] == NO_TRIANGLE {
                f64::INFINITY
            } else {
                norm(minus(frame.position[pixel].map(f64::from), apex))
            };
            let stream = number as u64 * STREAMS + pixel as u64;
            ViewRay { direction, length, noise: noise.at(at[0], at[1])[0], stream }
        };
        let rays: Vec<ViewRay> = (0..frame.triangle.len()).map(ray).collect();
        // Up to where the visibility of any ray changes, along the view.
        let forward = normalize(through.through([0.5 * width, 0.5 * height]));
        let far = rays.iter().map(|ray| view.end(ray) * dot(ray.direction, forward)).fold(0.0, f64::max);
        let far = if far > 0.0 { MARGIN * far } else { 1.0 };
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(|corner| {
            let direction = through.through(corner);
            [0, 1, 2].map(|k| apex[k] + far * direction[k])
        });
        Ok(Self { view, frustum: Frustum { apex, corners }, rays, camera, frame })
    }

    /// Least angle of a pixel to the light's axis, in degrees.
    pub(super) fn epipole(&self) -> f64 {
        self.rays.iter().map(|ray| epipole_distance(&self.view, ray)).fold(90.0, f64::min)
    }
}

/// Angle between a ray and the light's axis, whichever end is nearer, in degrees.
pub(super) fn epipole_distance(view: &SingleScattering<'_>, ray: &ViewRay) -> f64 {
    let [x, y, z] = view.axes.direction(ray.direction);
    x.hypot(y).atan2(z.abs()).to_degrees()
}

impl Maps {
    /// All that the techniques at `wanted` take, for a camera.
    pub(super) fn new(
        experiment: &SingleScatteringExperiment,
        shot: &Shot<'_>,
        source: &Source<'_>,
        wanted: &[usize],
    ) -> Result<Self, EvaluationError> {
        let mut maps = Self { all: Vec::new() };
        maps.add(experiment, shot, source, (false, experiment.guard_band))?;
        for &index in wanted {
            let method = &experiment.technique[index].method;
            if method.steps.is_none() {
                let band = method.guard_band.unwrap_or(experiment.guard_band);
                maps.add(experiment, shot, source, (method.filtered, band))?;
            }
        }
        Ok(maps)
    }

    fn add(
        &mut self,
        experiment: &SingleScatteringExperiment,
        shot: &Shot<'_>,
        source: &Source<'_>,
        (filtered, band): (bool, f64),
    ) -> Result<(), EvaluationError> {
        if self.find(filtered, band).is_some() {
            return Ok(());
        }
        let fail = |error: String| EvaluationError::Value(format!("rectified map: {error}"));
        let rectification = Rectification::new(&shot.frustum, shot.view.axes, experiment.rectified, band)
            .map_err(|error| fail(error.to_string()))?;
        let light: &LightMap<'_> = &shot.view.light;
        let map = if filtered {
            let depths = FilteredDepths::new(source.technique, source.stored)
                .map_err(|error| fail(error.to_string()))?;
            RectifiedMap::filtered(rectification, light, &depths).map_err(|error| fail(error.to_string()))?
        } else {
            RectifiedMap::nearest(rectification, light)
        };
        self.all.push((filtered, band, map));
        Ok(())
    }

    fn find(&self, filtered: bool, band: f64) -> Option<&RectifiedMap> {
        self.all.iter().find(|map| map.0 == filtered && map.1 == band).map(|map| &map.2)
    }

    /// A map that was made.
    pub(super) fn get(&self, filtered: bool, band: f64) -> Result<&RectifiedMap, EvaluationError> {
        let missing = || EvaluationError::Value(format!("no rectified map with a guard band of {band}"));
        self.find(filtered, band).ok_or_else(missing)
    }
}
