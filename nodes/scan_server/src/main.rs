//! Scans what the hand holds, for the callers of the service and the action `scan_object`.

mod shell;

use std::process::ExitCode;

fn main() -> ExitCode {
    node::run("scan_server", shell::serve)
}
