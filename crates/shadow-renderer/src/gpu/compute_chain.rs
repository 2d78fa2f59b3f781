//! Compute passes over shared buffers with a timestamp around each. The shaders come from outside, as WGSL.

use std::time::{Duration, Instant};

use bytemuck::Pod;
use graphics_device::{AdapterName, DeviceError, GraphicsDevice, PassTimer};
use wgpu::{BindingResource, BufferUsages, TextureFormat, TextureUsages};

use super::bind::Resource;
use super::compute_shader::ComputeShader;
use super::frame_renderer::{PassTimes, WHOLE_FRAME};

/// Most passes of a chain.
const PASSES: u32 = 16;

/// Most workgroups along an axis, which every adapter offers.
const GROUPS: u32 = 65_535;

/// What a name stands for in shaders.
#[derive(Clone, Copy, Debug)]
pub enum Content<'a> {
    /// A storage buffer.
    Bytes(&'a [u8]),
    /// A storage buffer of so many bytes, empty at first.
    Empty(u64),
    /// A uniform.
    Uniform(&'a [u8]),
    /// Depths row by row, as a texture of single floats.
    Depths {
        /// All rows.
        depths: &'a [f32],
        /// Texels of a row.
        width: u32,
    },
}

/// An entry point of a WGSL module.
#[derive(Clone, Copy, Debug)]
pub struct ComputePass<'a> {
    /// What its times are called.
    pub name: &'static str,
    /// Module.
    pub source: &'a str,
    /// Entry point.
    pub entry: &'a str,
    /// Workgroups; more than 65 535 are spread over y, too, a few idle ones included.
    pub groups: u32,
}

enum Held {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
}

/// A device of its own with named resources that passes share.
pub struct ComputeChain {
    gpu: GraphicsDevice,
    held: Vec<(String, Held)>,
}

impl ComputeChain {
    /// Opens the best adapter, with buffers as large as it allows.
    ///
    /// # Errors
    /// [`DeviceError::NoAdapter`].
    pub fn open() -> Result<Self, DeviceError> {
        let gpu = GraphicsDevice::open_whole(wgpu::Features::TIMESTAMP_QUERY)?;
        Ok(Self { gpu, held: Vec::new() })
    }

    /// What it runs on.
    pub fn adapter(&self) -> &AdapterName {
        &self.gpu.name
    }

    /// Names a resource; one that had the name before goes first, so that both need not fit.
    ///
    /// # Errors
    /// [`DeviceError`] for one that is too large for the device.
    pub fn put(&mut self, name: &str, content: Content<'_>) -> Result<(), DeviceError> {
        self.held.retain(|(held, _)| held != name);
        let gpu = &self.gpu;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let held = gpu.watched(|| {
            Ok::<_, DeviceError>(match content {
                Content::Bytes(bytes) => Held::Buffer(gpu.buffer_of(name, bytes, storage)),
                Content::Empty(bytes) => Held::Buffer(gpu.buffer(name, bytes, storage)),
                Content::Uniform(bytes) => Held::Buffer(gpu.buffer_of(name, bytes, BufferUsages::UNIFORM)),
                Content::Depths { depths, width } => {
                    let rows = depths.len() as u32 / width.max(1);
                    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
                    let texture = gpu.texture(TextureFormat::R32Float, (width, rows), 1, 1, usage);
                    let layout =
                        wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * width), ..Default::default() };
                    let bytes = bytemuck::cast_slice(depths);
                    gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
                    Held::Texture(texture.create_view(&Default::default()))
                }
            })
        })?;
        self.held.push((name.to_owned(), held));
        Ok(())
    }

    /// Runs the passes `frames` times in a row and returns the time of each, last that from the first beginning to the last
    /// end; empty where the adapter has no timestamps. Frames before these are not counted: one that compiles, and more until
    /// `warm_up` is over, since an idle processor runs at a lower clock.
    ///
    /// # Errors
    /// [`DeviceError`] for a shader that is invalid or asks for a resource without name here, and where the device fails.
    pub fn time(
        &self,
        passes: &[ComputePass<'_>],
        warm_up: Duration,
        frames: usize,
    ) -> Result<Vec<PassTimes>, DeviceError> {
        let gpu = &self.gpu;
        gpu.watched(|| {
            let resources = self.resources();
            let ready = passes.iter().map(|pass| {
                let shader = ComputeShader::new(gpu, pass.source, pass.entry)?;
                let bound = shader.bound(gpu, &resources)?;
                Ok((shader, bound, spread(pass.groups)))
            });
            let ready = ready.collect::<Result<Vec<_>, DeviceError>>()?;
            let timer = PassTimer::new(gpu, PASSES);
            let draw = || {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                for ((shader, bound, groups), number) in ready.iter().zip(0..) {
                    let stamp = timer.as_ref().map(|timer| timer.compute_writes(number));
                    shader.run(&mut encoder, bound, *groups, stamp);
                }
                if let Some(timer) = &timer {
                    timer.resolve(&mut encoder, ready.len());
                }
                gpu.queue.submit([encoder.finish()]);
                gpu.wait()?;
                timer.as_ref().map_or(Ok(Vec::new()), |timer| timer.read(gpu, ready.len()))
            };
            draw()?;
            let start = Instant::now();
            while start.elapsed() < warm_up {
                draw()?;
            }
            let names = passes.iter().map(|pass| pass.name).chain([WHOLE_FRAME]);
            let mut all: Vec<PassTimes> = names.map(|pass| PassTimes { pass, times: Vec::new() }).collect();
            for _ in 0..frames {
                let times = draw()?;
                if times.is_empty() {
                    return Ok(Vec::new());
                }
                all.iter_mut().zip(times).for_each(|(pass, time)| pass.times.push(time));
            }
            Ok(all)
        })
    }

    /// What a storage buffer holds.
    ///
    /// # Errors
    /// [`DeviceError`] where there is none of that name, and where the copy fails.
    pub fn read<T: Pod>(&self, name: &str) -> Result<Vec<T>, DeviceError> {
        match self.held.iter().find(|(held, _)| held == name) {
            Some((_, Held::Buffer(buffer))) => self.gpu.watched(|| self.gpu.read(buffer, 0, buffer.size())),
            Some((_, Held::Texture(_))) | None => {
                Err(DeviceError::Unsupported(format!("`{name}` is no buffer that could be read")))
            }
        }
    }

    fn resources(&self) -> Vec<Resource<'_>> {
        let bound = self.held.iter().map(|(name, held)| {
            let resource = match held {
                Held::Buffer(buffer) => buffer.as_entire_binding(),
                Held::Texture(view) => BindingResource::TextureView(view),
            };
            (name.as_str(), resource)
        });
        bound.collect()
    }
}

/// So many workgroups or a few more, in a rectangle.
fn spread(groups: u32) -> [u32; 2] {
    let rows = groups.div_ceil(GROUPS).max(1);
    [groups.div_ceil(rows), rows]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_fill_a_rectangle_that_adapters_take() {
        for groups in [0, 1, 64, 65_535, 65_536, 129_600, 10_000_000] {
            let [x, y] = spread(groups);
            assert!(x <= GROUPS && y <= GROUPS && x * y >= groups && x * y < groups + y, "{groups}: {x} {y}");
        }
    }
}
