//! What a verb leaves behind: its result on standard output, at most one line on standard error, an exit code.

use ::report::ReportError;
use anyhow::Context;
use clap::ValueEnum;
use clap::error::ErrorKind;
use evaluation::EvaluationError;
use serde::Serialize;
use std::io::{self, Write};
use std::process::ExitCode;

/// How the result is written to standard output.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    #[default]
    Human,
    /// One JSON object and nothing else.
    Json,
}

/// The option that every verb takes.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct Output {
    /// Form of the result on standard output.
    #[arg(long, value_enum, default_value_t, value_name = "FORMAT")]
    format: Format,
}

impl Output {
    pub(crate) fn is_json(self) -> bool {
        self.format == Format::Json
    }

    /// Writes the result once, in the form that was asked for.
    pub(crate) fn emit(
        self,
        result: &impl Serialize,
        human: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let mut bytes = Vec::new();
        match self.format {
            Format::Human => human(&mut bytes).context("formatting the result")?,
            Format::Json => {
                serde_json::to_writer(&mut bytes, result).context("formatting the result")?;
                bytes.push(b'\n');
            }
        }
        print(&bytes)
    }
}

/// Bytes to standard output.
pub(crate) fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        // The reader has seen enough, as in `msm ... | head`.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written.context("standard output")?),
    }
}

/// Why a verb did not succeed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Bad usage or bad input: exit code 2.
    Input(anyhow::Error),
    /// Nothing is good enough for what was asked: exit code 3.
    Unmet(anyhow::Error),
    /// Anything else: exit code 1.
    Failed(anyhow::Error),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Failed(error)
    }
}

impl From<EvaluationError> for Failure {
    fn from(error: EvaluationError) -> Self {
        if error.is_input() { Self::Input(error.into()) } else { Self::Failed(error.into()) }
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Records(error) => error.into(),
            other => Self::Failed(other.into()),
        }
    }
}

/// Reports a failure on one line and returns the exit code.
pub(crate) fn exit_code(result: Result<(), Failure>) -> ExitCode {
    let (error, code) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Input(error)) => (error, 2),
        Err(Failure::Unmet(error)) => (error, 3),
        Err(Failure::Failed(error)) => (error, 1),
    };
    complain(&format!("{error:#}"));
    ExitCode::from(code)
}

/// Help and version on standard output; usage errors on one line of standard error.
pub(crate) fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // Nobody is left to tell when this fails.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        complain("no command given; `msm --help` lists them");
    } else {
        let text = error.render().to_string();
        let reason = text.split("\n\n").next().unwrap_or_default();
        complain(reason.strip_prefix("error: ").unwrap_or(reason));
    }
    ExitCode::from(2)
}

fn complain(message: &str) {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    // A closed standard error is no reason to panic.
    let _ = writeln!(io::stderr().lock(), "msm: {line}");
}
