//! Writes the eight objects as they are before anything dents them, LABEL.ply, into a folder: config/references is made so.

use std::path::PathBuf;

use mesh::file::write_ply;
use sim_objects::{ObjectClass, Variation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.ok_or("usage: references FOLDER")?;
    std::fs::create_dir_all(&folder)?;
    for class in ObjectClass::ALL {
        write_ply(
            folder.join(format!("{class}.ply")),
            &class.mesh(&Variation::NONE),
        )?;
    }
    Ok(())
}
