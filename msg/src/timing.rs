//! How long each stage of a scan took, carried from stage to stage.

use rosrust_msg::deformable_cobot::StageTime;
use std::time::{Duration, Instant};

/// The entry of a stage that took `elapsed`.
pub fn stage(name: &str, elapsed: Duration) -> StageTime {
    StageTime {
        stage: name.into(),
        elapsed: elapsed.into(),
    }
}

/// Runs `work` and gives its result with the entry of the stage `name`.
pub fn timed<T>(name: &str, work: impl FnOnce() -> T) -> (T, StageTime) {
    let start = Instant::now();
    let result = work();
    (result, stage(name, start.elapsed()))
}
