//! What to draw of a scan: where its clouds stand beside the hand, in which colours, and what is said above it.
//!
//! The clouds of a scan all belong into the same place, the hand. Shown there they would hide each other, so the views and
//! the registered cloud stand beside it, at rest while the hand turns.

mod layout;
mod parameters;
mod words;

pub use layout::{Layout, view_colour};
pub use parameters::Parameters;
pub use words::{Words, answer_words, progress_words};
