//! The picture of a scan: positions of its clouds beside the hand, their colours, and the text above.
//!
//! The true position of all clouds of a scan is the hand, where they would hide each other. So the views and the registered
//! cloud are drawn beside it, fixed in space while the hand turns.

mod layout;
mod parameters;
mod words;

pub use layout::{Layout, view_colour};
pub use parameters::Parameters;
pub use words::{Words, answer_words, progress_words};
