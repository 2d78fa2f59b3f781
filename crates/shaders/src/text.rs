//! WGSL text by its declarations: what a function needs, laid out for people, and its comments carried to other languages.

use std::collections::{HashMap, HashSet};

/// A declaration with the comments and blank lines before it.
struct Declaration<'a> {
    name: &'a str,
    lines: Vec<&'a str>,
}

impl Declaration<'_> {
    /// Comment lines directly before it.
    fn comment(&self) -> Vec<&str> {
        let first = self.lines.iter().position(|line| !is_remark(line)).unwrap_or(self.lines.len());
        let start =
            self.lines[..first].iter().rposition(|line| line.trim().is_empty()).map_or(0, |blank| blank + 1);
        self.lines[start..first].to_vec()
    }
}

fn is_remark(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with("//")
}

fn code(line: &str) -> &str {
    line.split_once("//").map_or(line, |(code, _)| code)
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// The name that a line of code declares, if it begins a declaration.
fn declared(line: &str) -> Option<&str> {
    const KEYWORDS: [&str; 5] = ["fn", "const", "struct", "alias", "var"];
    // `@group(0) @binding(1) var<storage, read> name: ...` and `@fragment fn name(`.
    let mut rest = code(line);
    loop {
        rest = rest.trim_start();
        let Some(attribute) = rest.strip_prefix('@') else { break };
        let name = attribute.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
        rest = match name.trim_start().strip_prefix('(') {
            Some(arguments) => arguments.split_once(')')?.1,
            None => name,
        };
    }
    let keyword = words(rest).next().filter(|word| KEYWORDS.contains(word))?;
    let mut after = rest.trim_start().strip_prefix(keyword)?.trim_start();
    if let Some(space) = after.strip_prefix('<') {
        after = space.split_once('>')?.1;
    }
    words(after).next()
}

fn declarations(text: &str) -> Vec<Declaration<'_>> {
    let mut all = Vec::new();
    let (mut lines, mut name, mut depth) = (Vec::new(), None, 0i32);
    for line in text.lines() {
        lines.push(line);
        if is_remark(line) {
            continue;
        }
        if depth == 0 {
            name = name.or_else(|| declared(line));
        }
        for character in code(line).chars() {
            match character {
                '{' | '(' => depth += 1,
                '}' | ')' => depth -= 1,
                _ => {}
            }
        }
        let ends = code(line).trim_end().ends_with([';', '}']);
        if depth == 0
            && ends
            && let Some(name) = name.take()
        {
            all.push(Declaration { name, lines: std::mem::take(&mut lines) });
        }
    }
    all
}

/// The declarations of a module that some of them need, and these, in the module's order.
pub fn reachable(text: &str, roots: &[&str]) -> String {
    let all = declarations(text);
    let by_name: HashMap<&str, usize> = all.iter().enumerate().map(|(i, one)| (one.name, i)).collect();
    let mut open: Vec<usize> = roots.iter().filter_map(|root| by_name.get(root).copied()).collect();
    let mut needed: HashSet<usize> = open.iter().copied().collect();
    while let Some(next) = open.pop() {
        let used = all[next].lines.iter().flat_map(|line| words(code(line)));
        for other in used.filter_map(|word| by_name.get(word).copied()) {
            if needed.insert(other) {
                open.push(other);
            }
        }
    }
    let kept = all.iter().enumerate().filter(|(i, _)| needed.contains(i));
    kept.flat_map(|(_, one)| &one.lines).map(|line| format!("{line}\n")).collect()
}

/// Indented by depth, a blank line around every function and none within.
pub fn laid_out(text: &str) -> String {
    let mut written = String::new();
    let (mut depth, mut blank) = (0usize, true);
    for line in text.lines().map(str::trim) {
        if line.is_empty() {
            if depth == 0 && !blank {
                written.push('\n');
                blank = true;
            }
            continue;
        }
        let count = |of: &[char]| code(line).matches(of).count();
        let closing = line.chars().take_while(|c| ['}', ')', ' '].contains(c)).filter(|c| *c != ' ').count();
        written += &"    ".repeat(depth.saturating_sub(closing));
        written += line;
        written.push('\n');
        depth = (depth + count(&['{', '('])).saturating_sub(count(&['}', ')']));
        blank = false;
        if depth == 0 && line.ends_with('}') {
            written.push('\n');
            blank = true;
        }
    }
    written.truncate(written.trim_end().len());
    written.push('\n');
    written
}

/// Puts the comments of WGSL functions before the functions of the same names in a translation.
pub fn with_comments(translation: &str, wgsl: &str) -> String {
    let all = declarations(wgsl);
    let comments: HashMap<&str, Vec<&str>> = all.iter().map(|one| (one.name, one.comment())).collect();
    let mut written = String::new();
    for line in translation.lines() {
        // Definitions start at the margin; declarations end in a semicolon.
        let starts =
            !line.starts_with([' ', '\t', '}', '/', '#']) && line.contains('(') && !line.ends_with(';');
        let name = line.split_once('(').and_then(|(head, _)| words(head).last()).filter(|_| starts);
        // Names that end in a digit get an underscore.
        let found =
            name.and_then(|name| comments.get(name).or_else(|| comments.get(name.strip_suffix('_')?)));
        for comment in found.into_iter().flatten() {
            written += comment.trim();
            written.push('\n');
        }
        written += line;
        written.push('\n');
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
// About everything.

const LENGTH: u32 = 2u;
// Not wanted { by anyone.
const OTHER: f32 = 1.0;
@group(0) @binding(3) var<storage, read> inputs: array<f32>;

// Half of it.
fn half(x: f32) -> f32 {
{ let y = x;
      }
{ let z = OTHER_; }
    return 0.5 * x; // OTHER
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x > LENGTH { return; }
}

fn first() -> f32 { return half(inputs[0]); }
";

    #[test]
    fn a_function_takes_along_what_it_needs() {
        let kept = reachable(SOURCE, &["first"]);
        for part in ["var<storage, read> inputs", "// Half of it.\nfn half", "fn first"] {
            assert!(kept.contains(part), "`{part}` in {kept}");
        }
        for part in ["OTHER: f32", "fn main", "LENGTH"] {
            assert!(!kept.contains(part), "`{part}` in {kept}");
        }
        assert!(reachable(SOURCE, &["main"]).contains("// About everything.\n\nconst LENGTH"));
    }

    #[test]
    fn lines_are_indented_by_depth() {
        let text = laid_out(SOURCE);
        assert!(text.contains("{\n    { let y = x;\n    }\n    { let z = OTHER_; }\n    return"), "{text}");
        assert!(text.ends_with("}\n") && !text.contains("\n\n\n"), "{text}");
    }

    #[test]
    fn comments_follow_their_functions() {
        let text = "float half_(float x)\n{\n}\nfloat first() {\n}\n";
        assert_eq!(with_comments(text, SOURCE), format!("// Half of it.\n{text}"));
    }
}
