//! The lines of Wavefront OBJ and MTL files: keyword, arguments, and numbers with errors that name the line.

use crate::error::FileFault;

/// One statement, comments removed and continued lines joined.
pub(super) struct Statement<'a> {
    /// One-based line on which it starts.
    pub line: usize,
    pub keyword: &'a str,
    pub arguments: &'a str,
}

/// Calls `each` for every statement, in order, until it fails.
pub(super) fn statements(
    text: &str,
    mut each: impl FnMut(Statement) -> Result<(), FileFault>,
) -> Result<(), FileFault> {
    let mut joined = String::new();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let mut whole = line;
        if line.ends_with('\\') {
            joined.clear();
            joined.push_str(line.trim_end_matches('\\'));
            for (_, next) in lines.by_ref() {
                joined.push(' ');
                joined.push_str(next.trim_end_matches('\\'));
                if !next.ends_with('\\') {
                    break;
                }
            }
            whole = &joined;
        }
        let content = whole.split('#').next().unwrap_or_default().trim();
        let (keyword, arguments) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        if !keyword.is_empty() {
            each(Statement { line: number + 1, keyword, arguments: arguments.trim() })?;
        }
    }
    Ok(())
}

impl Statement<'_> {
    pub(super) fn at(&self) -> String {
        format!("line {}", self.line)
    }

    pub(super) fn invalid(&self, problem: impl AsRef<str>) -> FileFault {
        FileFault::invalid(self.at(), problem)
    }

    /// The first `N` numbers; all but the first `required` default to zero.
    pub(super) fn numbers<const N: usize>(&self, required: usize) -> Result<[f64; N], FileFault> {
        let mut numbers = [0.0; N];
        let mut words = self.arguments.split_whitespace();
        for (i, slot) in numbers.iter_mut().enumerate() {
            match words.next() {
                Some(word) => {
                    *slot = word.parse().map_err(|_| {
                        self.invalid(format!("{} with {word:?}, which is no number", self.keyword))
                    })?;
                }
                None if i < required => {
                    return Err(self.invalid(format!("{} with {i} of {required} numbers", self.keyword)));
                }
                None => break,
            }
        }
        Ok(numbers)
    }
}
