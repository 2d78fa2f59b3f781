//! The one entry: a scene and a light to a stack, on the CPU or the GPU.

use std::time::Instant;

use graphics_device::{AdapterName, GraphicsDevice};
use scenes::{LightView, Scene};

use crate::gpu::{ABuffer, BINDING_BYTES, ChunkSizes};
use crate::stack::assemble::{Band, assemble};
use crate::stack::memory::{self, Budget};
use crate::stack::prepare::PreparedTriangles;
use crate::stack::rasterize::{BandTimes, rasterize};
use crate::stack::stage_times::StageTimes;
use crate::stack::veils::{Casters, Spectrum};
use crate::{LightFrame, RenderError, ShadowMapStack};

/// Who renders. Every backend returns the same stack, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The rasteriser on the CPU, in parallel.
    Cpu,
    /// Any graphics adapter, software ones included.
    Gpu,
    /// A graphics adapter, unless it is a software one.
    #[default]
    Auto,
}

/// How a stack came about.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderReport {
    /// Frame in which texels and depths are meant.
    pub frame: LightFrame,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Triangles dropped because their area is zero after snapping.
    pub degenerate_triangles: usize,
    /// Triangles that cover no texel centre by their bounds.
    pub uncovering_triangles: usize,
    /// Fragments of the stack.
    pub fragments: usize,
    /// The adapter, where a GPU rendered; `None` for the CPU.
    pub adapter: Option<AdapterName>,
    /// Why the CPU rendered although a GPU was asked for.
    pub fallback: Option<String>,
    /// Times of the steps.
    pub times: StageTimes,
}

/// Renders the stack of `scene` for a directional light travelling along `direction`, fitted by [`LightFrame::fit`].
///
/// A GPU that is missing, fails or has too little memory is replaced by the CPU; the report says why.
///
/// # Errors
/// As [`LightFrame::fit`] and [`render_in_frame`].
///
/// ```
/// use scenes::{Camera, LightView, Material, Scene, Vertex};
/// use shadow_renderer::*;
/// let corner = |x, z| Vertex { position: [x, 0.0, z], normal: [0.0, 1.0, 0.0], uv: [0.0; 2] };
/// let ground = Scene {
///     name: "ground".into(),
///     vertices: vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0)],
///     triangles: vec![[0, 1, 2]],
///     triangle_material: vec![0],
///     materials: vec![Material::plain("grey", [0.5; 3])],
///     views: vec![LightView::directional("noon", [0.0, -1.0, 0.0])],
///     camera: Camera::new([2.0; 3], [0.0; 3], 1.0),
///     ..Scene::default()
/// };
/// let (stack, report) = render_stack(&ground, [0.0, -1.0, 0.0], 64, 64, Backend::Cpu)?;
/// assert_eq!(stack.layer_statistics().max, 1);
/// assert!(stack.light_facing.iter().all(|facing| facing));
/// assert_eq!(report.fragments, stack.fragments());
/// # Ok::<(), RenderError>(())
/// ```
pub fn render_stack(
    scene: &Scene,
    direction: [f32; 3],
    width: u32,
    height: u32,
    backend: Backend,
) -> Result<(ShadowMapStack, RenderReport), RenderError> {
    render_view(scene, &LightView::directional("light", direction), width, height, backend)
}

/// Renders the stack of `scene` as the light of a view sees it from its middle, fitted by [`LightFrame::of_view`].
///
/// # Errors
/// As [`LightFrame::of_view`] and [`render_in_frame`].
pub fn render_view(
    scene: &Scene,
    view: &LightView,
    width: u32,
    height: u32,
    backend: Backend,
) -> Result<(ShadowMapStack, RenderReport), RenderError> {
    let start = Instant::now();
    let frame = LightFrame::of_view(scene, view, width, height)?;
    // Fitting has checked scene and size.
    let prepared = PreparedTriangles::of_checked(scene, &frame, Casters::Opaque)?;
    render_timed(scene, &frame, prepared, (backend, BINDING_BYTES), start).map(opaque)
}

/// Without the triangles of fragments, which only stacks with opacities have.
fn opaque((translucent, report): (TranslucentStack, RenderReport)) -> (ShadowMapStack, RenderReport) {
    (translucent.stack, report)
}

/// A stack whose surfaces let light through.
#[derive(Clone, Debug, PartialEq)]
pub struct TranslucentStack {
    /// With opacities; fragments that are clear are left out.
    pub stack: ShadowMapStack,
    /// The scene's triangle that each fragment is of; empty where all opacities are 1.
    pub triangles: Vec<u32>,
}

/// As [`render_in_frame`], with the opacity that surfaces have in one kind of light in place of a test at one half.
///
/// # Errors
/// As [`render_in_frame`]; [`RenderError::Scene`] for opacities outside of \[0, 1\].
pub fn render_translucent(
    scene: &Scene,
    frame: &LightFrame,
    spectrum: Spectrum,
    backend: Backend,
) -> Result<(TranslucentStack, RenderReport), RenderError> {
    let start = Instant::now();
    let prepared = PreparedTriangles::of_casters(scene, frame, Casters::Translucent(spectrum))?;
    render_timed(scene, frame, prepared, (backend, BINDING_BYTES), start)
}

