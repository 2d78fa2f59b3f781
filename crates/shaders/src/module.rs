//! A WGSL module, validated, and what it asks of whoever runs it.

use std::error::Error;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{ShaderStage, TypeInner};

use crate::ShaderError;

/// What a module may use although some adapters lack it: 16-bit maps that compute passes write; and half floats packed into
/// words, which are plain WGSL.
const CAPABILITIES: Capabilities =
    Capabilities::STORAGE_TEXTURE_16BIT_NORM_FORMATS.union(Capabilities::SHADER_FLOAT16_IN_FLOAT32);

/// Kind of an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A vertex shader.
    Vertex,
    /// A fragment shader.
    Fragment,
    /// A compute shader.
    Compute,
}

/// A resource of group 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Name of the variable.
    pub name: String,
    /// Its `@binding`.
    pub number: u32,
}

/// A vertex attribute of so many components, 32 bits each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexInput {
    /// Single floats.
    Float(u32),
    /// Unsigned integers.
    Unsigned(u32),
}

/// What a pass runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// Name of the function.
    pub name: String,
    /// Its kind.
    pub stage: Stage,
    /// Threads of a workgroup along x, y and z; zeros unless it is a compute shader.
    pub workgroup_size: [u32; 3],
    /// The resources that it or a function it calls uses, by ascending number.
    pub bindings: Vec<Binding>,
    /// Attributes of a vertex shader by ascending `@location`, which starts at 0 and leaves nothing out.
    pub inputs: Vec<VertexInput>,
}

/// A validated module.
#[derive(Debug)]
pub struct Module {
    pub(crate) module: naga::Module,
    pub(crate) info: ModuleInfo,
    entry_points: Vec<EntryPoint>,
}

impl Module {
    /// Parses, validates and reflects WGSL; of what only some adapters offer 16-bit storage textures alone.
    ///
    /// # Errors
    /// [`ShaderError::Invalid`] with the first fault.
    pub fn new(source: &str) -> Result<Self, ShaderError> {
        let module = naga::front::wgsl::parse_str(source).map_err(|error| ShaderError::Invalid {
            line: error.location(source).map_or(0, |place| place.line_number),
            problem: error.message().to_owned(),
        })?;
        let validated = Validator::new(ValidationFlags::all(), CAPABILITIES).validate(&module);
        let info = validated.map_err(|error| {
            // The narrowest place says most; the others are the functions around it.
            let places = error.spans().map(|(span, _)| *span).filter(|span| span.is_defined());
            let narrowest = places.min_by_key(|span| span.to_range().map_or(0, |range| range.len()));
            ShaderError::Invalid {
                line: narrowest.map_or(0, |span| span.location(source).line_number),
                problem: with_causes(error.as_inner()),
            }
        })?;
        let of = |(index, entry)| entry_point(&module, &info, index, entry);
        let entry_points = module.entry_points.iter().enumerate().map(of).collect::<Result<_, _>>()?;
        Ok(Self { module, info, entry_points })
    }

    /// All of them, in the order of the text.
    pub fn entry_points(&self) -> &[EntryPoint] {
        &self.entry_points
    }

    /// The entry point of a name.
    ///
    /// # Errors
    /// [`ShaderError::NoEntryPoint`].
    pub fn entry_point(&self, name: &str) -> Result<&EntryPoint, ShaderError> {
        let found = self.entry_points.iter().find(|entry| entry.name == name);
        found.ok_or_else(|| ShaderError::NoEntryPoint(format!("`{name}`")))
    }

    /// The only entry point of a kind.
    ///
    /// # Errors
    /// [`ShaderError::NoEntryPoint`] if there is none or more than one.
    pub fn only(&self, stage: Stage) -> Result<&EntryPoint, ShaderError> {
        let mut of_stage = self.entry_points.iter().filter(|entry| entry.stage == stage);
        match (of_stage.next(), of_stage.next()) {
            (Some(entry), None) => Ok(entry),
            _ => Err(ShaderError::NoEntryPoint(format!("of kind {stage:?} and no other of this kind"))),
        }
    }
}

