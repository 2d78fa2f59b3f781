//! A WGSL module in the language that was asked for.

use super::input;
use crate::outcome::Failure;
use anyhow::Context;
use clap::ValueEnum;
use shaders::{EntryPoint, Module, laid_out, with_comments};

/// What the file is written in.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, ValueEnum)]
pub(crate) enum Language {
    /// WebGPU shading language, in which all techniques are written.
    #[default]
    Wgsl,
    /// HLSL of shader model 5.0.
    Hlsl,
    /// GLSL 4.50; a macro such as ENTRY_FILTER_ROW chooses the entry point, the last one without.
    Glsl,
    /// Metal shading language 2.0.
    Msl,
    /// SPIR-V 1.0, binary, with all names.
    Spirv,
    /// Rust in single precision that needs no crate; without the fragment shaders.
    Rust,
}

impl Language {
    /// As on the command line.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Hlsl => "hlsl",
            Self::Glsl => "glsl",
            Self::Msl => "msl",
            Self::Spirv => "spirv",
            Self::Rust => "rust",
        }
    }

    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Hlsl => "hlsl",
            Self::Glsl => "glsl",
            Self::Msl => "metal",
            Self::Spirv => "spv",
            Self::Rust => "rs",
        }
    }

    /// The file: `head` before the text of a module; `pure` is what of it needs no textures.
    pub(super) fn translated(self, wgsl: &str, pure: &str, head: &str) -> Result<Vec<u8>, Failure> {
        let module = Module::new(wgsl).context("the assembled shader")?;
        let fail = |error: shaders::ShaderError| input(error.to_string());
        let text = match self {
            Self::Wgsl => laid_out(wgsl),
            Self::Hlsl => with_comments(&module.hlsl().map_err(fail)?, wgsl),
            Self::Msl => with_comments(&module.msl().map_err(fail)?, wgsl),
            Self::Glsl => return Ok(glsl(&module, wgsl, head).map_err(fail)?.into_bytes()),
            Self::Spirv => {
                return Ok(module
                    .spirv()
                    .map_err(fail)?
                    .iter()
                    .flat_map(|word| word.to_le_bytes())
                    .collect());
            }
            Self::Rust => {
                let functions = Module::new(pure).context("the assembled functions")?;
                with_comments(&functions.rust().map_err(fail)?, wgsl)
            }
        };
        Ok(format!("{head}\n{}", text.trim_start()).into_bytes())
    }
}

/// Each entry point behind a macro, as GLSL has one `main` a file.
fn glsl(module: &Module, wgsl: &str, head: &str) -> Result<String, shaders::ShaderError> {
    const VERSION: &str = "#version 450 core";
    let entries: Vec<&EntryPoint> = module.entry_points().iter().collect();
    let mut text = format!("{VERSION}\n{head}\n");
    let last = entries.len().saturating_sub(1);
    for (number, entry) in entries.into_iter().enumerate() {
        let translation = module.glsl(&entry.name)?;
        let (version, body) = translation.split_once('\n').unwrap_or((VERSION, ""));
        debug_assert_eq!(version, VERSION);
        if last > 0 {
            let name = format!("ENTRY_{}", entry.name.to_uppercase());
            text += &match number {
                0 => format!("#if defined({name})\n\n"),
                _ if number == last => format!("\n#else // {name}\n\n"),
                _ => format!("\n#elif defined({name})\n\n"),
            };
        }
        text += &with_comments(body.trim_start(), wgsl);
    }
    if last > 0 {
        text += "\n#endif\n";
    }
    Ok(text)
}
