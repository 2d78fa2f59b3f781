//! The passes between the light's depth map and the map that is read: resolve, filter, mip maps.

use graphics_device::{DeviceError, GraphicsDevice};
use wgpu::{TextureFormat as Format, TextureUsages as Uses, TextureView};

use super::bind::Resource;
use super::frame_renderer::FrameSettings;
use super::raster_pass::RasterPass;

/// From samples of depth to the filtered map with its mip levels.
pub(super) struct Chain {
    pub resolve: RasterPass,
    pub rows: RasterPass,
    pub columns: RasterPass,
    pub levels: Vec<RasterPass>,
    /// The filtered maps, with all levels.
    pub maps: Vec<wgpu::Texture>,
}

impl Chain {
    pub(super) fn new(
        gpu: &GraphicsDevice,
        [resolve, rows, columns, halve]: [&str; 4],
        formats: &[Format],
        settings: &FrameSettings,
        depths: &TextureView,
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
        let level = |textures: &[wgpu::Texture], level: u32| -> Vec<TextureView> {
            let view = wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            };
            textures.iter().map(|texture| texture.create_view(&view)).collect()
        };
        let pass = |shader: &str, from: &[TextureView], to: &[TextureView]| {
            let mut resources = map_resources(from);
            resources.push(("depths", wgpu::BindingResource::TextureView(depths)));
            RasterPass::new(gpu, shader, &resources, Vec::new(), to.to_vec(), None)
        };
        let (first, other) = (level(&maps, 0), level(&between, 0));
        Ok(Self {
            resolve: pass(resolve, &[], &first)?,
            rows: pass(rows, &first, &other)?,
            columns: pass(columns, &other, &first)?,
            levels: (1..levels)
                .map(|l| pass(halve, &level(&maps, l - 1), &level(&maps, l)))
                .collect::<Result<_, _>>()?,
            maps,
        })
    }

    /// Level 0, channel by channel, for single floats.
    pub(super) fn filtered(&self, gpu: &GraphicsDevice) -> Result<Option<Vec<f32>>, DeviceError> {
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

/// Textures of a map under the names that shaders give them.
pub(super) fn map_resources(views: &[TextureView]) -> Vec<Resource<'_>> {
    ["map0", "map1"].into_iter().zip(views.iter().map(wgpu::BindingResource::TextureView)).collect()
}
