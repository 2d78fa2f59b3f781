//! What can go wrong between a scene's name and its triangles, told in one line.

/// Why a scene or a list of light views could not be loaded. `Display` is one line without a line break.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The specification is neither a procedural scene nor a path with a known extension.
    #[error(
        "unknown scene {spec:?}: expected stairs, village, grove, hall, smoke, glasshouse or grids, or a path ending in .glb, .gltf or \
         .obj"
    )]
    UnknownScene {
        /// What was asked for.
        spec: String,
    },
    /// A file was found wanting.
    #[error("{file}: {fault}")]
    File {
        /// The file as it was named by the user; line breaks are escaped.
        file: String,
        /// What is wrong with it.
        fault: FileFault,
    },
}

/// Why a scene in memory cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum InvalidScene {
    /// It has no triangles.
    #[error("scene '{0}' has no triangles")]
    Empty(String),
    /// A list refers to something that is not there, or a number is not finite.
    #[error("scene '{scene}' is inconsistent: {what}")]
    Inconsistent {
        /// Name of the scene.
        scene: String,
        /// What is wrong, with index and value.
        what: String,
    },
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum FileFault {
    /// It, or a file that it names, cannot be read.
    #[error("cannot read: {problem}")]
    Unreadable {
        /// The operating system's words, or why reading was refused.
        problem: String,
    },
    /// Contents that break the format, or values outside their domain.
    #[error("{at}: {problem}")]
    Invalid {
        /// Place inside the file, such as `accessors[3]` or `line 12`.
        at: String,
        /// The offending value and what was expected.
        problem: String,
    },
    /// An index that names nothing.
    #[error("{at}: index {index} is out of range, there are {count}")]
    IndexOutOfRange {
        /// Place inside the file.
        at: String,
        /// The index as written, zero-based for glTF and one-based (or negative) for OBJ.
        index: i64,
        /// How many elements exist.
        count: u64,
    },
    /// A vector with a component that is NaN, infinite or larger than 1e15.
    #[error("{at}: value {value:?} is not finite or exceeds {limit:e}", limit = crate::scene::MAX_COORDINATE)]
    NotFinite {
        /// Place inside the file.
        at: String,
        /// The vector.
        value: [f64; 3],
    },
    /// More of something than this loader accepts.
    #[error("{at}: {count} {what} exceed the limit of {limit}")]
    TooMany {
        /// Place inside the file.
        at: String,
        /// What is counted, in the plural.
        what: &'static str,
        /// How many the file claims.
        count: u64,
        /// How many are accepted.
        limit: u64,
    },
    /// A valid file that needs something this loader does not do.
    #[error("{at}: unsupported {feature}")]
    Unsupported {
        /// Place inside the file.
        at: String,
        /// What would be needed.
        feature: String,
    },
    /// No triangle is left to render.
    #[error("no triangles: the file holds {}", contents(*degenerate, holds))]
    Empty {
        /// Triangles without area that were dropped.
        degenerate: usize,
        /// What else there is, such as `lines`; empty for nothing.
        holds: String,
    },
    /// A warning where none was wanted.
    #[error("{first}{}", more(*count))]
    Strict {
        /// The first warning.
        first: String,
        /// How many there are.
        count: usize,
    },
}

fn contents(degenerate: usize, holds: &str) -> String {
    match (degenerate, holds) {
        (0, "") => "no geometry".to_owned(),
        (0, holds) => format!("only {holds}"),
        (degenerate, "") => format!("{degenerate} degenerate triangles and no other"),
        (degenerate, holds) => format!("{degenerate} degenerate triangles and {holds}"),
    }
}

fn more(count: usize) -> String {
    match count {
        0 | 1 => " (a warning, refused as strictness was asked for)".to_owned(),
        count => format!(" (and {} more warnings, refused as strictness was asked for)", count - 1),
    }
}

impl FileFault {
    /// `problem` may quote the file: it is cut to a readable length and its line breaks are escaped.
    pub(crate) fn invalid(at: impl Into<String>, problem: impl AsRef<str>) -> Self {
        Self::Invalid { at: at.into(), problem: one_line(problem.as_ref()) }
    }

    pub(crate) fn unreadable(problem: impl AsRef<str>) -> Self {
        Self::Unreadable { problem: one_line(problem.as_ref()) }
    }

    pub(crate) fn unsupported(at: impl Into<String>, feature: impl AsRef<str>) -> Self {
        Self::Unsupported { at: at.into(), feature: one_line(feature.as_ref()) }
    }

    pub(crate) fn in_file(self, file: &str) -> SceneError {
        SceneError::File { file: escape_control(file), fault: self }
    }
}

/// Longest text quoted from a file, in characters.
const QUOTE_LIMIT: usize = 240;

pub(crate) fn one_line(text: &str) -> String {
    let mut line: String = text.chars().take(QUOTE_LIMIT).collect();
    if text.chars().nth(QUOTE_LIMIT).is_some() {
        line.push('…');
    }
    escape_control(&line)
}

fn escape_control(text: &str) -> String {
    text.chars()
        .flat_map(|c| {
            let escaped: Box<dyn Iterator<Item = char>> =
                if c.is_control() { Box::new(c.escape_default()) } else { Box::new(std::iter::once(c)) };
            escaped
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_text_stays_on_one_line_and_short() {
        let fault = FileFault::invalid("line 1", format!("bad\nvalue \u{1b}[31m{}", "x".repeat(10_000)));
        let message = fault.in_file("a\nb.obj").to_string();
        assert!(message.starts_with("a\\nb.obj: line 1: bad\\nvalue \\u{1b}[31mxxx"), "{message}");
        assert!(message.len() < 400 && !message.contains('\n'));
    }
}
