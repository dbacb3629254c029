//! How right deformations are: the table of simulated scans whose dents are known, and a row for each.
//!
//! The scans stay in the folder, one JSON file each, for the next time and for tests/peers/deformation.

#[path = "../tests/common/mod.rs"]
mod common;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Parser;
use common::score::{Row, Table, csv};
use common::{Case, Pads, references};

/// Truth table of deformations.
#[derive(Debug, Parser)]
struct Arguments {
    /// Where the scans are; those that are not there are simulated
    folder: PathBuf,
    /// How many
    #[arg(long, default_value_t = 400)]
    scans: usize,
    /// Seed of the first; the next one's is one more
    #[arg(long, default_value_t = 62_000)]
    seed: u64,
    /// Only one of the gripper's pads presses
    #[arg(long)]
    one_sided: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let references = references()?;
    std::fs::create_dir_all(&arguments.folder)?;
    let mut rows = Vec::new();
    for number in 0..arguments.scans {
        let path = arguments.folder.join(format!("{number:03}.json"));
        let case =
            case(&path, number, &arguments).with_context(|| format!("scan {}", path.display()))?;
        let Some(case) = case else { continue };
        let reference = references
            .get(case.class.as_str())
            .context("unknown class")?;
        rows.push(Row::of(&case, reference));
    }
    std::fs::write(arguments.folder.join("rows.csv"), csv(&rows))?;
    let ended = arguments.scans - rows.len();
    println!(
        "{ended} of {} scans left out: registration ended them",
        arguments.scans
    );
    print!("{}", Table::of(&rows));
    Ok(())
}

fn case(path: &Path, number: usize, arguments: &Arguments) -> Result<Option<Case>> {
    if path.exists() {
        return Ok(serde_json::from_str(&std::fs::read_to_string(path)?)?);
    }
    let pads = if arguments.one_sided {
        Pads::One
    } else {
        Pads::Both
    };
    let case = Case::numbered(number, arguments.seed, pads)?;
    std::fs::write(path, serde_json::to_string(&case)?)?;
    Ok(case)
}
