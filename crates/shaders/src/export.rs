//! Modules in other languages than WGSL, through naga's back ends.

use naga::back::{glsl, hlsl, msl, spv};
use naga::proc::BoundsCheckPolicies;
use naga::{AddressSpace, TypeInner};

use crate::portable_hlsl;
use crate::{Module, ShaderError, Stage};

/// GLSL as OpenGL 4.5 and Vulkan take it.
const GLSL_VERSION: u16 = 450;

/// Metal shading language that every system with its compiler reads.
const MSL_VERSION: (u8, u8) = (2, 0);

/// Slot of the sizes of arrays without a length, behind all others.
const MSL_SIZES: u8 = 30;

impl Module {
    /// SPIR-V 1.0 with the names of the WGSL, every entry point in one module; y grows upwards in clip coordinates as in
    /// WGSL, and loops are bounded as WGSL demands.
    ///
    /// # Errors
    /// [`ShaderError::Unwritable`] for what the language cannot say.
    pub fn spirv(&self) -> Result<Vec<u32>, ShaderError> {
        let flags = spv::WriterFlags::ADJUST_COORDINATE_SPACE | spv::WriterFlags::DEBUG;
        let options = spv::Options { lang_version: (1, 0), flags, ..Default::default() };
        spv::write_vec(&self.module, &self.info, &options, None)
            .map_err(|error| unwritable("SPIR-V", error.to_string()))
    }

    /// HLSL of shader model 5.0, every entry point in one file. Registers are the numbers of `@binding`, each sampler in
    /// its own; indices and loops are as the WGSL wrote them, unchecked.
    ///
    /// # Errors
    /// As [`Module::spirv`].
    pub fn hlsl(&self) -> Result<String, ShaderError> {
        let options = hlsl::Options {
            shader_model: hlsl::ShaderModel::V5_0,
            fake_missing_bindings: true,
            restrict_indexing: false,
            force_loop_bounding: false,
            ..Default::default()
        };
        let mut text = String::new();
        let pipeline = hlsl::PipelineOptions::default();
        hlsl::Writer::new(&mut text, &options, &pipeline)
            .write(&self.module, &self.info, None)
            .map_err(|error| unwritable("HLSL", error.to_string()))?;
        let variables = || self.module.global_variables.iter().map(|(_, variable)| variable);
        Ok(portable_hlsl::portable(&text, |sampler| {
            let mut named = variables().filter(|variable| variable.name.as_deref() == Some(sampler));
            named.find_map(|variable| Some(variable.binding.as_ref()?.binding))
        }))
    }

    /// GLSL 4.50 of one entry point, which becomes `main`, with every function that reads no other resources. Bindings are
    /// those of the WGSL; a texture and its sampler become one `sampler2D`.
    ///
    /// # Errors
    /// As [`Module::spirv`]; [`ShaderError::NoEntryPoint`].
    pub fn glsl(&self, entry_point: &str) -> Result<String, ShaderError> {
        let stage = match self.entry_point(entry_point)?.stage {
            Stage::Vertex => naga::ShaderStage::Vertex,
            Stage::Fragment => naga::ShaderStage::Fragment,
            Stage::Compute => naga::ShaderStage::Compute,
        };
        let mut options = glsl::Options {
            version: glsl::Version::Desktop(GLSL_VERSION),
            writer_flags: glsl::WriterFlags::ADJUST_COORDINATE_SPACE,
            ..Default::default()
        };
        for (_, variable) in self.module.global_variables.iter() {
            if let Some(binding) = variable.binding {
                let number = u8::try_from(binding.binding)
                    .map_err(|_| unwritable("GLSL", format!("binding {} is beyond 255", binding.binding)))?;
                options.binding_map.insert(binding, number);
            }
        }
        let pipeline = glsl::PipelineOptions {
            shader_stage: stage,
            entry_point: entry_point.to_owned(),
            multiview: None,
        };
        let mut text = String::new();
        let fail = |error: glsl::Error| unwritable("GLSL", error.to_string());
        let policies = BoundsCheckPolicies::default();
        glsl::Writer::new(&mut text, &self.module, &self.info, &options, &pipeline, policies)
            .map_err(fail)?
            .write()
            .map_err(fail)?;
        // The back end numbers resources.
        let suffix = match stage {
            naga::ShaderStage::Vertex => "vs",
            naga::ShaderStage::Fragment => "fs",
            _ => "cs",
        };
        for (_, variable) in self.module.global_variables.iter() {
            if let (Some(name), Some(binding)) = (&variable.name, variable.binding) {
                let number = format!("_group_{}_binding_{}_{suffix}", binding.group, binding.binding);
                text = text.replace(&number, name);
            }
        }
        Ok(text)
    }

