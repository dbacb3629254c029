//! What the tools say at the end.

use std::process::ExitCode;

use anyhow::{Error, Result};

/// 0 for success; otherwise 1, after saying what failed and why.
pub fn exit_code(program: &str, result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{program}: {}", describe(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error and its causes. Some errors say their cause themselves; it is not said twice.
pub fn describe(error: &Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text += &format!(": {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_is_said_once() {
        let error = Error::msg("no such file")
            .context("cannot read a: no such file")
            .context("view 1");
        assert_eq!(describe(&error), "view 1: cannot read a: no such file");
    }
}
