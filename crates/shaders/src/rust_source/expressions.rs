//! Expressions of a function.

use std::collections::{HashMap, HashSet};

use naga::{
    BinaryOperator as Op, Expression, Function, Handle, LocalVariable, MathFunction, ScalarKind, TypeInner,
    UnaryOperator,
};

use super::{Written, bare, literal_text, scalar_name, unwritable};
use crate::Module;

/// Words that WGSL allows as names and Rust does not.
const RESERVED: [&str; 12] =
    ["as", "box", "crate", "dyn", "in", "loop", "match", "move", "mut", "ref", "type", "use"];

/// A function as it is written.
pub(super) struct Body<'a> {
    pub(super) module: &'a Module,
    pub(super) function: &'a Function,
    pub(super) handle: Handle<Function>,
    taken: HashSet<String>,
    pub(super) arguments: Vec<String>,
    pub(super) locals: HashMap<Handle<LocalVariable>, String>,
    /// Expressions that have a variable of their own.
    pub(super) baked: HashMap<Handle<Expression>, String>,
    pub(super) loops: usize,
    /// Of the loops around a statement: their numbers where `continue` has to run what follows the body.
    pub(super) labels: Vec<Option<usize>>,
}

impl<'a> Body<'a> {
    pub(super) fn new(module: &'a Module, handle: Handle<Function>, function: &'a Function) -> Written<Self> {
        let names = |name: &Option<String>| name.clone().unwrap_or_default();
        let functions = module.module.functions.iter().map(|(_, other)| names(&other.name));
        let mut body = Self {
            module,
            function,
            handle,
            taken: functions.chain(RESERVED.map(str::to_owned)).collect(),
            arguments: Vec::new(),
            locals: HashMap::new(),
            baked: HashMap::new(),
            loops: 0,
            labels: Vec::new(),
        };
        for argument in &function.arguments {
            let name = body.unique(argument.name.as_deref().unwrap_or("argument"));
            body.arguments.push(name);
        }
        for (local, variable) in function.local_variables.iter() {
            let name = body.unique(variable.name.as_deref().unwrap_or("local"));
            body.locals.insert(local, name);
        }
        Ok(body)
    }

    pub(super) fn unique(&mut self, name: &str) -> String {
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let free = std::iter::once(name.to_owned()).chain(numbered).find(|name| !self.taken.contains(name));
        let free = free.unwrap_or_default();
        self.taken.insert(free.clone());
        free
    }

    pub(super) fn inner(&self, expression: Handle<Expression>) -> &TypeInner {
        self.module.info[self.handle][expression].ty.inner_with(&self.module.module.types)
    }

    /// Components of a vector, 0 for anything else.
    fn size(&self, expression: Handle<Expression>) -> usize {
        match self.inner(expression) {
            TypeInner::Vector { size, .. } => *size as usize,
            _ => 0,
        }
    }

    /// By the name of its variable, else written out.
    pub(super) fn value(&self, handle: Handle<Expression>) -> Written {
        match self.baked.get(&handle) {
            Some(name) => Ok(name.clone()),
            None => self.written(handle),
        }
    }

    fn values(&self, handles: &[Handle<Expression>]) -> Written<Vec<String>> {
        handles.iter().map(|handle| self.value(*handle)).collect()
    }

    /// An operation on each component, scalars standing for all.
    fn each(&self, operands: &[Handle<Expression>], of: impl Fn(&[String]) -> String) -> Written {
        let size = operands.iter().map(|&operand| self.size(operand)).max().unwrap_or(0);
        let values = self.values(operands)?;
        if size == 0 {
            return Ok(of(&values));
        }
        let component = |k: usize| -> String {
            let parts: Vec<String> = (values.iter().zip(operands))
                .map(
                    |(value, &operand)| {
                        if self.size(operand) == 0 { value.clone() } else { format!("{value}[{k}]") }
                    },
                )
                .collect();
            of(&parts)
        };
        Ok(format!("[{}]", (0..size).map(component).collect::<Vec<_>>().join(", ")))
    }

