//! Modules in other languages than WGSL, through naga's back ends.

use naga::back::spv::{self, WriterFlags};

use crate::{Module, ShaderError};

impl Module {
    /// SPIR-V 1.0 with the names of the WGSL, every entry point in one module; y grows upwards in clip coordinates as in
    /// WGSL, and loops are bounded as WGSL demands.
    ///
    /// # Errors
    /// [`ShaderError::Unwritable`] for what the language cannot say.
    pub fn spirv(&self) -> Result<Vec<u32>, ShaderError> {
        let flags = WriterFlags::ADJUST_COORDINATE_SPACE | WriterFlags::DEBUG;
        let options = spv::Options { lang_version: (1, 0), flags, ..Default::default() };
        spv::write_vec(&self.module, &self.info, &options, None)
            .map_err(|error| ShaderError::Unwritable { language: "SPIR-V", problem: error.to_string() })
    }
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
