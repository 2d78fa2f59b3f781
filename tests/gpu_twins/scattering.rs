//! Compute passes of single scattering against their Rust twins: resampling, prefix sums, look-ups and ray marching on three
//! views of scenes, against double precision.

use super::adapter::gpu_trial;
use super::compute::{self, Resource};
use applications::scattering::{
    Blending, FilteredDepths, Frustum, Jitter, LightAxes, LightMap, Marched, Medium, Prefiltered,
    Rectification, RectifiedMap, RectifiedTexel, SingleScattering, Spacing, StoredPrefixes, ViewRay,
    look_up_between_shader, look_up_shader, march_shader, prefix_map_shader, prefix_words,
    resample_filtered_shader, resample_shader, scattering_uniform,
};
use applications::{Application, Estimate};
use libtest_mimic::{Failed, Trial};
use quantization::NumberFormat;
use random_stream::Random;
use scenes::load_scene;
use scenes::vector::{cross, minus, norm, normalize};
use shaders::Module;
use shadow_filtering::{DepthMap, TechniqueSpec};
use shadow_renderer::{Backend, render_view};

/// Columns and rows of the rectified map.
const SIZE: [usize; 2] = [200, 96];

/// Side of shadow maps.
const SIDE: u32 = 256;

/// View rays a view.
const RAYS: usize = 4000;

/// Rays that are left out on both sides: where they end on the border of a row, a column or a texel, any rounding decides.
const JUMPS: usize = 40;

/// From where to where sines and cosines store depths.
const MARGIN: f64 = 0.05;

/// Samples of marched rays.
const STEPS: usize = 32;

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, spec, blending) in techniques() {
        let of = spec.clone();
        trials.push(Trial::test(format!("wgsl::scattering::{name}"), move || valid(&of, blending)));
        trials.push(gpu_trial(format!("scattering::{name}"), move || {
            prefiltered(&spec, (blending, Spacing::default()), &[])
        }));
    }
    let (_, four, half) = techniques().swap_remove(1);
    trials.push(gpu_trial("scattering::two_spacings".into(), move || {
        prefiltered(&four, (half, Spacing::Two), &[])
    }));
    trials.push(gpu_trial("scattering::resample".into(), || resample("")));
    trials.push(gpu_trial("scattering::resample_filtered".into(), || resample_filtered("")));
    trials.push(gpu_trial("scattering::march".into(), || march("")));
    trials
}

fn moments(bound: &str, transform: &str, format: NumberFormat, alpha: f64) -> TechniqueSpec {
    TechniqueSpec {
        transform: Some(transform.to_owned()),
        format: Some(format),
        alpha: Some(alpha),
        ..TechniqueSpec::named(bound).unwrap()
    }
}

pub(crate) fn techniques() -> Vec<(&'static str, TechniqueSpec, Blending)> {
    let half = Blending::Fixed(0.5);
    let series = TechniqueSpec {
        coefficients: Some(16),
        transform: Some("sampled".to_owned()),
        format: Some(NumberFormat::Unorm8),
        ..TechniqueSpec::named("fourier").unwrap()
    };
    vec![
        ("two_moments", moments("hamburger2", "plain", NumberFormat::Unorm16, 6e-5), half),
        ("four_moments", moments("hamburger4", "GDC16 four moments", NumberFormat::Unorm16, 6e-5), half),
        (
            "four_moments_single",
            moments("hamburger4", "identity", NumberFormat::F32, 1e-6),
            Blending::Fixed(0.0),
        ),
        ("four_moments_half", moments("hamburger4", "identity", NumberFormat::F16, 3e-3), half),
        ("six_moments", moments("hamburger6", "GDC16 six moments", NumberFormat::Unorm10, 4e-3), half),
        (
            "six_moments_adaptive",
            moments("hamburger6", "identity", NumberFormat::F32, 5e-6),
            Blending::Adaptive,
        ),
        (
            "hausdorff",
            moments("hausdorff4", "MSM15 theta_4", NumberFormat::Unorm16, 6e-5),
            Blending::Fixed(1.0),
        ),
        ("trigonometric", moments("trigonometric4", "plain", NumberFormat::Unorm16, 2e-3), half),
        ("convolution", series, Blending::Fixed(0.0)),
    ]
}

/// Sines and cosines take depth 0 for depth 1.
fn margin(spec: &TechniqueSpec) -> f64 {
    if spec.bound.is_some_and(|bound| bound.as_str() == "trigonometric4") { MARGIN } else { 0.0 }
}

/// A scene's shadow map with what a camera sees of the light; the camera inside, outside and looking into the light.
struct Seen {
    map: DepthMap,
    axes: LightAxes,
    corner: [f64; 2],
    texel: [f64; 2],
    near: f64,
    range: f64,
    camera: [f64; 3],
    corners: [[f64; 3]; 4],
    rays: Vec<ViewRay>,
}

