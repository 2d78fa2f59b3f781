//! WGSL loops with constant bounds written out.
//!
//! An array that a loop indexes stays in memory on a graphics processor, and the counters that naga adds so that no loop
//! runs for ever keep drivers from unrolling it themselves. Written out, arrays become registers.

use std::collections::HashMap;

/// A loop that would become longer than so many characters stays: the taps of PCF with a wide kernel, which would take
/// seconds to compile.
const MAX_LENGTH: usize = 40_000;

/// Writes out every loop `for (var i = A; i < B; i++)` (also `<=`, `>`, `>=`, `i--`) whose bounds are constant, from the
/// outermost to the innermost so that inner bounds may depend on outer counters. Loops with `break` or `continue`, and
/// loops that would become too long, keep their form; the loops within them are written out.
pub fn unroll(text: &str) -> String {
    let mut constants = HashMap::new();
    for line in text.lines() {
        if let Some((name, value)) = constant(line, &constants) {
            constants.insert(name, value);
        }
    }
    expand(text, &constants)
}

/// The value of `const NAME: u32 = ...;` or of an `i32`.
fn constant(line: &str, known: &HashMap<String, i64>) -> Option<(String, i64)> {
    let (name, rest) = line.strip_prefix("const ")?.split_once(':')?;
    let (kind, value) = rest.split_once('=')?;
    if !matches!(kind.trim(), "u32" | "i32") {
        return None;
    }
    Some((name.trim().to_owned(), evaluate(value.trim().strip_suffix(';')?, known)?))
}

/// A sum of products of integers and known names, such as `k + 1u` or `2u * LAYERS`.
fn evaluate(expression: &str, known: &HashMap<String, i64>) -> Option<i64> {
    let expression = expression.trim();
    for (at, operator) in expression.char_indices().rev() {
        if operator == '+' || operator == '-' {
            let left = evaluate(&expression[..at], known)?;
            let right = evaluate(&expression[at + 1..], known)?;
            return Some(if operator == '+' { left + right } else { left - right });
        }
    }
    expression.split('*').try_fold(1, |product, factor| {
        let factor = factor.trim();
        let number = factor.strip_suffix('u').unwrap_or(factor).parse().ok();
        Some(product * number.or_else(|| known.get(factor).copied())?)
    })
}

struct Loop<'a> {
    counter: &'a str,
    values: Vec<i64>,
    unsigned: bool,
    body: &'a str,
}

fn expand(text: &str, constants: &HashMap<String, i64>) -> String {
    let Some(start) = text.find("for (var ") else { return text.to_owned() };
    let (before, rest) = text.split_at(start);
    let Some((header, body, after)) = parts(rest) else { return text.to_owned() };
    let mut whole = before.to_owned();
    match counted(header, body, constants) {
        Some(counted) => {
            let suffix = if counted.unsigned { "u" } else { "" };
            let written: Vec<String> = counted
                .values
                .iter()
                .map(|value| {
                    let body = replace_word(counted.body, counted.counter, &format!("{value}{suffix}"));
                    format!("{{{}}}", expand(&body, constants))
                })
                .collect();
            let length: usize = written.iter().map(String::len).sum();
            if length <= MAX_LENGTH {
                whole += &written.join("\n");
            } else {
                whole += &format!("{header}{{{}}}", expand(body, constants));
            }
        }
        None => whole += &format!("{header}{{{}}}", expand(body, constants)),
    }
    whole + &expand(after, constants)
}

/// Header up to the brace, body, and what follows.
fn parts(text: &str) -> Option<(&str, &str, &str)> {
    let open = text.find('{')?;
    let mut depth = 0;
    for (at, character) in text.char_indices().skip_while(|(at, _)| *at < open) {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some((&text[..open], &text[open + 1..at], &text[at + 1..]));
        }
    }
    None
}

fn counted<'a>(header: &'a str, body: &'a str, constants: &HashMap<String, i64>) -> Option<Loop<'a>> {
    if words(body).any(|word| word == "break" || word == "continue") {
        return None;
    }
    let inner = header.trim().strip_prefix("for (var ")?.strip_suffix(')')?;
    let mut clauses = inner.split(';').map(str::trim);
    let (start, condition, step) = (clauses.next()?, clauses.next()?, clauses.next()?);
    let (counter, start) = start.split_once('=')?;
    let counter = counter.trim();
    let first = evaluate(start, constants)?;
    let condition = condition.strip_prefix(counter)?.trim();
    let operator = &condition[..condition.find(|c: char| c != '<' && c != '>' && c != '=')?];
    let bound = evaluate(&condition[operator.len()..], constants)?;
    let change = match step.strip_prefix(counter)?.trim() {
        "++" => 1,
        "--" => -1,
        _ => return None,
    };
    let goes_on = |value: i64| match operator {
        "<" => value < bound,
        "<=" => value <= bound,
        ">" => value > bound,
        ">=" => value >= bound,
        _ => false,
    };
    let values = std::iter::successors(Some(first), |value| Some(value + change))
        .take_while(|&value| goes_on(value))
        .take(MAX_LENGTH)
        .collect();
    Some(Loop { counter, values, unsigned: start.trim().ends_with('u'), body })
}

fn is_word(character: char) -> bool {
    character.is_ascii_alphanumeric() || character == '_'
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c| !is_word(c))
}

/// `text` with every whole word `word` replaced; not the names of members after a dot.
fn replace_word(text: &str, word: &str, by: &str) -> String {
    let mut result = String::with_capacity(text.len());
    let mut written = 0;
    for (at, _) in text.match_indices(word) {
        let starts = !text[..at].ends_with(|c| is_word(c) || c == '.');
        let end = at + word.len();
        if starts && !text[end..].starts_with(is_word) {
            result += &text[written..at];
            result += by;
            written = end;
        }
    }
    result + &text[written..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_loops_are_written_out_with_their_own_bounds() {
        let text = "const N: u32 = 3u;\nconst M: u32 = 2u * N;\n\
                    for (var k = 1u; k < N; k++) { for (var i = k + 1u; i > 0u; i--) { a[i] = kk.k + b[k]; } }";
        let found = unroll(text);
        let lines: Vec<&str> = found.lines().skip(2).collect();
        let line = |i: u32, k: u32| format!("{{ a[{i}u] = kk.k + b[{k}u]; }}");
        let expected = [
            format!("{{ {}", line(2, 1)),
            format!("{} }}", line(1, 1)),
            format!("{{ {}", line(3, 2)),
            line(2, 2),
            format!("{} }}", line(1, 2)),
        ];
        assert_eq!(lines, expected);
        assert_eq!(unroll("const M: i32 = 2;\nfor (var i = 0; i <= M; i++) {i}").lines().nth(3), Some("{2}"));
    }

    #[test]
    fn what_cannot_be_written_out_stays() {
        let text = "for (var i = 0u; i < many; i++) { for (var j = 0; j < 2; j++) { a[j]; } }";
        assert_eq!(unroll(text), "for (var i = 0u; i < many; i++) { { a[0]; }\n{ a[1]; } }");
        let with_break = "for (var i = 0u; i < 9u; i++) { if done { break; } }";
        assert_eq!(unroll(with_break), with_break);
        let long = format!("for (var i = 0u; i < 100u; i++) {{ {} }}", "a = a + 1; ".repeat(100));
        assert_eq!(unroll(&long), long);
    }
}
