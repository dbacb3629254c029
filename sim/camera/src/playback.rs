//! Recorded captures in place of rendered views.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use cloud::FileError;
use nalgebra::Point3;

use crate::image::DepthImage;
use crate::intrinsics::{Intrinsics, project};

/// Axes of a recorded file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaptureFrame {
    /// As the RealSense viewer exports: x right, y up, z towards the viewer.
    Viewer,
    /// As ROS publishes: x right, y down, z forward.
    Optical,
}

/// One recorded view.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// Where it was read from.
    pub path: PathBuf,
    /// Points in the optical frame, in metres.
    pub points: Vec<Point3<f32>>,
}

/// The captures of a folder, shown one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Playback {
    captures: Vec<Capture>,
    shown: Option<usize>,
}

/// Captures that cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum PlaybackError {
    /// The folder cannot be listed.
    #[error("captures folder {}: {reason}", folder.display())]
    Folder {
        /// What was asked for.
        folder: PathBuf,
        /// Why not.
        reason: std::io::Error,
    },
    /// There is nothing to play in the folder.
    #[error("captures folder {} has no .ply or .pcd file", folder.display())]
    NoFiles {
        /// What was asked for.
        folder: PathBuf,
    },
    /// A file is damaged or not a cloud; the message names it.
    #[error("capture {0}")]
    File(#[from] FileError),
    /// A file has no point in front of the camera.
    #[error(
        "capture {} has no point in front of the camera; is it in the frame of the viewer or in the optical one?",
        path.display()
    )]
    NothingInFront {
        /// The file.
        path: PathBuf,
    },
}

impl Playback {
    /// Reads all PLY and PCD files of a folder, in natural order of their names (`out_2` before `out_10`).
    ///
    /// Coordinates are metres. Without `frame`, PLY files are taken to be in the viewer's frame and PCD
    /// files in the optical one.
    ///
    /// # Errors
    /// A folder that is missing, has no such file, or has one that cannot be used.
    pub fn open(folder: &Path, frame: Option<CaptureFrame>) -> Result<Self, PlaybackError> {
        let captures = list(folder)?
            .into_iter()
            .map(|path| read(path, frame))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            captures,
            shown: None,
        })
    }

    /// All captures in the order in which they are shown.
    pub fn captures(&self) -> &[Capture] {
        &self.captures
    }

    /// The capture that the camera sees now; the first one before any call of [`Playback::advance`].
    pub fn current(&self) -> &Capture {
        &self.captures[self.shown.unwrap_or(0)]
    }

    /// Shows the next capture: the first one on the first call, and the first one again after the last.
    pub fn advance(&mut self) -> &Capture {
        self.shown = Some(
            self.shown
                .map_or(0, |index| (index + 1) % self.captures.len()),
        );
        self.current()
    }
}

impl Capture {
    /// The view as a depth image: each point in the pixel that sees it, the nearest where several meet.
    pub fn depth_image(&self, camera: &Intrinsics) -> DepthImage {
        let mut image = DepthImage::empty(camera.width as usize, camera.height as usize);
        for point in self.points.iter().filter(|point| point.z > 0.0) {
            let [u, v] = project(camera, &point.cast()).map(f64::round);
            let depth_mm = (1000.0 * point.z).round();
            let inside = (0.0..f64::from(camera.width)).contains(&u)
                && (0.0..f64::from(camera.height)).contains(&v);
            if inside && (1.0..=f32::from(u16::MAX)).contains(&depth_mm) {
                let index = v as usize * image.width + u as usize;
                let pixel = &mut image.depth_mm[index];
                let nearest = if *pixel == 0 { u16::MAX } else { *pixel };
                *pixel = nearest.min(depth_mm as u16);
            }
        }
        image
    }
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, PlaybackError> {
    let fail = |reason| PlaybackError::Folder {
        folder: folder.to_owned(),
        reason,
    };
    let entries = std::fs::read_dir(folder).map_err(fail)?;
    let mut paths = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(fail)?;
    paths.retain(|path| has_extension(path, "ply") || has_extension(path, "pcd"));
    if paths.is_empty() {
        return Err(PlaybackError::NoFiles {
            folder: folder.to_owned(),
        });
    }
    paths.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(paths)
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

fn read(path: PathBuf, frame: Option<CaptureFrame>) -> Result<Capture, PlaybackError> {
    let by_type = if has_extension(&path, "ply") {
        CaptureFrame::Viewer
    } else {
        CaptureFrame::Optical
    };
    let mut points = cloud::read(&path)?.points;
    if frame.unwrap_or(by_type) == CaptureFrame::Viewer {
        points
            .iter_mut()
            .for_each(|p| *p = Point3::new(p.x, -p.y, -p.z));
    }
    if points.iter().any(|point| point.z > 0.0) {
        Ok(Capture { path, points })
    } else {
        Err(PlaybackError::NothingInFront { path })
    }
}

/// Compares names so that numbers in them count by value.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let (digits_a, digits_b) = (digits(a), digits(b));
        let order = if digits_a > 0 && digits_b > 0 {
            let (number_a, number_b) = (
                a[..digits_a].trim_start_matches('0'),
                b[..digits_b].trim_start_matches('0'),
            );
            number_a
                .len()
                .cmp(&number_b.len())
                .then(number_a.cmp(number_b))
                .then(digits_a.cmp(&digits_b))
        } else {
            a.chars().next().cmp(&b.chars().next())
        };
        if order != Ordering::Equal || a.is_empty() {
            return order;
        }
        let step = |text: &str, digits: usize| {
            if digits > 0 {
                digits
            } else {
                first_char_len(text)
            }
        };
        (a, b) = (&a[step(a, digits_a)..], &b[step(b, digits_b)..]);
    }
}

fn digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

fn first_char_len(text: &str) -> usize {
    text.chars().next().map_or(0, char::len_utf8)
}

#[cfg(test)]
mod tests;
