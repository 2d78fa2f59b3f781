//! The passes between the light's depth map and the map that is read: resolve, filter, mip maps.

use graphics_device::{DeviceError, GraphicsDevice, PassTimer};
use wgpu::{TextureFormat as Format, TextureUsages as Uses, TextureView};

use super::bind::Resource;
use super::frame_renderer::{FrameSettings, Stamps};
use super::raster_pass::RasterPass;

/// From samples of depth to the filtered map with its mip levels.
pub(super) struct Chain {
    resolve: RasterPass,
    rows: RasterPass,
    columns: RasterPass,
    levels: Vec<RasterPass>,
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
        let levels = levels(settings);
        let [maps, between] = textures(gpu, formats, settings, Uses::RENDER_ATTACHMENT)?;
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

    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, stamps: &mut Stamps<'_>) {
        stamps.draw(encoder, "resolve", &self.resolve);
        stamps.draw(encoder, "filter rows", &self.rows);
        stamps.draw(encoder, "filter columns", &self.columns);
        if let [first, between @ .., last] = self.levels.as_slice() {
            // From the beginning of the first level to the end of the last.
            let number = stamps.next("mip maps");
            let whole = stamps.timer.map(|timer| timer.writes(number));
            first.draw(encoder, whole.clone().map(PassTimer::begin_only));
            for level in between {
                level.draw(encoder, None);
            }
            last.draw(encoder, whole.map(PassTimer::end_only));
        }
    }
}

/// Number of mip levels.
pub(super) fn levels(settings: &FrameSettings) -> u32 {
    if settings.mip_maps { settings.map_size.ilog2() + 1 } else { 1 }
}

/// A map with its levels, and one without that stands between two passes.
pub(super) fn textures(
    gpu: &GraphicsDevice,
    formats: &[Format],
    settings: &FrameSettings,
    written: Uses,
) -> Result<[Vec<wgpu::Texture>; 2], DeviceError> {
    for &format in formats {
        let offered = gpu.adapter.get_texture_format_features(format);
        let fits = offered.flags.contains(wgpu::TextureFormatFeatureFlags::FILTERABLE)
            && offered.allowed_usages.contains(written)
            && gpu.device.features().contains(format.required_features());
        if !fits {
            let what = format!("the adapter cannot write and filter textures of {format:?}");
            return Err(DeviceError::Unsupported(what));
        }
    }
    let side = settings.map_size;
    let usage = written | Uses::TEXTURE_BINDING | Uses::COPY_SRC;
    Ok([levels(settings), 1].map(|levels| {
        formats.iter().map(|&format| gpu.texture(format, (side, side), levels, 1, usage)).collect()
    }))
}

/// One level of textures.
pub(super) fn level(textures: &[wgpu::Texture], level: u32) -> Vec<TextureView> {
    let view =
        wgpu::TextureViewDescriptor { base_mip_level: level, mip_level_count: Some(1), ..Default::default() };
    textures.iter().map(|texture| texture.create_view(&view)).collect()
}

/// Level 0 of maps, channel by channel, for single floats.
pub(super) fn filtered(
    gpu: &GraphicsDevice,
    maps: &[wgpu::Texture],
) -> Result<Option<Vec<f32>>, DeviceError> {
    let mut all: Vec<(usize, Vec<f32>)> = Vec::new();
    for map in maps {
        let channels = match map.format() {
            Format::R32Float => 1,
            Format::Rg32Float => 2,
            Format::Rgba32Float => 4,
            _ => return Ok(None),
        };
        all.push((channels, gpu.read_texture(map)?));
    }
    let texels = all.first().map_or(0, |(channels, values)| values.len() / channels);
    let texel = |t: usize| all.iter().flat_map(move |(c, values)| values[t * c..(t + 1) * c].iter().copied());
    Ok(Some((0..texels).flat_map(texel).collect()))
}

/// Textures of a map under the names that shaders give them.
pub(super) fn map_resources(views: &[TextureView]) -> Vec<Resource<'_>> {
    ["map0", "map1"].into_iter().zip(views.iter().map(wgpu::BindingResource::TextureView)).collect()
}
