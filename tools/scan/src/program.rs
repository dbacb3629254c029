//! From the words of the command line to the exit code.

use anyhow::Result;
use clap::Parser;
use node::Node;
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

pub use ::program::{note, print};

/// Runs a program of the terminal as a node: reads its arguments, does `work`, and says what went wrong.
pub fn run<A, F>(name: &str, work: impl FnOnce(Node, A) -> F) -> ExitCode
where
    A: Parser,
    F: Future<Output = Result<()>>,
{
    // The others are ROS's: names that are mapped, private parameters.
    let words = std::env::args().filter(|word| !word.contains(":="));
    let arguments = A::parse_from(words);
    let mut result = None;
    let slot = &mut result;
    let code = node::run_program(&unique_name(name), move |node| async move {
        *slot = Some(work(node, arguments).await);
        Ok(())
    });
    match result {
        None => code,
        Some(Ok(())) => ExitCode::SUCCESS,
        Some(Err(error)) => {
            note(format_args!("{name}: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// A node's name is its own: the master ends the older of two that share one.
fn unique_name(name: &str) -> String {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    format!("{name}_{}_{}", std::process::id(), now.as_millis())
}
