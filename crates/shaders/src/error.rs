//! What can be wrong with a shader.

/// Why a shader cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// The text is no valid WGSL module, or one that no pass here could run.
    #[error("shader, line {line}: {problem}")]
    Invalid {
        /// Line of the assembled text, 1 for the first; 0 where the problem has no place.
        line: u32,
        /// The compiler's words.
        problem: String,
    },
    /// A valid module that another language cannot say.
    #[error("shader in {language}: {problem}")]
    Unwritable {
        /// The language.
        language: &'static str,
        /// What is in the way.
        problem: String,
    },
    /// There is no such entry point, or not exactly one where one is asked for.
    #[error("shader: expected an entry point {0}")]
    NoEntryPoint(String),
    /// Nothing is given for a resource that the shader reads or writes.
    #[error("shader: nothing is bound to `{0}`")]
    Unbound(String),
}
