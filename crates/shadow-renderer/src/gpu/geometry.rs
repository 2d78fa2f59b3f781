//! The triangles of a scene on the GPU: the light's depth map and what the camera sees.

use bytemuck::{Pod, Zeroable};
use graphics_device::{DeviceError, GraphicsDevice};
use scenes::Scene;
use wgpu::{BufferUsages as Usage, CompareFunction, TextureFormat as Format, TextureUsages as Uses};

use super::bind::Resource;
use super::colour::TextureBuffers;
use super::raster_pass::{Corners, Depth, RasterPass};
use super::{DEPTH_MAP, SURFACES};
use crate::frame::raster::{CameraView, flat_normal, is_hidden};
use crate::stack::fixed_point::Masks;
use crate::{LightFrame, RenderError};

/// Most bytes of corners that are sent to the device in one piece.
const PIECE_BYTES: usize = 72 << 20;

const DEPTH: Format = Format::Depth32Float;

/// Corners of the triangles that are wanted; `corner` is given the triangle and the number of one of its vertices.
fn upload<T: Pod>(
    gpu: &GraphicsDevice,
    scene: &Scene,
    wanted: impl Fn(usize) -> bool,
    corner: impl Fn(usize, usize) -> T,
) -> Vec<Corners> {
    let triangles_each = PIECE_BYTES / (3 * size_of::<T>());
    let firsts = (0..scene.triangles.len()).step_by(triangles_each);
    let corners = firsts.map(|first| {
        let last = scene.triangles.len().min(first + triangles_each);
        let triangles = (first..last).filter(|&triangle| wanted(triangle));
        let corners: Vec<T> = triangles
            .flat_map(|triangle| scene.triangles[triangle].map(|vertex| corner(triangle, vertex as usize)))
            .collect();
        (gpu.buffer_of("corners", &corners, Usage::VERTEX), corners.len() as u32)
    });
    corners.collect()
}

/// The alpha masks of a scene.
pub(super) struct MaskBuffers {
    entries: wgpu::Buffer,
    bits: wgpu::Buffer,
}

impl MaskBuffers {
    pub(super) fn upload(gpu: &GraphicsDevice, masks: &Masks) -> Self {
        let entries: Vec<[u32; 3]> = masks.entries.iter().map(|e| [e.width, e.height, e.first_bit]).collect();
        Self {
            entries: gpu.buffer_of("masks", &entries, Usage::STORAGE),
            bits: gpu.buffer_of("mask bits", &masks.bits, Usage::STORAGE),
        }
    }

    fn with<'a>(&'a self, name: &'a str, buffer: &'a wgpu::Buffer) -> [Resource<'a>; 3] {
        [("masks", &self.entries), ("mask_bits", &self.bits), (name, buffer)]
            .map(|(name, buffer)| (name, buffer.as_entire_binding()))
    }
}

/// Nearest depths as the light sees them.
pub(super) struct LightPass {
    pub pass: RasterPass,
    pub depths: wgpu::TextureView,
    shift: wgpu::Buffer,
}

/// A vertex of depth_map.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct LightCorner {
    position: [f32; 3],
    uv: [f32; 2],
    mask: u32,
}

impl LightPass {
    /// With so many samples a texel.
    pub(super) fn new(
        gpu: &GraphicsDevice,
        scene: &Scene,
        (masks, buffers): (&Masks, &MaskBuffers),
        frame: &LightFrame,
        samples: u32,
    ) -> Result<Self, DeviceError> {
        let corner = |triangle: usize, index: usize| {
            let vertex = &scene.vertices[index];
            let mask = masks.of_material[scene.triangle_material[triangle] as usize];
            let [x, y, depth] = frame.project(vertex.position.map(f64::from));
            let across = 2.0 * x / f64::from(frame.width) - 1.0;
            let down = 2.0 * y / f64::from(frame.height) - 1.0;
            LightCorner { position: [across as f32, -down as f32, depth as f32], uv: vertex.uv, mask }
        };
        let corners = upload(gpu, scene, |_| true, corner);
        let size = (frame.width, frame.height);
        let usage = Uses::RENDER_ATTACHMENT | Uses::TEXTURE_BINDING;
        let depths = gpu.texture(DEPTH, size, 1, samples, usage).create_view(&Default::default());
        let shift = gpu.buffer_of("shift", &[0.0f32; 4], Usage::UNIFORM);
        let depth = Depth { view: depths.clone(), compare: CompareFunction::Less, clear: 1.0 };
        let resources = buffers.with("shift", &shift);
        let pass = RasterPass::new(gpu, DEPTH_MAP, &resources, corners, Vec::new(), Some(depth))?;
        Ok(Self { pass, depths, shift })
    }

