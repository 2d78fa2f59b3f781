//! The passes between the light's depth map and the map that is read: resolve, filter, mip maps.

use wgpu::{TextureFormat as Format, TextureUsages as Uses};

use super::cover_pass::CoverPass;
use super::frame_renderer::FrameSettings;
use graphics_device::{DeviceError, GraphicsDevice};

/// From samples of depth to the filtered map with its mip levels.
pub(super) struct Chain {
    pub resolve: CoverPass,
    pub rows: CoverPass,
    pub columns: CoverPass,
    pub levels: Vec<CoverPass>,
    /// The filtered maps, with all levels.
    pub maps: Vec<wgpu::Texture>,
}

impl Chain {
    pub fn new(
        gpu: &GraphicsDevice,
        [resolve, filter, halve]: [&str; 3],
        formats: &[Format],
        settings: &FrameSettings,
        depths: &wgpu::TextureView,
    ) -> Result<Self, DeviceError> {
        for &format in formats {
            let offered = gpu.adapter.get_texture_format_features(format);
            let filterable = offered.flags.contains(wgpu::TextureFormatFeatureFlags::FILTERABLE)
                && offered.allowed_usages.contains(Uses::RENDER_ATTACHMENT)
                && gpu.device.features().contains(format.required_features());
            if !filterable {
                let what = format!("the adapter cannot filter textures of {format:?}");
                return Err(DeviceError::Unsupported(what));
            }
        }
        let side = settings.map_size;
        let levels = if settings.mip_maps { side.ilog2() + 1 } else { 1 };
        let textures = |levels: u32| -> Vec<wgpu::Texture> {
            let usage = Uses::RENDER_ATTACHMENT | Uses::TEXTURE_BINDING | Uses::COPY_SRC;
            formats.iter().map(|&format| gpu.texture(format, (side, side), levels, 1, usage)).collect()
        };
        let (maps, between) = (textures(levels), textures(1));
        let level = |textures: &[wgpu::Texture], level: u32| -> Vec<wgpu::TextureView> {
            let view = wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            };
            textures.iter().map(|texture| texture.create_view(&view)).collect()
        };
        let targets = |views: &[wgpu::TextureView]| -> Vec<(Format, wgpu::TextureView)> {
            formats.iter().copied().zip(views.iter().cloned()).collect()
        };
        let module = |source: &str| gpu.shader(source);
        let (resolve, filter, halve) = (module(resolve), module(filter), module(halve));
        let first = level(&maps, 0);
        let other = level(&between, 0);
        let read = |views: &[wgpu::TextureView],
                    shader: &wgpu::ShaderModule,
                    entry: &str,
                    to: &[(Format, wgpu::TextureView)]| {
            let resources: Vec<_> =
                (0..).zip(views).map(|(i, v)| (i, wgpu::BindingResource::TextureView(v))).collect();
            CoverPass::new(gpu, shader, entry, &resources, to)
        };
        let depth_binding = [(3, wgpu::BindingResource::TextureView(depths))];
        Ok(Self {
            resolve: CoverPass::new(gpu, &resolve, "resolve", &depth_binding, &targets(&first)),
            rows: read(&first, &filter, "along_rows", &targets(&other)),
            columns: read(&other, &filter, "along_columns", &targets(&first)),
            levels: (1..levels)
                .map(|l| read(&level(&maps, l - 1), &halve, "halve", &targets(&level(&maps, l))))
                .collect(),
            maps,
        })
    }

    /// Level 0, channel by channel, for single floats.
    pub fn filtered(&self, gpu: &GraphicsDevice) -> Result<Option<Vec<f32>>, DeviceError> {
        let mut all: Vec<(usize, Vec<f32>)> = Vec::new();
        for map in &self.maps {
            let channels = match map.format() {
                Format::R32Float => 1,
                Format::Rg32Float => 2,
                Format::Rgba32Float => 4,
                _ => return Ok(None),
            };
            all.push((channels, gpu.read_texture(map)?));
        }
        let texels = all.first().map_or(0, |(channels, values)| values.len() / channels);
        let texel =
            |t: usize| all.iter().flat_map(move |(c, values)| values[t * c..(t + 1) * c].iter().copied());
        Ok(Some((0..texels).flat_map(texel).collect()))
    }
}
