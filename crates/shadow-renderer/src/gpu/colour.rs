//! Textures of colour on the GPU.

use std::sync::Arc;

use graphics_device::GraphicsDevice;
use scenes::{MipLevel, Scene, Texture, Wrap};
use wgpu::BufferUsages as Usage;

use super::bind::Resource;

/// Marks a surface without texture.
const NO_TEXTURE: u32 = u32::MAX;

/// The textures of a scene, each once.
pub(super) struct TextureBuffers {
    entries: wgpu::Buffer,
    texels: wgpu::Buffer,
    /// By material.
    of_material: Vec<u32>,
}

impl TextureBuffers {
    pub(super) fn upload(gpu: &GraphicsDevice, scene: &Scene) -> Self {
        let mut known: Vec<(*const Vec<MipLevel>, [Wrap; 2])> = Vec::new();
        let mut first_texels: Vec<u32> = Vec::new();
        let (mut entries, mut texels): (Vec<[u32; 6]>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut of_material = Vec::with_capacity(scene.materials.len());
        for material in &scene.materials {
            let Some(texture) = &material.texture else {
                of_material.push(NO_TEXTURE);
                continue;
            };
            let levels = Arc::as_ptr(&texture.levels);
            if let Some(index) = known.iter().position(|&key| key == (levels, texture.wrap)) {
                of_material.push(index as u32);
                continue;
            }
            let shared = known.iter().position(|&(of, _)| of == levels).map(|index| first_texels[index]);
            let first = shared.unwrap_or(texels.len() as u32);
            if shared.is_none() {
                texels.extend(
                    texture
                        .levels
                        .iter()
                        .flat_map(|level| &level.texels)
                        .map(|&[r, g, b]| u32::from_le_bytes([r, g, b, u8::MAX])),
                );
            }
            of_material.push(known.len() as u32);
            known.push((levels, texture.wrap));
            first_texels.push(first);
            entries.push(entry(texture, first));
        }
        Self {
            entries: gpu.buffer_of("textures", &entries, Usage::STORAGE),
            texels: gpu.buffer_of("texels", &texels, Usage::STORAGE),
            of_material,
        }
    }

    pub(super) fn of_material(&self, material: u32) -> u32 {
        self.of_material[material as usize]
    }

    pub(super) fn resources(&self) -> [Resource<'_>; 2] {
        [("textures", &self.entries), ("texels", &self.texels)]
            .map(|(name, buffer)| (name, buffer.as_entire_binding()))
    }
}

/// As `Texture` in colour.wgsl.
fn entry(texture: &Texture, first: u32) -> [u32; 6] {
    let [width, height] = texture.size();
    let [u, v] = texture.wrap.map(|wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Clamp => 1,
        Wrap::Mirror => 2,
    });
    [width, height, texture.levels.len() as u32, first, u, v]
}
