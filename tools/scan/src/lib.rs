//! What the programs that scan share: the client of the action `scan_object`, how it shows on a terminal, and what the
//! stages publish meanwhile.

pub mod answer;
pub mod bar;
pub mod client;
pub mod deformation;
pub mod folder;
pub mod goal;
pub mod page;
pub mod program;
pub mod recording;