/// Renders the stack of `scene` in a light frame of the caller's choice; triangles may lie off the map and depths
/// are clamped to [0, 1]. With a frame in perspective what lies before its near plane is cut off.
///
/// # Errors
/// [`RenderError::Scene`], [`RenderError::MapSize`], [`RenderError::GuardBand`] if a vertex lies over 16384 texels off under a directional light, and [`RenderError::TooManyFragments`] or [`RenderError::OutOfMemory`] for a
/// stack that 32-bit offsets or the memory cannot hold, estimated before anything large is allocated and checked
/// exactly on the way.
pub fn render_in_frame(
    scene: &Scene,
    frame: &LightFrame,
    backend: Backend,
) -> Result<(ShadowMapStack, RenderReport), RenderError> {
    render_in_chunks(scene, frame, backend, BINDING_BYTES)
}

/// As [`render_in_frame`], with the GPU's work cut into pieces for storage bindings of at most `binding_bytes` bytes
/// instead of [`BINDING_BYTES`], which is also the most that is used. The stack does not depend on it.
///
/// # Errors
/// As [`render_in_frame`].
pub fn render_in_chunks(
    scene: &Scene,
    frame: &LightFrame,
    backend: Backend,
    binding_bytes: u64,
) -> Result<(ShadowMapStack, RenderReport), RenderError> {
    let start = Instant::now();
    let prepared = PreparedTriangles::new(scene, frame)?;
    render_timed(scene, frame, prepared, (backend, binding_bytes), start).map(opaque)
}

fn render_timed(
    scene: &Scene,
    frame: &LightFrame,
    prepared: PreparedTriangles,
    (backend, binding_bytes): (Backend, u64),
    start: Instant,
) -> Result<(TranslucentStack, RenderReport), RenderError> {
    let budget = Budget::new(&prepared, memory::available())?;
    let mut times = StageTimes { prepare: start.elapsed(), ..StageTimes::default() };
    let (mut adapter, mut fallback) = (None, None);
    let mut on_gpu: Option<Vec<Band>> = None;
    if backend != Backend::Cpu {
        match extract_on_gpu(&prepared, (backend, binding_bytes), &budget, &mut times)? {
            Attempt::Rendered(bands, name) => (on_gpu, adapter) = (Some(bands), Some(name)),
            Attempt::Refused(reason) => fallback = Some(reason),
        }
    }
    let bands = match on_gpu {
        Some(bands) => bands,
        None => rasterize_timed(&prepared, &budget, &mut times)?,
    };
    let assembling = Instant::now();
    let (degenerate_triangles, uncovering_triangles) = (prepared.degenerate(), prepared.uncovering());
    let (stack, triangles) = assemble(prepared, bands)?;
    times.assemble = assembling.elapsed();
    times.total = start.elapsed();
    let report = RenderReport {
        frame: *frame,
        triangles: scene.triangles.len(),
        degenerate_triangles,
        uncovering_triangles,
        fragments: stack.fragments(),
        adapter,
        fallback,
        times,
    };
    Ok((TranslucentStack { stack, triangles }, report))
}

fn rasterize_timed(
    prepared: &PreparedTriangles,
    budget: &Budget,
    times: &mut StageTimes,
) -> Result<Vec<Band>, RenderError> {
    let inside = BandTimes::default();
    let bands = rasterize(prepared, budget, &inside)?;
    (times.raster, times.group, times.sort) = (inside.raster(), inside.group(), inside.sort());
    Ok(bands)
}

/// What came of using the GPU.
enum Attempt {
    /// The fragments and who found them.
    Rendered(Vec<Band>, AdapterName),
    /// The reason to use the CPU.
    Refused(String),
}

/// Errors are those that the CPU would share.
fn extract_on_gpu(
    prepared: &PreparedTriangles,
    (backend, binding_bytes): (Backend, u64),
    budget: &Budget,
    times: &mut StageTimes,
) -> Result<Attempt, RenderError> {
    let opening = Instant::now();
    let gpu = match GraphicsDevice::shared() {
        Ok(gpu) => gpu,
        Err(reason) => return Ok(Attempt::Refused(reason.to_string())),
    };
    if backend == Backend::Auto && gpu.software {
        return Ok(Attempt::Refused(format!("only a software adapter: {}", gpu.name)));
    }
    let sizes = ChunkSizes::for_bindings(binding_bytes.min(BINDING_BYTES));
    let extracted = ABuffer::shared().map_err(RenderError::Gpu).and_then(|abuffer| {
        times.device = opening.elapsed();
        abuffer.extract(prepared, budget, sizes, times)
    });
    match extracted {
        Ok(bands) => Ok(Attempt::Rendered(bands, gpu.name.clone())),
        Err(RenderError::Gpu(reason)) => Ok(Attempt::Refused(format!("{}: {reason}", gpu.name))),
        Err(error) => Err(error),
    }
}