    /// Metal shading language 2.0, every entry point in one file. Textures, samplers and buffers are numbered apart, each in
    /// the order of `@binding`.
    ///
    /// # Errors
    /// As [`Module::spirv`].
    pub fn msl(&self) -> Result<String, ShaderError> {
        let mut bound: Vec<_> = self.module.global_variables.iter().collect();
        bound.sort_by_key(|(_, variable)| variable.binding);
        let mut resources = msl::BindingMap::default();
        let (mut textures, mut samplers, mut buffers) = (0..MSL_SIZES, 0..MSL_SIZES, 0..MSL_SIZES);
        for (_, variable) in bound {
            let Some(binding) = variable.binding else { continue };
            let mut target = msl::BindTarget::default();
            let full = || unwritable("MSL", format!("more than {MSL_SIZES} resources of a kind"));
            match self.module.types[variable.ty].inner {
                TypeInner::Image { .. } => target.texture = Some(textures.next().ok_or_else(full)?),
                TypeInner::Sampler { .. } => {
                    target.sampler =
                        Some(msl::BindSamplerTarget::Resource(samplers.next().ok_or_else(full)?));
                }
                _ => target.buffer = Some(buffers.next().ok_or_else(full)?),
            }
            target.mutable = matches!(variable.space, AddressSpace::Storage { access }
                if access.contains(naga::StorageAccess::STORE));
            resources.insert(binding, target);
        }
        let each = || msl::EntryPointResources {
            resources: resources.clone(),
            sizes_buffer: Some(MSL_SIZES),
            ..Default::default()
        };
        let entries = self.module.entry_points.iter();
        let options = msl::Options {
            lang_version: MSL_VERSION,
            per_entry_point_map: entries.map(|entry| (entry.name.clone(), each())).collect(),
            fake_missing_bindings: false,
            force_loop_bounding: false,
            ..Default::default()
        };
        msl::write_string(&self.module, &self.info, &options, &msl::PipelineOptions::default())
            .map(|(text, _)| text)
            .map_err(|error| unwritable("MSL", error.to_string()))
    }
}

fn unwritable(language: &'static str, problem: String) -> ShaderError {
    ShaderError::Unwritable { language, problem }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
@group(0) @binding(2) var depths: texture_2d<f32>;
@group(0) @binding(5) var<storage, read_write> sums: array<f32>;
@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(index), 0.0, 0.0, 1.0);
}
@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var i = 0u; i < id.y; i++) {
        sums[id.x] += textureLoad(depths, vec2<u32>(i, id.x), 0).x;
    }
}
";

    #[test]
    fn hlsl_glsl_and_msl_have_entry_points_and_bindings() {
        let module = Module::new(SOURCE).unwrap();
        let hlsl = module.hlsl().unwrap();
        for part in ["cover(", "sum(", "register(t2)", "register(u5)"] {
            assert!(hlsl.contains(part), "`{part}` in {hlsl}");
        }
        let glsl = module.glsl("sum").unwrap();
        for part in [
            "#version 450",
            "void main()",
            "binding = 2",
            "sampler2D depths;",
            "binding = 5",
            "local_size_x = 64",
        ] {
            assert!(glsl.contains(part), "`{part}` in {glsl}");
        }
        assert!(matches!(module.glsl("total"), Err(ShaderError::NoEntryPoint(_))));
        let msl = module.msl().unwrap();
        for part in ["vertex coverOutput cover(", "kernel void sum(", "[[texture(0)]]", "[[buffer(0)]]"] {
            assert!(msl.contains(part), "`{part}` in {msl}");
        }
    }

    #[test]
    fn samplers_have_registers_of_their_own_in_hlsl() {
        let source = "
@group(0) @binding(3) var linear: sampler;
@group(0) @binding(1) var map: texture_2d<f32>;
@fragment
fn pixel(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {
    return textureSample(map, linear, uv);
}
";
        let hlsl = Module::new(source).unwrap().hlsl().unwrap();
        assert!(hlsl.contains("register(s3)") && !hlsl.contains("Heap"), "{hlsl}");
    }

    /// Numbers of the SPIR-V specification: magic number, and the instructions that are looked at.
    const MAGIC: u32 = 0x0723_0203;
    const ENTRY_POINT: u32 = 15;
    const DECORATE: u32 = 71;
    const BINDING: u32 = 33;

    /// Instructions as opcode and operands; they fill the module to its last word.
    fn instructions(words: &[u32]) -> Vec<(u32, &[u32])> {
        assert_eq!(words[0], MAGIC);
        let (mut rest, mut found) = (&words[5..], Vec::new());
        while let [first, ..] = rest {
            let (length, opcode) = ((first >> 16) as usize, first & 0xffff);
            assert!((1..=rest.len()).contains(&length), "an instruction of {length} words");
            found.push((opcode, &rest[1..length]));
            rest = &rest[length..];
        }
        found
    }

    fn name(words: &[u32]) -> String {
        let bytes = words.iter().flat_map(|word| word.to_le_bytes());
        bytes.take_while(|byte| *byte != 0).map(char::from).collect()
    }

    #[test]
    fn spirv_has_the_entry_points_and_bindings_of_the_wgsl() {
        let module = Module::new(SOURCE).unwrap();
        let words = module.spirv().unwrap();
        let all = instructions(&words);
        let of =
            |wanted: u32| all.iter().filter(move |(opcode, _)| *opcode == wanted).map(|(_, words)| *words);
        // Execution model 0 is a vertex, 5 a compute shader.
        let entries: Vec<_> = of(ENTRY_POINT).map(|words| (words[0], name(&words[2..]))).collect();
        assert_eq!(entries, [(0, "cover".to_owned()), (5, "sum".to_owned())]);
        let mut bindings: Vec<u32> =
            of(DECORATE).filter(|words| words[1] == BINDING).map(|words| words[2]).collect();
        bindings.sort_unstable();
        let reflected = &module.entry_point("sum").unwrap().bindings;
        assert_eq!(bindings, reflected.iter().map(|binding| binding.number).collect::<Vec<_>>());
    }
}
