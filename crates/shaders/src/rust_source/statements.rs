//! Statements of a function.

use naga::{Block, Expression, Handle, Statement, SwitchValue, TypeInner};

use super::expressions::Body;
use super::{Written, bare, unwritable};

impl Body<'_> {
    /// The whole function.
    pub(super) fn function(mut self) -> Written {
        let kind = |handle| self.module.kind(handle);
        let arguments = self.function.arguments.iter().zip(&self.arguments);
        let arguments = arguments
            .map(|(argument, name)| Ok(format!("{name}: {}", kind(argument.ty)?)))
            .collect::<Written<Vec<_>>>()?;
        let result = match &self.function.result {
            Some(result) => format!(" -> {}", kind(result.ty)?),
            None => String::new(),
        };
        let mut text = String::new();
        if !self.locals.is_empty() {
            text += "#[allow(unused_assignments, unused_comparisons, unused_mut)]\n";
        }
        let name = self.function.name.as_deref().unwrap_or_default();
        text += &format!("pub fn {name}({}){result} {{\n", arguments.join(", "));
        for (local, variable) in self.function.local_variables.iter() {
            let value = match variable.init {
                Some(init) => self.value(init)?,
                None => self.module.zero(variable.ty)?,
            };
            let (name, kind) = (&self.locals[&local], self.module.kind(variable.ty)?);
            text += &format!("    let mut {name}: {kind} = {value};\n");
        }
        self.block(&self.function.body, 1, &mut text)?;
        text += "}\n";
        Ok(text)
    }

    fn bake(&mut self, handle: Handle<Expression>, value: &str, indent: &str, text: &mut String) {
        let given = self.function.named_expressions.get(&handle).cloned();
        let name = self.unique(&given.unwrap_or_else(|| format!("v{}", handle.index())));
        *text += &format!("{indent}let {name} = {value};\n");
        self.baked.insert(handle, name);
    }

    fn block(&mut self, block: &Block, depth: usize, text: &mut String) -> Written<()> {
        block.iter().try_for_each(|statement| self.statement(statement, depth, text))
    }

    fn statement(&mut self, statement: &Statement, depth: usize, text: &mut String) -> Written<()> {
        let indent = "    ".repeat(depth);
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let expression = &self.function.expressions[handle];
                    let is_pointer = matches!(self.inner(handle), TypeInner::Pointer { .. });
                    let uses = self.module.info[self.handle][handle].ref_count;
                    let named = self.function.named_expressions.contains_key(&handle);
                    let is_load = matches!(expression, Expression::Load { .. });
                    if !is_pointer && (named || is_load || (uses > 1 && !is_part(expression))) {
                        let value = self.written(handle)?;
                        self.bake(handle, bare(&value), &indent, text);
                    }
                }
            }
            Statement::Block(inner) => {
                *text += &format!("{indent}{{\n");
                self.block(inner, depth + 1, text)?;
                *text += &format!("{indent}}}\n");
            }
            Statement::If { condition, accept, reject } => {
                let condition = self.value(*condition)?;
                *text += &format!("{indent}if {} {{\n", bare(&condition));
                self.block(accept, depth + 1, text)?;
                if !reject.is_empty() {
                    *text += &format!("{indent}}} else {{\n");
                    self.block(reject, depth + 1, text)?;
                }
                *text += &format!("{indent}}}\n");
            }
            Statement::Loop { body, continuing, break_if } => {
                self.loops += 1;
                let is_labelled = has_continue(body) && !(continuing.is_empty() && break_if.is_none());
                self.labels.push(is_labelled.then_some(self.loops));
                if is_labelled {
                    let number = self.loops;
                    *text += &format!("{indent}'loop{number}: loop {{\n{indent}    'body{number}: {{\n");
                    self.block(body, depth + 2, text)?;
                    *text += &format!("{indent}    }}\n");
                } else {
                    *text += &format!("{indent}loop {{\n");
                    self.block(body, depth + 1, text)?;
                }
                self.labels.pop();
                self.block(continuing, depth + 1, text)?;
                if let Some(condition) = break_if {
                    let condition = self.value(*condition)?;
                    *text +=
                        &format!("{indent}    if {condition} {{\n{indent}        break;\n{indent}    }}\n");
                }
                *text += &format!("{indent}}}\n");
            }
            Statement::Break => match self.labels.last() {
                Some(Some(number)) => *text += &format!("{indent}break 'loop{number};\n"),
                Some(None) | None => *text += &format!("{indent}break;\n"),
            },
            Statement::Continue => match self.labels.last() {
                Some(Some(number)) => *text += &format!("{indent}break 'body{number};\n"),
                Some(None) | None => *text += &format!("{indent}continue;\n"),
            },
            Statement::Return { value: Some(value) } => {
                let value = self.value(*value)?;
                *text += &format!("{indent}return {};\n", bare(&value));
            }
            Statement::Return { value: None } => *text += &format!("{indent}return;\n"),
            Statement::Store { pointer, value } => {
                let (place, value) = (self.value(*pointer)?, self.value(*value)?);
                let whole = matches!(self.function.expressions[*pointer], Expression::FunctionArgument(_));
                let star = if whole { "*" } else { "" };
                *text += &format!("{indent}{star}{place} = {};\n", bare(&value));
            }
            Statement::Call { function, arguments, result } => {
                let name = self.module.module.functions[*function].name.clone().unwrap_or_default();
                let of = |&argument: &Handle<Expression>| {
                    let value = self.value(argument)?;
                    let local = matches!(self.function.expressions[argument], Expression::LocalVariable(_));
                    Ok(if local { format!("&mut {value}") } else { bare(&value).to_owned() })
                };
                let arguments = arguments.iter().map(of).collect::<Written<Vec<_>>>()?;
                let call = format!("{name}({})", arguments.join(", "));
                match result {
                    Some(result) => self.bake(*result, &call, &indent, text),
                    None => *text += &format!("{indent}{call};\n"),
                }
            }
            Statement::Switch { selector, cases } => {
                *text += &format!("{indent}match {} {{\n", self.value(*selector)?);
                for case in cases {
                    if case.fall_through && !case.body.is_empty() {
                        return unwritable("a case that falls through");
                    }
                    let value = match case.value {
                        SwitchValue::I32(value) => format!("{value}i32"),
                        SwitchValue::U32(value) => format!("{value}u32"),
                        SwitchValue::Default => "_".to_owned(),
                    };
                    *text += &format!("{indent}    {value} => {{\n");
                    self.block(&case.body, depth + 2, text)?;
                    *text += &format!("{indent}    }}\n");
                }
                *text += &format!("{indent}}}\n");
            }
            other => return unwritable(format!("the statement {other:?}")),
        }
        Ok(())
    }
}

/// Components and members cost nothing to be named again.
fn is_part(expression: &Expression) -> bool {
    matches!(
        expression,
        Expression::AccessIndex { .. }
            | Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::ZeroValue(_)
    )
}

fn has_continue(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Continue => true,
        Statement::Block(inner) => has_continue(inner),
        Statement::If { accept, reject, .. } => has_continue(accept) || has_continue(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| has_continue(&case.body)),
        _ => false,
    })
}
