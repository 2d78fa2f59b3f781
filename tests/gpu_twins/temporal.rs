//! The compute passes of soft shadows over time against their Rust twin: eight frames of an orbit through each of three scenes,
//! every frame on the buffer that the passes left of the one before, against double precision.

use std::sync::OnceLock;

use super::adapter::gpu_trial;
use super::compute::{self, Resource};
use super::scattering::{faulty, judge};
use applications::PlacedLight;
use applications::rays::Triangles;
use applications::samples::{HALTON_START, PoissonTaps, TapShape, halton};
use applications::temporal::{
    FilterSource, FramePixel, MovingCasters, Screen, Shaded, ShadowBuffer, Start, TemporalMethod,
    buffer_words, pixel_for_shader, screen_uniform, smooth_shader, start_for_shader, update_shader,
};
use libtest_mimic::{Failed, Trial};
use moment_problem::arithmetic::Real;
use quantization::NumberFormat;
use random_stream::Random;
use scenes::vector::{dot, minus};
use scenes::{CameraPath, Movement, load_scene};
use shaders::Module;
use shadow_renderer::{CameraView, Frame, LightFrame, NO_TRIANGLE};

const SIZE: [u32; 2] = [160, 120];
const FRAMES: usize = 8;
const SCENES: [&str; 3] = ["stairs", "village", "grove"];
const SCREEN: Screen = Screen { light_size: 0.5, pixels_per_unit: 150.0 };

/// One answer in so many is left out on both sides: places on the border of a pixel and depths on that of a tolerance fall to
/// either side, and any rounding decides.
const JUMPS: usize = 1000;

/// One caster in so many counts as moving, and shifts what it leaves behind by so many pixels.
const MOVING: u32 = 40;
const SHIFT: f64 = 1.3;

/// How far before the surface rays start, a share of their length.
const LIFT: f64 = 1e-4;

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, method) in methods() {
        let of = method.clone();
        trials.push(Trial::test(format!("wgsl::temporal::{name}"), move || valid(&of)));
        trials.push(gpu_trial(format!("temporal::{name}"), move || twins(&method, SCENES.len(), "")));
    }
    trials.push(gpu_trial("temporal::planted_faults".into(), planted_faults));
    trials
}

fn methods() -> Vec<(&'static str, TemporalMethod)> {
    let published = TemporalMethod::published();
    let single = TemporalMethod { format: NumberFormat::F32, ..published.clone() };
    let mended = TemporalMethod {
        cautious: true,
        blockers_only: true,
        filter: FilterSource::Current,
        interpolated: true,
        moving: MovingCasters::Search,
        follow: true,
        exact: true,
        ..single.clone()
    };
    let alone = TemporalMethod { start_tests: 0.0, filter: FilterSource::Off, ..single.clone() };
    let capped =
        TemporalMethod { start_tests: 1.0, most_tests: 4.0, interpolated: true, ..published.clone() };
    vec![
        ("published", published),
        ("single", single),
        ("mended", mended.clone()),
        ("mended_half", TemporalMethod { format: NumberFormat::F16, ..mended }),
        ("alone", alone),
        ("capped", capped),
    ]
}

fn taps() -> PoissonTaps {
    PoissonTaps::new(TapShape::Disc, 16, 1, 0)
}

/// Pixels of a frame and what percentage-closer soft shadows say of them.
type Seen = (Vec<Option<FramePixel<f32>>>, Vec<Start<f32>>);

fn frames() -> &'static [Vec<Seen>] {
    static SEEN: OnceLock<Vec<Vec<Seen>>> = OnceLock::new();
    SEEN.get_or_init(|| SCENES.iter().map(|scene| seen(scene).expect("a procedural scene")).collect())
}