    pub(super) fn written(&self, handle: Handle<Expression>) -> Written {
        Ok(match &self.function.expressions[handle] {
            Expression::Literal(literal) => literal_text(*literal)?,
            Expression::Constant(constant) => self.module.constant(*constant)?,
            Expression::ZeroValue(kind) => self.module.zero(*kind)?,
            Expression::Compose { ty, components } => {
                let module = &self.module.module;
                let values = self.values(components)?;
                match &module.types[*ty].inner {
                    TypeInner::Struct { members, .. } => {
                        let fields = members.iter().zip(values);
                        let of = |(m, v): (&naga::StructMember, String)| {
                            format!("{}: {v}", m.name.as_deref().unwrap_or("field"))
                        };
                        let name = module.types[*ty].name.as_deref().unwrap_or_default();
                        format!("{name} {{ {} }}", fields.map(of).collect::<Vec<_>>().join(", "))
                    }
                    TypeInner::Vector { .. } => {
                        let mut all = Vec::new();
                        for (&part, value) in components.iter().zip(values) {
                            match self.size(part) {
                                0 => all.push(value),
                                size => all.extend((0..size).map(|k| format!("{value}[{k}]"))),
                            }
                        }
                        format!("[{}]", all.join(", "))
                    }
                    _ => format!("[{}]", values.join(", ")),
                }
            }
            Expression::Splat { size, value } => format!("[{}; {}]", self.value(*value)?, *size as u32),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = self.value(*vector)?;
                let parts =
                    pattern[..*size as usize].iter().map(|part| format!("{vector}[{}]", *part as u32));
                format!("[{}]", parts.collect::<Vec<_>>().join(", "))
            }
            Expression::Access { base, index } => {
                format!("{}[{} as usize]", self.value(*base)?, self.value(*index)?)
            }
            Expression::AccessIndex { base, index } => {
                let value = self.value(*base)?;
                let types = &self.module.module.types;
                let inner = match self.inner(*base) {
                    TypeInner::Pointer { base, .. } => &types[*base].inner,
                    other => other,
                };
                match inner {
                    TypeInner::Struct { members, .. } => {
                        format!("{value}.{}", members[*index as usize].name.as_deref().unwrap_or("field"))
                    }
                    _ => format!("{value}[{index}]"),
                }
            }
            Expression::FunctionArgument(index) => self.arguments[*index as usize].clone(),
            Expression::LocalVariable(local) => self.locals[local].clone(),
            Expression::Load { pointer } => match &self.function.expressions[*pointer] {
                Expression::FunctionArgument(_) => format!("*{}", self.value(*pointer)?),
                _ => self.value(*pointer)?,
            },
            Expression::Unary { op, expr } => {
                let sign = match op {
                    UnaryOperator::Negate => "-",
                    UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot => "!",
                };
                self.each(&[*expr], |v| format!("({sign}{})", v[0]))?
            }
            Expression::Binary { op, left, right } => {
                let sign = operator(*op);
                self.each(&[*left, *right], |v| format!("({} {sign} {})", v[0], v[1]))?
            }
            Expression::Select { condition, accept, reject } => self
                .each(&[*condition, *accept, *reject], |v| {
                    format!("(if {} {{ {} }} else {{ {} }})", bare(&v[0]), bare(&v[1]), bare(&v[2]))
                })?,
            Expression::Math { fun, arg, arg1, arg2, arg3: None } => {
                let operands: Vec<_> = [Some(*arg), *arg1, *arg2].into_iter().flatten().collect();
                let method = match fun {
                    MathFunction::Abs => "abs",
                    MathFunction::Min => "min",
                    MathFunction::Max => "max",
                    MathFunction::Clamp => "clamp",
                    MathFunction::Sqrt => "sqrt",
                    MathFunction::Floor => "floor",
                    MathFunction::Round => "round_ties_even",
                    other => return unwritable(format!("the function {other:?}")),
                };
                self.each(&operands, |v| {
                    let rest: Vec<&str> = v[1..].iter().map(|value| bare(value)).collect();
                    format!("{}.{method}({})", receiver(&v[0]), rest.join(", "))
                })?
            }
            Expression::As { expr, kind, convert } => {
                let from = self.inner(*expr).scalar().map(|scalar| scalar.kind);
                let name = scalar_name(*kind)?;
                match (convert, from, kind) {
                    (Some(_), _, ScalarKind::Bool) => return unwritable("a number as a condition"),
                    (Some(_), Some(ScalarKind::Bool), ScalarKind::Float) => {
                        self.each(&[*expr], |v| format!("(if {} {{ 1.0 }} else {{ 0.0 }})", v[0]))?
                    }
                    (Some(_), _, _) => self.each(&[*expr], |v| format!("({} as {name})", v[0]))?,
                    (None, Some(ScalarKind::Float), _) => {
                        self.each(&[*expr], |v| format!("{}.to_bits()", v[0]))?
                    }
                    (None, _, ScalarKind::Float) => {
                        self.each(&[*expr], |v| format!("f32::from_bits({})", bare(&v[0])))?
                    }
                    (None, _, _) => self.each(&[*expr], |v| format!("({} as {name})", v[0]))?,
                }
            }
            other => return unwritable(format!("the expression {other:?}")),
        })
    }
}

/// Numbers need their type where a method is called on them.
fn receiver(value: &str) -> String {
    if value.parse::<f32>().is_ok() { format!("{value}f32") } else { value.to_owned() }
}

fn operator(op: Op) -> &'static str {
    match op {
        Op::Add => "+",
        Op::Subtract => "-",
        Op::Multiply => "*",
        Op::Divide => "/",
        Op::Modulo => "%",
        Op::Equal => "==",
        Op::NotEqual => "!=",
        Op::Less => "<",
        Op::LessEqual => "<=",
        Op::Greater => ">",
        Op::GreaterEqual => ">=",
        Op::And => "&",
        Op::ExclusiveOr => "^",
        Op::InclusiveOr => "|",
        Op::LogicalAnd => "&&",
        Op::LogicalOr => "||",
        Op::ShiftLeft => "<<",
        Op::ShiftRight => ">>",
    }
}
