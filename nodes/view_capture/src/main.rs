//! Takes the views of a scan.

mod shell;

use std::process::ExitCode;

fn main() -> ExitCode {
    node::run("view_capture", shell::serve)
}