/// An orbit around a scene under its lamp, a point of it a frame.
fn seen(name: &str) -> Result<Vec<Seen>, Failed> {
    let mut scene = load_scene(name)?;
    let triangles = Triangles::of_scene(&scene)?;
    let view = scene.views.iter().find(|view| view.name == "lamp").ok_or("no lamp")?;
    let frame = LightFrame::of_view(&scene, view, 256, 256)?;
    let light = PlacedLight::new(&view.light, [frame.right, frame.down, frame.forward]);
    let from_light = |point: [f64; 3]| dot(minus(point, light.middle), frame.forward);
    let path = CameraPath { movement: Movement::Orbit, degrees: 1.0, zoom: 1.0, frames: FRAMES };
    let first = scene.camera;
    let mut random = Random::new(3);
    let [width, height] = SIZE;
    let mut last: Option<CameraView> = None;
    let mut all = Vec::new();
    for number in 0..FRAMES {
        scene.camera = path.camera(&first, number);
        let shown = Frame::render(&scene, width, height)?;
        let view = CameraView::new(&scene.camera, width, height)?;
        let point = halton(HALTON_START + number as u64);
        let mut one = |(position, &triangle): (&[f32; 3], &u32)| {
            let position = position.map(f64::from);
            if triangle == NO_TRIANGLE || from_light(position) <= 0.0 {
                return (None, Start::default());
            }
            let receiver = from_light(position);
            let towards = light.towards(position, point);
            // From the light, so that the first surface is what a map sees.
            let start = [0, 1, 2].map(|k| position[k] + towards[k]);
            let hit = triangles.first(start, towards.map(|c| -c), false);
            let (share, caster) = hit.unwrap_or((1.0, triangle));
            let in_shadow = share < 1.0 - LIFT;
            let blocker = if in_shadow { share * receiver } else { receiver };
            let [x, y, depth] = view.project(position);
            let before = last.as_ref().map_or([x, y, depth], |last| last.project(position));
            let moving = in_shadow && caster % MOVING == 0;
            let single = |place: [f64; 3]| place.map(|c| c as f32);
            let pixel = FramePixel {
                depth: depth as f32,
                before: single(before),
                followed: single([before[0] + if moving { SHIFT } else { 0.0 }, before[1], before[2]]),
                receiver: receiver as f32,
                in_shadow,
                hidden: in_shadow != (random.below(20) == 0),
                map_distance: blocker as f32,
                moving,
            };
            let fraction = random.below(17) as f32 / 16.0;
            let blocker = (fraction > 0.0).then(|| ((0.4 + 0.5 * random.unit()) * receiver) as f32);
            (Some(pixel), Start { fraction, blocker, moving })
        };
        all.push(shown.position.iter().zip(&shown.triangle).map(&mut one).unzip());
        last = Some(view);
    }
    Ok(all)
}

fn cast<R: Real>(pixel: &FramePixel<f32>) -> FramePixel<R> {
    let of = |value: f32| R::from_f64(f64::from(value));
    FramePixel {
        depth: of(pixel.depth),
        before: pixel.before.map(of),
        followed: pixel.followed.map(of),
        receiver: of(pixel.receiver),
        in_shadow: pixel.in_shadow,
        hidden: pixel.hidden,
        map_distance: of(pixel.map_distance),
        moving: pixel.moving,
    }
}

/// Shadows and standard errors of all frames, 0 without a surface.
fn shadows<R: Real + Send + Sync>(method: &TemporalMethod, frames: &[Seen]) -> Vec<R> {
    let of = |value: f32| R::from_f64(f64::from(value));
    let mut buffer = ShadowBuffer::empty(SIZE[0] as usize, SIZE[1] as usize);
    let mut all = Vec::new();
    for (pixels, starts) in frames {
        let pixels: Vec<Option<FramePixel<R>>> = pixels.iter().map(|p| p.as_ref().map(cast)).collect();
        let start = |i: usize, _: bool| {
            let Start { fraction, blocker, moving } = starts[i];
            Start { fraction: of(fraction), blocker: blocker.map(of), moving }
        };
        let (next, shaded) = method.frame(&buffer, &pixels, &SCREEN, &taps(), &start);
        let of = |shaded: &Option<Shaded<R>>| {
            shaded.map_or([R::zero(); 2], |shaded| [shaded.shadow, shaded.standard_error])
        };
        all.extend(shaded.iter().flat_map(of));
        buffer = next;
    }
    all
}

