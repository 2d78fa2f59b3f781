//! Shaders as text: WGSL constants, loops written out, validation without a graphics adapter, reflection of what a module
//! binds, export to other languages, and the modules that a shadowed frame is made of. Nothing here runs a shader.

mod constants;
mod error;
mod export;
mod frame;
mod module;
mod portable_hlsl;
mod rust_source;
mod text;
mod unroll;

pub use constants::{array, constant, count, flag, whole_numbers};
pub use error::ShaderError;
pub use frame::{ComputeShaders, FrameShaders, TexelFormat};
pub use module::{Binding, EntryPoint, Module, Stage, VertexInput};
pub use text::{laid_out, reachable, with_comments};
pub use unroll::unroll;