fn with_causes(error: &dyn Error) -> String {
    let causes = std::iter::successors(error.source(), |&cause| cause.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

fn fault(problem: String) -> ShaderError {
    ShaderError::Invalid { line: 0, problem }
}

fn entry_point(
    module: &naga::Module,
    info: &ModuleInfo,
    index: usize,
    entry: &naga::EntryPoint,
) -> Result<EntryPoint, ShaderError> {
    let stage = match entry.stage {
        ShaderStage::Vertex => Stage::Vertex,
        ShaderStage::Fragment => Stage::Fragment,
        ShaderStage::Compute => Stage::Compute,
        other => return Err(fault(format!("`{}` is of the kind {other:?}", entry.name))),
    };
    let uses = info.get_entry_point(index);
    let mut bindings = Vec::new();
    for (_, variable) in module.global_variables.iter().filter(|(handle, _)| !uses[*handle].is_empty()) {
        let (name, Some(binding)) = (variable.name.clone().unwrap_or_default(), &variable.binding) else {
            continue;
        };
        if binding.group != 0 {
            return Err(fault(format!("`{name}` is in group {}, passes bind group 0 only", binding.group)));
        }
        bindings.push(Binding { name, number: binding.binding });
    }
    bindings.sort_by_key(|binding| binding.number);
    let inputs = if stage == Stage::Vertex { vertex_inputs(module, entry)? } else { Vec::new() };
    Ok(EntryPoint { name: entry.name.clone(), stage, workgroup_size: entry.workgroup_size, bindings, inputs })
}

fn vertex_inputs(module: &naga::Module, entry: &naga::EntryPoint) -> Result<Vec<VertexInput>, ShaderError> {
    let mut inputs = Vec::new();
    for argument in &entry.function.arguments {
        let Some(naga::Binding::Location { location, .. }) = argument.binding else { continue };
        let (scalar, components) = match module.types[argument.ty].inner {
            TypeInner::Scalar(scalar) => (scalar, 1),
            TypeInner::Vector { size, scalar } => (scalar, size as u32),
            ref other => return Err(fault(format!("attribute {location} of `{}` is {other:?}", entry.name))),
        };
        let input = match scalar {
            naga::Scalar::F32 => VertexInput::Float(components),
            naga::Scalar::U32 => VertexInput::Unsigned(components),
            other => return Err(fault(format!("attribute {location} of `{}` holds {other:?}", entry.name))),
        };
        inputs.push((location, input));
    }
    inputs.sort_by_key(|(location, _)| *location);
    if (0..).zip(&inputs).any(|(expected, (location, _))| expected != *location) {
        return Err(fault(format!("the attributes of `{}` leave out a location", entry.name)));
    }
    Ok(inputs.into_iter().map(|(_, input)| input).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
struct Unused { x: f32 }
@group(0) @binding(4) var<uniform> scale: vec4<f32>;
@group(0) @binding(1) var depths: texture_2d<f32>;
@group(0) @binding(7) var<storage, read_write> sums: array<f32>;

fn depth() -> f32 {
    return textureLoad(depths, vec2<i32>(0), 0).x * scale.x;
}

@vertex
fn corner(@location(1) mask: u32, @location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return scale + vec4<f32>(position, f32(mask));
}

@fragment
fn pixel() -> @location(0) vec4<f32> {
    return vec4<f32>(depth());
}

@compute @workgroup_size(64, 2)
fn sum(@builtin(global_invocation_id) id: vec3<u32>) {
    sums[id.x] = depth();
}
";

    fn module() -> Module {
        Module::new(SOURCE).unwrap()
    }

    #[test]
    fn bindings_are_those_that_an_entry_point_reaches() {
        let module = module();
        fn names(entry: &EntryPoint) -> Vec<(u32, &str)> {
            entry.bindings.iter().map(|binding| (binding.number, binding.name.as_str())).collect()
        }
        let [depths, scale, sums] = [(1, "depths"), (4, "scale"), (7, "sums")];
        assert_eq!(names(module.only(Stage::Vertex).unwrap()), [scale]);
        assert_eq!(names(module.only(Stage::Fragment).unwrap()), [depths, scale]);
        assert_eq!(names(module.entry_point("sum").unwrap()), [depths, scale, sums]);
    }

    #[test]
    fn sizes_and_attributes_are_reflected() {
        let module = module();
        assert_eq!(module.entry_point("sum").unwrap().workgroup_size, [64, 2, 1]);
        let expected = [VertexInput::Float(3), VertexInput::Unsigned(1)];
        assert_eq!(module.only(Stage::Vertex).unwrap().inputs, expected);
    }

    #[test]
    fn faults_name_their_line() {
        for (from, to, line, problem) in [
            ("scale.x", "scale.x + 1u", 8, "Operation Add"),
            ("depth());", "depths_of());", 18, "no definition in scope for identifier: `depths_of`"),
            ("var depths: texture_2d<f32>", "var depths texture_2d<f32>", 4, "expected"),
        ] {
            assert!(SOURCE.contains(from));
            match Module::new(&SOURCE.replacen(from, to, 1)) {
                Err(ShaderError::Invalid { line: found, problem: said }) => {
                    assert_eq!(found, line, "{said}");
                    assert!(said.contains(problem), "{said}");
                }
                other => panic!("{to} passed: {other:?}"),
            }
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        let module = module();
        assert_eq!(module.entry_point("cover"), Err(ShaderError::NoEntryPoint("`cover`".to_owned())));
        let two = SOURCE.replace("@compute @workgroup_size(64, 2)", "@fragment");
        assert!(Module::new(&two.replace("@builtin(global_invocation_id) id: vec3<u32>", "")).is_err());
        let other_group = SOURCE.replacen("@group(0)", "@group(1)", 1);
        let error = Module::new(&other_group).unwrap_err().to_string();
        assert!(error.contains("`scale` is in group 1"), "{error}");
    }
}
