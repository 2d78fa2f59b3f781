//! Functions of a module as Rust that needs no crate: vectors and arrays are arrays, pointers are mutable references.

mod expressions;
mod statements;

use expressions::Body;
use naga::{ArraySize, Expression, Handle, Literal, ScalarKind, Type, TypeInner};

use crate::{Module, ShaderError};

type Written<T = String> = Result<T, ShaderError>;

fn unwritable<T>(problem: impl Into<String>) -> Written<T> {
    Err(ShaderError::Unwritable { language: "Rust", problem: problem.into() })
}

impl Module {
    /// Constants, structures and functions in single precision; entry points and what reads textures or buffers are left
    /// to whoever calls them.
    ///
    /// # Errors
    /// [`ShaderError::Unwritable`] for functions of resources, matrices and what else Rust has no operator for.
    pub fn rust(&self) -> Result<String, ShaderError> {
        let mut text = String::new();
        for (_, constant) in self.module.constants.iter() {
            if let Some(name) = &constant.name {
                let value = self.global(constant.init)?;
                text += &format!("pub const {name}: {} = {value};\n", self.kind(constant.ty)?);
            }
        }
        for (_, kind) in self.module.types.iter() {
            if let (Some(name), TypeInner::Struct { members, .. }) = (&kind.name, &kind.inner) {
                text += &format!("\n#[derive(Clone, Copy, Debug, PartialEq)]\npub struct {name} {{\n");
                for member in members {
                    let field = member.name.as_deref().unwrap_or("field");
                    text += &format!("    pub {field}: {},\n", self.kind(member.ty)?);
                }
                text += "}\n";
            }
        }
        for (handle, function) in self.module.functions.iter() {
            text.push('\n');
            text += &Body::new(self, handle, function)?.function()?;
        }
        Ok(text)
    }

    fn kind(&self, handle: Handle<Type>) -> Written {
        let kind = &self.module.types[handle];
        Ok(match &kind.inner {
            TypeInner::Scalar(scalar) => scalar_name(scalar.kind)?.to_owned(),
            TypeInner::Vector { size, scalar } => {
                format!("[{}; {}]", scalar_name(scalar.kind)?, *size as u32)
            }
            TypeInner::Array { base, size: ArraySize::Constant(size), .. } => {
                format!("[{}; {size}]", self.kind(*base)?)
            }
            TypeInner::Struct { .. } => kind.name.clone().unwrap_or_default(),
            TypeInner::Pointer { base, .. } => format!("&mut {}", self.kind(*base)?),
            other => return unwritable(format!("the type {other:?}")),
        })
    }

    fn zero(&self, handle: Handle<Type>) -> Written {
        let kind = &self.module.types[handle];
        Ok(match &kind.inner {
            TypeInner::Scalar(scalar) => zero_of(scalar.kind).to_owned(),
            TypeInner::Vector { size, scalar } => format!("[{}; {}]", zero_of(scalar.kind), *size as u32),
            TypeInner::Array { base, size: ArraySize::Constant(size), .. } => {
                format!("[{}; {size}]", self.zero(*base)?)
            }
            TypeInner::Struct { members, .. } => {
                let of = |m: &naga::StructMember| {
                    Ok(format!("{}: {}", m.name.as_deref().unwrap_or("field"), self.zero(m.ty)?))
                };
                let fields = members.iter().map(of).collect::<Written<Vec<_>>>()?;
                format!("{} {{ {} }}", kind.name.as_deref().unwrap_or_default(), fields.join(", "))
            }
            other => return unwritable(format!("a zero of the type {other:?}")),
        })
    }

    fn global(&self, handle: Handle<Expression>) -> Written {
        match &self.module.global_expressions[handle] {
            Expression::Literal(literal) => literal_text(*literal),
            Expression::Constant(constant) => self.constant(*constant),
            Expression::ZeroValue(kind) => self.zero(*kind),
            Expression::Compose { components, .. } => {
                let parts = components.iter().map(|part| self.global(*part));
                Ok(format!("[{}]", parts.collect::<Written<Vec<_>>>()?.join(", ")))
            }
            Expression::Splat { size, value } => Ok(format!("[{}; {}]", self.global(*value)?, *size as u32)),
            other => unwritable(format!("the constant {other:?}")),
        }
    }

    fn constant(&self, handle: Handle<naga::Constant>) -> Written {
        let constant = &self.module.constants[handle];
        constant.name.clone().map_or_else(|| self.global(constant.init), Ok)
    }
}

fn scalar_name(kind: ScalarKind) -> Written<&'static str> {
    match kind {
        ScalarKind::Float => Ok("f32"),
        ScalarKind::Sint => Ok("i32"),
        ScalarKind::Uint => Ok("u32"),
        ScalarKind::Bool => Ok("bool"),
        ScalarKind::AbstractInt | ScalarKind::AbstractFloat => unwritable("a number without a type"),
    }
}

fn zero_of(kind: ScalarKind) -> &'static str {
    match kind {
        ScalarKind::Float | ScalarKind::AbstractFloat => "0.0",
        ScalarKind::Sint | ScalarKind::Uint | ScalarKind::AbstractInt => "0",
        ScalarKind::Bool => "false",
    }
}

fn literal_text(literal: Literal) -> Written {
    Ok(match literal {
        Literal::F32(value) => format!("{value:?}"),
        Literal::U32(value) => format!("{value}u32"),
        Literal::I32(value) if value < 0 => format!("({value}i32)"),
        Literal::I32(value) => format!("{value}i32"),
        Literal::Bool(value) => value.to_string(),
        other => return unwritable(format!("the number {other:?}")),
    })
}

/// Without the parentheses around all of it.
fn bare(value: &str) -> &str {
    let Some(inner) = value.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) else { return value };
    let mut depth = 0i32;
    let closes_early = inner.chars().any(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth < 0
    });
    if closes_early { value } else { inner }
}