impl Seen {
    fn new(scene: &str, light: usize, looks_at_light: bool) -> Result<Self, Failed> {
        let scene = load_scene(scene)?;
        let (stack, report) = render_view(&scene, &scene.views[light], SIDE, SIDE, Backend::Cpu)?;
        let depths = stack.shadow_map().into_iter().map(|depth| depth.unwrap_or(1.0)).collect();
        let frame = report.frame;
        let texel = frame.texels_per_unit.map(|texels| 1.0 / texels);
        let camera = scene.camera.eye.map(f64::from);
        let towards = minus(scene.camera.target.map(f64::from), camera);
        let forward = if looks_at_light { frame.forward.map(|c| -c) } else { normalize(towards) };
        let right = normalize(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let far = 2.0 * norm(towards);
        let at = |x: f64, y: f64| [0, 1, 2].map(|k| forward[k] + 0.8 * x * right[k] + 0.5 * y * up[k]);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| [0, 1, 2].map(|k| camera[k] + far * at(x, y)[k]));
        let mut random = Random::new(12);
        let rays = (0..RAYS).map(|stream| {
            let along = at(2.0 * random.unit() - 1.0, 2.0 * random.unit() - 1.0);
            // What a shader is given.
            let direction = normalize(along).map(|c| f64::from(c as f32));
            let length =
                if stream % 7 == 0 { f64::INFINITY } else { f64::from((far * random.unit()) as f32) };
            ViewRay { direction, length, noise: f64::from(random.unit() as f32), stream: stream as u64 }
        });
        Ok(Self {
            map: DepthMap::new(SIDE as usize, SIDE as usize, depths)?,
            axes: LightAxes { x: frame.right, y: frame.down, light: frame.forward },
            corner: [0, 1].map(|k| -frame.origin_texel[k] * texel[k]),
            texel,
            near: frame.near,
            range: frame.depth_range,
            camera,
            corners,
            rays: rays.collect(),
        })
    }

    fn all() -> Result<[Self; 3], Failed> {
        Ok([Self::new("hall", 2, false)?, Self::new("stairs", 1, false)?, Self::new("stairs", 2, true)?])
    }

    fn view(&self) -> Result<SingleScattering<'_>, Failed> {
        let light = LightMap {
            map: &self.map,
            corner: self.corner,
            texel: self.texel,
            near: self.near,
            range: self.range,
        };
        let medium = Medium::new(0.05, 1.0, 0.0)?;
        Ok(SingleScattering { light, axes: self.axes, medium, camera: self.camera })
    }

    fn frustum(&self) -> Frustum {
        Frustum { apex: self.camera, corners: self.corners }
    }

    fn rectification(&self, guard_band: f64) -> Result<Rectification, Failed> {
        Ok(Rectification::new(&self.frustum(), self.axes, SIZE, guard_band)?)
    }

    /// Directions in light space with `last`.
    fn rays_for_shader(&self, last: impl Fn(&ViewRay) -> f64) -> Vec<[f32; 4]> {
        let of = |ray: &ViewRay| {
            let [x, y, z] = self.axes.direction(ray.direction);
            [x, y, z, last(ray)].map(|value| value as f32)
        };
        self.rays.iter().map(of).collect()
    }
}

/// With or without `FROM=>TO`.
pub(crate) fn faulty(source: String, faults: &[&str]) -> String {
    faults.iter().fold(source, |source, fault| match fault.split_once("=>") {
        Some((from, to)) if source.contains(from) => source.replacen(from, to, 1),
        Some(_) | None => source,
    })
}

/// The shader's errors against those of Rust in single precision, without the worst of both, whose number is `jumps`.
pub(crate) fn judge(
    what: &str,
    shader: &[f32],
    single: &[f32],
    exact: &[f64],
    jumps: usize,
) -> Result<(), Failed> {
    if let Some(i) = shader.iter().position(|value| !value.is_finite()) {
        return Err(format!("{what}: value {i} of the shader is {}", shader[i]).into());
    }
    let errors = |values: &[f32]| {
        let error = |(value, exact): (&f32, &f64)| (f64::from(*value) - exact).abs() as f32;
        let mut errors: Vec<f32> = values.iter().zip(exact).map(error).collect();
        errors.sort_by(f32::total_cmp);
        errors.truncate(errors.len() - jumps);
        errors
    };
    let (shader, single) = (errors(shader), errors(single));
    super::compare(what, &shader, &single, &vec![0.0; single.len()], &[1.0])
}