/// The same by shaders.
fn shaded(method: &TemporalMethod, frames: &[Seen], fault: &str) -> Result<Vec<f32>, Failed> {
    let update = faulty(update_shader(method).ok_or("no shader")?, &[fault]);
    let smooth = faulty(smooth_shader(method, &taps()).ok_or("no shader")?, &[fault]);
    let screen = screen_uniform(&SCREEN, SIZE);
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let bytes = 4 * pixels * buffer_words(method).ok_or("no buffer")?;
    let mut before = vec![0u8; bytes];
    let mut all = Vec::new();
    for (seen, starts) in frames {
        let seen: Vec<[f32; 8]> = seen.iter().map(|pixel| pixel_for_shader(method, pixel.as_ref())).collect();
        let starts: Vec<[f32; 4]> = starts.iter().map(start_for_shader).collect();
        let groups = compute::groups(pixels);
        let resources = [
            Resource::Read(&before),
            Resource::Write(bytes),
            Resource::Read(bytemuck::cast_slice(&seen)),
            Resource::Read(bytemuck::cast_slice(&starts)),
            Resource::Write(16 * pixels),
            Resource::Uniform(bytemuck::cast_slice(&screen)),
        ];
        let [after, shown] = [1, 4].map(|read| -> Result<Vec<u8>, Failed> {
            Ok(compute::run(&[(&update, "update", groups)], &resources, read)?)
        });
        let (after, shown) = (after?, shown?);
        let resources = [
            Resource::Read(&before),
            Resource::Read(&after),
            Resource::Read(bytemuck::cast_slice(&seen)),
            Resource::Read(&shown),
            Resource::Uniform(bytemuck::cast_slice(&screen)),
            Resource::Write(4 * pixels),
        ];
        let shadows = compute::run::<f32>(&[(&smooth, "smooth_shadows", groups)], &resources, 5)?;
        let errors = bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&shown);
        all.extend(shadows.iter().zip(&errors).flat_map(|(&shadow, shown)| [shadow, shown[1]]));
        before = after;
    }
    Ok(all)
}

fn twins(method: &TemporalMethod, scenes: usize, fault: &str) -> Result<(), Failed> {
    let (mut found, mut single, mut exact) = (Vec::new(), Vec::new(), Vec::new());
    for frames in &frames()[..scenes] {
        found.extend(shaded(method, frames, fault)?);
        single.extend(shadows::<f32>(method, frames));
        exact.extend(shadows::<f64>(method, frames));
    }
    let what = format!("buffer in {}, {} values", method.format, found.len());
    judge(&what, &found, &single, &exact, found.len() / JUMPS)
}

/// Every module is valid without an adapter.
fn valid(method: &TemporalMethod) -> Result<(), Failed> {
    Module::new(&update_shader(method).ok_or("no shader")?)?.entry_point("update")?;
    Module::new(&smooth_shader(method, &taps()).ok_or("no shader")?)?.entry_point("smooth_shadows")?;
    Ok(())
}

/// No depth test, the wrong n, the last frame half a pixel off, neighbours at any depth, and more.
const FAULTS_OF_PUBLISHED: [&str; 7] = [
    "abs(depth - history.depth) < tolerance=>true",
    "next.tests = next.tests + 1.0=>next.tests = next.tests + 2.0",
    "/ freedom, freedom=>/ history.tests, freedom",
    "unpack2x16float(words[1])=>unpack2x16float(words[0])",
    "place = pixel.before.xyz=>place = place",
    "disturbed = is_flagged(pixel, MOVING)=>disturbed = false",
    "DEPTH_RANGE * place.z=>place.z",
];

const FAULTS_OF_MENDED: [&str; 7] = [
    "place.xy - 0.5 - corner=>place.xy - corner",
    "select(neighbour.tests, neighbour.shadowed, BLOCKERS_ONLY)=>1.0",
    "(history.shadowed + 1.0) / count=>history.shadowed / count",
    "disturbed = start.z > 0.0=>disturbed = false",
    "(already * next.blocker + added * pixel.map_distance)=>(already * next.blocker)",
    "* screen.pixels_per_unit / pixel.depth=>* screen.pixels_per_unit / pixel.receiver",
    "select(IN_SHADOW, HIDDEN, EXACT)=>IN_SHADOW",
];

fn planted_faults() -> Result<(), Failed> {
    let methods = methods();
    for (method, faults) in [(&methods[0].1, FAULTS_OF_PUBLISHED), (&methods[2].1, FAULTS_OF_MENDED)] {
        let sources = [update_shader(method), smooth_shader(method, &taps())];
        for fault in faults {
            let (from, _) = fault.split_once("=>").ok_or("no fault")?;
            assert!(sources.iter().flatten().any(|source| source.contains(from)), "`{from}` is in no shader");
            if twins(method, 1, fault).is_ok() {
                return Err(format!("the comparison missed `{fault}`").into());
            }
        }
    }
    Ok(())
}
