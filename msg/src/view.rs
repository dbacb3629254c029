//! What is said on `views` besides the views themselves, and the name that all messages of a scan have in common.

use crate::Time;
use rosrust_msg::deformable_cobot::View;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// A scan id that no other scan has, also after the time of a simulation was set back: from the computer's own clock.
pub fn new_scan_id() -> String {
    static SCANS: AtomicU32 = AtomicU32::new(0);
    let since_epoch = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let number = SCANS.fetch_add(1, Ordering::Relaxed);
    format!("{:x}-{number}", since_epoch.as_millis())
}

/// Says that the scan ended without an answer; every later stage passes the error on.
pub fn failed(scan_id: &str, error: String, stamp: Time) -> View {
    let mut view = View {
        kind: View::FAILED,
        scan_id: scan_id.into(),
        error,
        ..Default::default()
    };
    view.header.stamp = stamp;
    view
}

/// Says that no more views come than these; the later stages then end the scan with what they have.
pub fn end(scan_id: &str, view_count: u32, stamp: Time) -> View {
    let mut view = View {
        kind: View::END,
        scan_id: scan_id.into(),
        index: view_count,
        count: view_count,
        ..Default::default()
    };
    view.header.stamp = stamp;
    view
}