    /// Moves the samples of the next submitted pass from the texels' centres by so many texels.
    pub(super) fn shift(&self, gpu: &GraphicsDevice, offset: [f32; 2]) {
        let texture = self.depths.texture();
        let (width, height) = (texture.width() as f32, texture.height() as f32);
        let shift = [-2.0 * offset[0] / width, 2.0 * offset[1] / height, 0.0, 0.0];
        gpu.queue.write_buffer(&self.shift, 0, bytemuck::cast_slice(&shift));
    }
}

/// Sizes of the corners that depth_map.wgsl and surfaces.wgsl read.
#[cfg(test)]
pub(super) const CORNER_BYTES: [usize; 2] = [size_of::<LightCorner>(), size_of::<SurfaceCorner>()];

/// A scene's triangles as the camera needs them.
pub(super) struct Geometry {
    corners: Vec<Corners>,
    masks: Masks,
    buffers: MaskBuffers,
    textures: TextureBuffers,
}

/// A vertex of surfaces.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SurfaceCorner {
    position: [f32; 3],
    normal: [f32; 3],
    albedo: [f32; 3],
    uv: [f32; 2],
    mask: u32,
    texture: u32,
}

/// Positions, normals and albedos of what the camera sees.
pub(super) type Surfaces = [wgpu::TextureView; 3];

impl Geometry {
    pub(super) fn upload(gpu: &GraphicsDevice, scene: &Scene) -> Result<Self, RenderError> {
        let masks = Masks::new(scene)?;
        let textures = TextureBuffers::upload(gpu, scene);
        let corner = |triangle: usize, index: usize| {
            let (vertex, number) = (&scene.vertices[index], scene.triangle_material[triangle]);
            let tint = scene.colors.get(index).copied().unwrap_or([1.0; 4]);
            let material = &scene.materials[number as usize];
            let normal = if vertex.normal == [0.0; 3] { flat_normal(scene, triangle) } else { vertex.normal };
            SurfaceCorner {
                position: vertex.position,
                normal,
                albedo: [0, 1, 2].map(|k| material.factor[k] * tint[k]),
                uv: vertex.uv,
                mask: masks.of_material[number as usize],
                texture: textures.of_material(number),
            }
        };
        let corners = upload(gpu, scene, |triangle| !is_hidden(scene, scene.camera.eye, triangle), corner);
        let buffers = MaskBuffers::upload(gpu, &masks);
        Ok(Self { corners, masks, buffers, textures })
    }

    /// The light's depth map with so many samples.
    pub(super) fn light_pass(
        &self,
        gpu: &GraphicsDevice,
        scene: &Scene,
        light: &LightFrame,
        samples: u32,
    ) -> Result<LightPass, DeviceError> {
        LightPass::new(gpu, scene, (&self.masks, &self.buffers), light, samples)
    }

    /// What the camera sees in a picture of some size, and the pass that makes it.
    pub(super) fn surfaces(
        &self,
        gpu: &GraphicsDevice,
        scene: &Scene,
        (width, height): (u32, u32),
    ) -> Result<(RasterPass, Surfaces), RenderError> {
        let target = |format: Format, more: Uses| {
            let texture = gpu.texture(format, (width, height), 1, 1, Uses::RENDER_ATTACHMENT | more);
            texture.create_view(&Default::default())
        };
        // Albedo is linear to the shaders that write and read it, and its dark shades need the bits.
        let surfaces = [Format::Rgba32Float, Format::Rgba16Float, Format::Rgba8UnormSrgb]
            .map(|format| target(format, Uses::TEXTURE_BINDING));
        // Depth is reversed: 1 at the near plane, 0 at infinity.
        let view = target(DEPTH, Uses::empty());
        let depth = Depth { view, compare: CompareFunction::Greater, clear: 0.0 };
        let rows = CameraView::new(&scene.camera, width, height)?.clip_rows();
        let camera = gpu.buffer_of("camera", &rows, Usage::UNIFORM);
        let mut resources = self.buffers.with("camera", &camera).to_vec();
        resources.extend(self.textures.resources());
        let (corners, colours) = (self.corners.clone(), surfaces.to_vec());
        let pass = RasterPass::new(gpu, SURFACES, &resources, corners, colours, Some(depth))?;
        Ok((pass, surfaces))
    }
}