pub(crate) fn prefiltered(
    spec: &TechniqueSpec,
    (blending, spacing): (Blending, Spacing),
    faults: &[&str],
) -> Result<(), Failed> {
    let technique = spec.build()?;
    let stored = StoredPrefixes { technique: &technique, blending, margin: margin(spec) };
    let (mut found, mut single, mut exact) = (Vec::new(), Vec::new(), Vec::new());
    for seen in Seen::all()? {
        let view = seen.view()?;
        let band = if faults.contains(&"no guard band") { 0.0 } else { 0.05 };
        let rectification = seen.rectification(0.05)?;
        let rectified = RectifiedMap::nearest(rectification, &view.light);
        let spacing = spacing.inverse_sines(&rectified, &seen.frustum(), &view, &seen.rays);
        let double = Prefiltered::<f64>::new(stored, &rectified, &view, &spacing)?;
        let float = Prefiltered::<f32>::new(stored, &rectified, &view, &spacing)?;
        let texels: Vec<[f32; 4]> = rectified
            .texels
            .iter()
            .map(|t| [t.depths[0], t.depths[1], t.weights[0], t.weights[1]].map(|value| value as f32))
            .collect();
        let inverse_sines: Vec<f32> = spacing.iter().flatten().map(|&value| value as f32).collect();
        let maps = spacing.len();
        let uniform = scattering_uniform(&view, &seen.rectification(band)?);
        let words = prefix_words(&technique);
        let source = faulty(prefix_map_shader(&stored, SIZE).ok_or("no shader")?, faults);
        let resources = [
            Resource::Read(bytemuck::cast_slice(&texels)),
            Resource::Write(4 * texels.len() * words * maps),
            Resource::Uniform(bytemuck::cast_slice(&uniform)),
            Resource::Read(bytemuck::cast_slice(&inverse_sines)),
        ];
        let map: Vec<u32> = compute::run(&[(&source, "prefix", (maps * SIZE[1]) as u32)], &resources, 1)?;
        if spec.format() == NumberFormat::F32 {
            let values: Vec<f32> = map.iter().map(|&word| f32::from_bits(word)).collect();
            let [a, b] = [float.map().ok_or("no map")?.data().to_vec(), values];
            let exact = double.map().ok_or("no map")?.data();
            judge(&format!("{}, prefix sums", technique.name()), &b, &a, exact, 0)?;
        }
        let rays = seen.rays_for_shader(|ray| if ray.length.is_finite() { ray.length } else { -1.0 });
        let shader = if maps > 1 { look_up_between_shader } else { look_up_shader };
        let source = faulty(shader(&stored, SIZE).ok_or("no shader")?, faults);
        let resources = [
            Resource::Read(bytemuck::cast_slice(&map)),
            Resource::Read(bytemuck::cast_slice(&rays)),
            Resource::Write(4 * rays.len()),
            Resource::Uniform(bytemuck::cast_slice(&uniform)),
            Resource::Read(bytemuck::cast_slice(&inverse_sines)),
        ];
        let groups = (rays.len() as u32).div_ceil(64);
        let shares: Vec<f32> = compute::run(&[(&source, "look_up", groups)], &resources, 2)?;
        found.extend(shares);
        for ray in &seen.rays {
            single.push(float.estimate(&view, ray)? as f32);
            exact.push(double.estimate(&view, ray)?);
        }
    }
    judge(&format!("{} in {}, lit shares", technique.name(), spec.format()), &found, &single, &exact, JUMPS)
}

/// Depths of the rectified map; a shader may fall on the next texel of the shadow map.
pub(crate) fn resample(fault: &str) -> Result<(), Failed> {
    /// Texels on the border of the shadow map's, where rounding decides: one in so many.
    const BORDER: usize = 1000;
    for seen in Seen::all()? {
        let view = seen.view()?;
        let rectification = seen.rectification(0.05)?;
        let exact = RectifiedMap::nearest(rectification, &view.light);
        let uniform = scattering_uniform(&view, &rectification);
        let source = faulty(resample_shader(SIZE), &[fault]);
        let resources = [
            Resource::Depths((seen.map.depths(), SIDE)),
            Resource::Write(16 * exact.texels.len()),
            Resource::Uniform(bytemuck::cast_slice(&uniform)),
        ];
        let groups = exact.texels.len().div_ceil(64) as u32;
        let found: Vec<[f32; 4]> = compute::run(&[(&source, "resample", groups)], &resources, 1)?;
        let error =
            |(found, exact): (&[f32; 4], &RectifiedTexel)| (f64::from(found[0]) - exact.depths[0]).abs();
        let off = found.iter().zip(&exact.texels).map(error).filter(|error| *error > 2e-5).count();
        println!("resample: {off} of {} texels differ", found.len());
        if off > found.len() / BORDER {
            return Err(format!("{off} of {} depths are off", found.len()).into());
        }
    }
    Ok(())
}

