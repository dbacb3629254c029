//! Output and exit codes of command-line programs.

use std::error::Error;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use anyhow::{Context, Result};

/// Prints results to stdout. A closed pipe (`| head -1`) is not an error.
///
/// # Errors
/// Stdout cannot be written for another reason, like a full disk.
pub fn print(results: impl Display) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match write!(out, "{results}").and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot print the results"),
    }
}

/// Writes a line to stderr, beside the results. That nobody reads it any more (`2>&1 | head -1`) is no fault either, where
/// `eprintln!` would panic.
pub fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Exit code 0 for success. For an error, prints it with its causes to stderr and returns 1.
pub fn exit_code(program: &str, result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note(format_args!("{program}: {}", describe(error.as_ref())));
            ExitCode::FAILURE
        }
    }
}

/// The text of an error and its causes. A cause that an error's own text already contains is not repeated.
pub fn describe(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        let said = cause.to_string();
        if !text.contains(&said) {
            text += &format!(": {said}");
        }
        next = cause.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_is_said_once() {
        let error = anyhow::Error::msg("no such file")
            .context("cannot read a: no such file")
            .context("view 1");
        assert_eq!(
            describe(error.as_ref()),
            "view 1: cannot read a: no such file"
        );
    }
}
