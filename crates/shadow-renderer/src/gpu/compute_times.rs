//! Times of compute passes, one after another in a frame.

use std::time::{Duration, Instant};

use graphics_device::{DeviceError, GraphicsDevice, PassTimer};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

use super::compute_shader::ComputeShader;
use super::frame_renderer::PassTimes;

/// A resource of compute passes.
#[derive(Clone, Copy, Debug)]
pub enum ComputeInput<'a> {
    /// A storage buffer with contents.
    Bytes(&'a [u8]),
    /// A storage buffer of so many bytes.
    Empty(u64),
    /// A uniform.
    Uniform(&'a [u8]),
    /// A texture of single floats, row by row, and its width.
    Depths(&'a [f32], u32),
}

/// A compute pass.
#[derive(Clone, Copy, Debug)]
pub struct ComputePass<'a> {
    /// Name in the times.
    pub name: &'static str,
    /// WGSL.
    pub source: &'a str,
    /// Its entry point.
    pub entry: &'a str,
    /// Threads along x and y.
    pub threads: [u32; 2],
}

/// Most groups along x.
const MOST_GROUPS: u32 = 65_535;

/// GPU times of `frames` frames of these passes, whose variables find their resources by name; empty where the adapter has no
/// timestamps. Frames before these are not counted, until `warm_up` is over.
///
/// # Errors
/// [`DeviceError`] for shaders, resources that are missing, and a device that is lost.
pub fn compute_times(
    passes: &[ComputePass<'_>],
    inputs: &[(&str, ComputeInput<'_>)],
    warm_up: Duration,
    frames: usize,
) -> Result<Vec<PassTimes>, DeviceError> {
    let gpu = &GraphicsDevice::open(wgpu::Features::TIMESTAMP_QUERY)?;
    let Some(timer) = PassTimer::new(gpu, passes.len() as u32) else { return Ok(Vec::new()) };
    gpu.watched(|| {
        let held: Vec<Held> = inputs.iter().map(|(_, input)| Held::new(gpu, input)).collect();
        let bound: Vec<_> =
            inputs.iter().zip(&held).map(|((name, _), held)| (*name, held.resource())).collect();
        let shaders = passes.iter().map(|pass| ComputeShader::new(gpu, pass.source, pass.entry));
        let shaders: Vec<ComputeShader> = shaders.collect::<Result<_, _>>()?;
        let draw = || -> Result<Vec<Duration>, DeviceError> {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            for (i, (pass, shader)) in passes.iter().zip(&shaders).enumerate() {
                let groups = folded(shader.groups_of(pass.threads));
                shader.dispatch_timed(
                    gpu,
                    &mut encoder,
                    &bound,
                    groups,
                    Some(timer.compute_writes(i as u32)),
                )?;
            }
            timer.resolve(&mut encoder, passes.len());
            gpu.queue.submit([encoder.finish()]);
            timer.read(gpu, passes.len())
        };
        draw()?;
        let start = Instant::now();
        while start.elapsed() < warm_up {
            draw()?;
        }
        let mut times: Vec<PassTimes> =
            passes.iter().map(|pass| PassTimes { pass: pass.name, times: Vec::new() }).collect();
        for _ in 0..frames {
            // Last comes the whole frame.
            times.iter_mut().zip(draw()?).for_each(|(pass, time)| pass.times.push(time));
        }
        Ok(times)
    })
}

/// More groups than fit along x stand in rows; shaders count through them.
fn folded([x, y]: [u32; 2]) -> [u32; 2] {
    if x <= MOST_GROUPS { [x, y] } else { [MOST_GROUPS, x.div_ceil(MOST_GROUPS)] }
}

/// What a resource is made of.
enum Held {
    Buffer(wgpu::Buffer),
    View(wgpu::TextureView),
}

impl Held {
    fn new(gpu: &GraphicsDevice, input: &ComputeInput<'_>) -> Self {
        match *input {
            ComputeInput::Bytes(bytes) => Self::Buffer(gpu.buffer_of("bytes", bytes, BufferUsages::STORAGE)),
            ComputeInput::Empty(bytes) => Self::Buffer(gpu.buffer("empty", bytes, BufferUsages::STORAGE)),
            ComputeInput::Uniform(bytes) => {
                Self::Buffer(gpu.buffer_of("uniform", bytes, BufferUsages::UNIFORM))
            }
            ComputeInput::Depths(depths, width) => {
                let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
                let size = (width, depths.len() as u32 / width);
                let texture = gpu.texture(TextureFormat::R32Float, size, 1, 1, usage);
                let layout =
                    wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * width), ..Default::default() };
                let bytes = bytemuck::cast_slice(depths);
                gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
                Self::View(texture.create_view(&Default::default()))
            }
        }
    }

    fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::View(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOUBLE: &str = "@group(0) @binding(0) var<storage, read> source: array<u32>;
@group(0) @binding(1) var<storage, read_write> target_words: array<u32>;
@compute @workgroup_size(64)
fn twice(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&source) { target_words[id.x] = 2u * source[id.x]; }
}";

    /// Without an adapter there is nothing to time; with one every pass has its times, or the adapter has none.
    #[test]
    fn passes_are_timed_and_what_is_missing_is_named() {
        let pass = ComputePass { name: "twice", source: DOUBLE, entry: "twice", threads: [256, 1] };
        let bytes = [1u8; 1024];
        let inputs = [("source", ComputeInput::Bytes(&bytes)), ("target_words", ComputeInput::Empty(1024))];
        match compute_times(&[pass, pass], &inputs, Duration::ZERO, 3) {
            Ok(times) if times.is_empty() => {}
            Ok(times) => assert!(times.len() == 2 && times.iter().all(|pass| pass.times.len() == 3)),
            Err(error) => {
                assert!(matches!(error, DeviceError::NoAdapter(_)), "{error}");
                return;
            }
        }
        let missing = compute_times(&[pass], &inputs[..1], Duration::ZERO, 1);
        assert!(
            missing.is_ok_and(|times| times.is_empty())
                || compute_error(&pass, &inputs[..1]).contains("target_words")
        );
        assert_eq!((folded([70_000, 1]), folded([5, 7])), ([65_535, 2], [5, 7]));
    }

    fn compute_error(pass: &ComputePass<'_>, inputs: &[(&str, ComputeInput<'_>)]) -> String {
        compute_times(&[*pass], inputs, Duration::ZERO, 1)
            .map_or_else(|error| error.to_string(), |_| String::new())
    }
}