/// Mean depths of the rectified map that is resampled with a filter. Places on the map and moments are in single precision.
pub(crate) fn resample_filtered(fault: &str) -> Result<(), Failed> {
    /// Mean error, less than a code of 16 bits; of single depths a rounding of the moments is one of the square root of it.
    const MEAN: f64 = 1e-5;
    /// Texels that may err by more than a code of 16 bits, one in so many: where moments are all but those of one depth, or a
    /// depth is all but that of empty texels, rounding decides.
    const UNDECIDED: usize = 50;
    let spec = moments("hamburger4", "GDC16 four moments", NumberFormat::Unorm16, 0.0);
    let technique = spec.build()?;
    for seen in Seen::all()? {
        let view = seen.view()?;
        let rectification = seen.rectification(0.05)?;
        let stored = technique.store::<f64>(&seen.map)?;
        let depths = FilteredDepths::new(&technique, &stored)?;
        let exact = RectifiedMap::filtered(rectification, &view.light, &depths)?;
        let uniform = scattering_uniform(&view, &rectification);
        let source = faulty(resample_filtered_shader(&depths, SIZE), &[fault]);
        let levels = depths.for_shader();
        let resources = [
            Resource::Read(bytemuck::cast_slice(&levels)),
            Resource::Write(16 * exact.texels.len()),
            Resource::Uniform(bytemuck::cast_slice(&uniform)),
        ];
        let groups = exact.texels.len().div_ceil(64) as u32;
        let found: Vec<[f32; 4]> = compute::run(&[(&source, "resample_filtered", groups)], &resources, 1)?;
        let error = |(found, exact): (&[f32; 4], &RectifiedTexel)| {
            let [d, w] = [exact.depths, exact.weights];
            (f64::from(found[0] * found[2] + found[1] * found[3]) - d[0] * w[0] - d[1] * w[1]).abs()
        };
        let errors: Vec<f64> = found.iter().zip(&exact.texels).map(error).collect();
        let off = errors.iter().filter(|error| error.is_nan() || **error > 1.0 / 65535.0).count();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        println!("filtered resampling: {off} of {} texels differ, mean error {mean:.2e}", found.len());
        if off > found.len() / UNDECIDED || mean.is_nan() || mean > MEAN {
            return Err(format!("{off} of {} depths are off, by {mean:e} on average", found.len()).into());
        }
    }
    Ok(())
}

pub(crate) fn march(fault: &str) -> Result<(), Failed> {
    let method = Marched { steps: STEPS, jitter: Jitter::Ray, seed: 0 };
    for mut seen in Seen::all()? {
        seen.rays.retain(|ray| ray.length.is_finite());
        let view = seen.view()?;
        let ends: Vec<[f32; 4]> = seen.rays_for_shader(|ray| view.end(ray));
        let noise: Vec<f32> = seen.rays.iter().map(|ray| ray.noise as f32).collect();
        let uniform = scattering_uniform(&view, &seen.rectification(0.05)?);
        let source = faulty(march_shader(STEPS), &[fault]);
        let resources = [
            Resource::Depths((seen.map.depths(), SIDE)),
            Resource::Read(bytemuck::cast_slice(&ends)),
            Resource::Write(4 * ends.len()),
            Resource::Uniform(bytemuck::cast_slice(&uniform)),
            Resource::Read(bytemuck::cast_slice(&noise)),
        ];
        let groups = (ends.len() as u32).div_ceil(64);
        let found: Vec<f32> = compute::run(&[(&source, "march", groups)], &resources, 2)?;
        // Samples on the border of a texel fall to either side: a sample a ray at most, and few rays.
        let mut off = 0;
        for (ray, &share) in seen.rays.iter().zip(&found) {
            let exact = method.estimate(&view, ray)?;
            let end = view.end(ray);
            let lit = view.joined(ray, f64::from(share), end, view.is_lit_beyond(ray, end));
            off += usize::from((lit - exact).abs() > 1e-4);
        }
        println!("march: {off} of {} rays differ", found.len());
        if off > found.len() / 100 {
            return Err(format!("{off} of {} rays are off", found.len()).into());
        }
        assert!(seen.rays.iter().any(|ray| view.truth(ray) < 0.9), "nothing is shadowed");
    }
    Ok(())
}

/// Every module is valid without an adapter.
fn valid(spec: &TechniqueSpec, blending: Blending) -> Result<(), Failed> {
    let technique = spec.build()?;
    let stored = StoredPrefixes { technique: &technique, blending, margin: margin(spec) };
    let shaders = [prefix_map_shader, look_up_shader, look_up_between_shader];
    for source in shaders.map(|shader| shader(&stored, SIZE)) {
        Module::new(&source.ok_or("no shader")?)?;
    }
    Module::new(&resample_shader(SIZE))?;
    Module::new(&march_shader(STEPS))?;
    Ok(())
}
