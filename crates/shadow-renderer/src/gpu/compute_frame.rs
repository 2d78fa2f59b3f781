//! The passes of a frame after rasterisation as compute shaders: the same maps, by tiles in workgroup memory, and levels of
//! the pyramid several at a time.

use std::slice::from_ref;

use graphics_device::{DeviceError, GraphicsDevice, PassTimer};
use shaders::ComputeShaders;
use wgpu::{BindingResource, TextureFormat as Format, TextureUsages as Uses, TextureView};

use super::bind::Resource;
use super::compute_shader::ComputeShader;
use super::filter_chain::{level, levels, map_resources, textures};
use super::frame_renderer::{FrameSettings, Route, Stamps};

/// A shader with what it reads and writes.
struct Dispatch {
    shader: ComputeShader,
    bound: wgpu::BindGroup,
    groups: [u32; 2],
}

/// From samples of depth to the filtered map with its mip levels.
pub(super) struct ComputeMaps {
    resolve: Dispatch,
    rows: Dispatch,
    columns: Dispatch,
    levels: Vec<Dispatch>,
    /// The filtered maps, with all levels.
    pub maps: Vec<wgpu::Texture>,
}

/// Deferred shading.
pub(super) struct ComputeShading {
    dispatch: Dispatch,
    pub colour: wgpu::Texture,
    pub shadow: wgpu::Texture,
}

impl Dispatch {
    fn new(
        gpu: &GraphicsDevice,
        (source, route): (&str, Route),
        resources: &[Resource<'_>],
        threads: [u32; 2],
    ) -> Result<Self, DeviceError> {
        let shader = match route {
            Route::Fragment | Route::Compute => ComputeShader::only(gpu, source)?,
            // SAFETY: texels are clamped to their textures or compared with their sizes, tiles are walked by constant bounds,
            // arrays are indexed by constants, and every loop counts to a constant.
            Route::Unchecked => unsafe { ComputeShader::only_unchecked(gpu, source)? },
        };
        let (bound, groups) = (shader.bound(gpu, resources)?, shader.groups_of(threads));
        Ok(Self { shader, bound, groups })
    }

    fn run(&self, encoder: &mut wgpu::CommandEncoder, stamp: Option<wgpu::ComputePassTimestampWrites<'_>>) {
        self.shader.run(encoder, &self.bound, self.groups, stamp);
    }
}

/// The storage textures of consecutive levels under the names that shaders give them.
fn targets(views: &[Vec<TextureView>]) -> Vec<Resource<'_>> {
    const NAMES: [[&str; 2]; 4] =
        [["out0_0", "out0_1"], ["out1_0", "out1_1"], ["out2_0", "out2_1"], ["out3_0", "out3_1"]];
    let levels = NAMES.iter().zip(views);
    let named = levels.flat_map(|(names, views)| names.iter().zip(views));
    named.map(|(&name, view)| (name, BindingResource::TextureView(view))).collect()
}

impl ComputeMaps {
    pub(super) fn new(
        gpu: &GraphicsDevice,
        shaders: &ComputeShaders,
        formats: &[Format],
        settings: &FrameSettings,
        depths: &TextureView,
    ) -> Result<Self, DeviceError> {
        let [maps, between] = textures(gpu, formats, settings, Uses::STORAGE_BINDING)?;
        let dispatch = |source: &str, from: &[TextureView], to: &[Vec<TextureView>], side: u32| {
            let mut resources = map_resources(from);
            resources.push(("depths", BindingResource::TextureView(depths)));
            resources.extend(targets(to));
            Dispatch::new(gpu, (source, settings.route), &resources, [side; 2])
        };
        let (first, other) = (level(&maps, 0), level(&between, 0));
        let side = settings.map_size;
        let mut made = 1;
        let mut passes = Vec::new();
        while made < levels(settings) {
            let count = (levels(settings) - made).min(shaders.halve.len() as u32);
            let to: Vec<Vec<TextureView>> = (made..made + count).map(|l| level(&maps, l)).collect();
            let source = &shaders.halve[count as usize - 1];
            passes.push(dispatch(source, &level(&maps, made - 1), &to, side >> made)?);
            made += count;
        }
        Ok(Self {
            resolve: dispatch(&shaders.resolve, &[], from_ref(&first), side)?,
            rows: dispatch(&shaders.rows, &first, from_ref(&other), side)?,
            columns: dispatch(&shaders.columns, &other, from_ref(&first), side)?,
            levels: passes,
            maps,
        })
    }

    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, stamps: &mut Stamps<'_>) {
        for (name, pass) in
            [("resolve", &self.resolve), ("filter rows", &self.rows), ("filter columns", &self.columns)]
        {
            let pass_number = stamps.next(name);
            pass.run(encoder, stamps.timer.map(|timer| timer.compute_writes(pass_number)));
        }
        if !self.levels.is_empty() {
            let number = stamps.next("mip maps");
            for (part, level) in self.levels.iter().enumerate() {
                let count = self.levels.len();
                level.run(
                    encoder,
                    stamps.timer.and_then(|timer: &PassTimer| timer.compute_part(number, part, count)),
                );
            }
        }
    }
}

impl ComputeShading {
    pub(super) fn new(
        gpu: &GraphicsDevice,
        (source, route): (&str, Route),
        read: Vec<Resource<'_>>,
        (width, height): (u32, u32),
    ) -> Result<Self, DeviceError> {
        let usage = Uses::STORAGE_BINDING | Uses::COPY_SRC;
        let [colour, shadow] = [Format::Rgba8Unorm, Format::R32Float]
            .map(|format| gpu.texture(format, (width, height), 1, 1, usage));
        let views = [&colour, &shadow].map(|texture| texture.create_view(&Default::default()));
        let named = ["colour", "shadow"].into_iter().zip(views.iter().map(BindingResource::TextureView));
        let resources: Vec<Resource<'_>> = read.into_iter().chain(named).collect();
        let dispatch = Dispatch::new(gpu, (source, route), &resources, [width, height])?;
        Ok(Self { dispatch, colour, shadow })
    }

    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, stamps: &mut Stamps<'_>) {
        let number = stamps.next("shade");
        self.dispatch.run(encoder, stamps.timer.map(|timer| timer.compute_writes(number)));
    }
}
