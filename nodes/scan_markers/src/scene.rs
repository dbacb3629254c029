//! The picture of the running scan, or of the last one if none is running.

use crate::marker::{self, Board};
use cloud::voxel;
use msg::deformable_cobot::{Classification, RegisteredCloud, ScanObjectFeedback, View};
use msg::sensor_msgs::PointCloud2;
use nalgebra::{Isometry3, Point3, Vector3};
use node::Transforms;
use scan_markers::{Layout, Parameters, Words, answer_words, progress_words, view_colour};

const CAPTION: [f32; 3] = [0.75, 0.75, 0.75];
const REGISTERED: [f32; 3] = [1.0, 0.7, 0.25];
const PROGRESS: [f32; 3] = [1.0, 0.9, 0.2];
/// Views that may wait for TF, which comes somewhat later than an image.
const WAITING_MAX: usize = 16;
/// Height of a caption above its cloud, m.
const CAPTION_RISE_M: f64 = 0.05;
/// Height of the answer above the line about progress, m.
const LINE_M: f64 = 0.06;
/// Height of the answer above the registered cloud, m, if the hand is not known.
const ANSWER_RISE_M: f64 = 0.12;

/// The state of the picture.
pub struct Scene {
    parameters: Parameters,
    transforms: Transforms,
    scan_id: String,
    /// `None` before the first view.
    layout: Option<Layout>,
    /// Views that are not drawn yet, since the layout needs TF at the stamp of the first.
    waiting: Vec<View>,
    /// The newest view, by scan and index, to recognise repetitions of latched messages.
    newest_view: (String, u8, u32),
    /// The registered cloud; it may arrive before the view that determines the layout.
    registered: Option<RegisteredCloud>,
    /// Frame and position of the answer: above the hand, or above the registered cloud if the hand is not known.
    answer_place: (String, Point3<f64>),
    /// Markers of clouds and their captions, which change with each view.
    pub clouds: Board,
    /// Markers of text and progress, which change often.
    pub words: Board,
}

impl Scene {
    pub fn new(parameters: Parameters, transforms: Transforms) -> Self {
        let answer_place = over_the_hand(&parameters);
        Self {
            parameters,
            transforms,
            answer_place,
            scan_id: String::new(),
            layout: None,
            waiting: Vec::new(),
            newest_view: Default::default(),
            registered: None,
            clouds: Board::default(),
            words: Board::default(),
        }
    }

    /// Draws the progress of a scan.
    pub fn on_progress(&mut self, report: &ScanObjectFeedback) {
        self.begin(&report.scan_id);
        // That TF is missing is said when the next view or the registered cloud comes.
        let _ = self.draw_waiting();
        self.words.wipe("progress");
        let Some(words) = progress_words(&report.state, report.view, report.count) else {
            return;
        };
        let (frame, place) = &self.answer_place;
        let up = self
            .layout
            .as_ref()
            .map_or(Vector3::z_axis(), |layout| layout.up);
        let place = place - up.scale(LINE_M);
        self.words
            .draw(marker::text(("progress", 0), frame, &place, &words));
        let turn_rad = report.target_angle - report.wrist_angle;
        if report.state == "turning" && turn_rad.is_finite() {
            self.words.draw(marker::line(
                ("progress", 1),
                self.parameters.side.hand_frame(),
                &arc(turn_rad),
                PROGRESS,
            ));
        }
    }

    /// Draws a view in its own colour.
    pub fn on_view(&mut self, view: &View) -> anyhow::Result<()> {
        let newest = (view.scan_id.clone(), view.kind, view.index);
        if std::mem::replace(&mut self.newest_view, newest.clone()) == newest {
            return Ok(());
        }
        self.begin(&view.scan_id);
        if view.kind != View::VIEW {
            return Ok(());
        }
        self.waiting.push(view.clone());
        match self.draw_waiting() {
            Err(error) if self.waiting.len() > WAITING_MAX => {
                self.waiting.remove(0);
                Err(error)
            }
            _ => Ok(()),
        }
    }

    /// Draws the views that wait.
    ///
    /// # Errors
    /// TF at the stamp of the first one is not known, or not yet.
    fn draw_waiting(&mut self) -> anyhow::Result<()> {
        if self.layout.is_none()
            && let Some(first) = self.waiting.first()
        {
            self.layout = Some(self.layout_of(first)?);
        }
        for view in std::mem::take(&mut self.waiting) {
            let scan_from_camera = if view.has_pose {
                msg::transform::to_isometry(&view.hand_from_camera)
            } else {
                None
            };
            let scan_from_camera = scan_from_camera.unwrap_or_else(Isometry3::identity);
            let (name, colour) = (("views", view.index), view_colour(view.index));
            self.draw_cloud(name, &view.cloud, scan_from_camera, 1.0, colour)?;
        }
        self.draw_registered()
    }

    /// Draws the registered cloud, in which all views are fused.
    pub fn on_registered(&mut self, registered: RegisteredCloud) -> anyhow::Result<()> {
        if registered.scan_id == self.scan_id && registered.error.is_empty() {
            self.registered = Some(registered);
        }
        self.draw_waiting()
    }

    fn draw_registered(&mut self) -> anyhow::Result<()> {
        let Some(layout) = self.layout.clone() else {
            return Ok(());
        };
        let Some(registered) = self.registered.take() else {
            return Ok(());
        };
        let identity = Isometry3::identity();
        self.draw_cloud(
            ("registered", 0),
            &registered.cloud,
            identity,
            -1.0,
            REGISTERED,
        )?;
        if !registered.in_hand_frame {
            let points = thinned(
                &registered.cloud,
                &layout.beside(0.0),
                self.parameters.voxel_m,
            )?;
            if let Some(place) = layout.above(&points, ANSWER_RISE_M) {
                self.answer_place = (layout.frame, place);
            }
        }
        Ok(())
    }

    /// Draws the classifier's answer.
    pub fn on_answer(&mut self, answer: &Classification) {
        if answer.scan_id != self.scan_id || !answer.error.is_empty() {
            return;
        }
        let words = answer_words(
            &answer.label,
            answer.probability,
            answer.known,
            &answer.reason,
        );
        let (frame, place) = &self.answer_place;
        self.words
            .draw(marker::text(("answer", 0), frame, place, &words));
    }

    /// Clears the picture if the scan is not the one that is drawn.
    fn begin(&mut self, scan_id: &str) {
        if scan_id != self.scan_id && !scan_id.is_empty() {
            self.scan_id = scan_id.into();
            self.layout = None;
            self.waiting.clear();
            self.registered = None;
            self.answer_place = over_the_hand(&self.parameters);
            self.clouds.clear();
            self.words.clear();
        }
    }

    fn layout_of(&self, view: &View) -> anyhow::Result<Layout> {
        if !view.has_pose {
            return Ok(Layout::optical(&view.header.frame_id));
        }
        let fixed = &self.parameters.fixed_frame;
        let fixed_from_hand = self
            .transforms
            .lookup(fixed, &view.hand_frame, view.header.stamp)?;
        Ok(Layout::level(fixed, fixed_from_hand))
    }

    fn draw_cloud(
        &mut self,
        name: (&str, u32),
        cloud: &PointCloud2,
        scan_from_cloud: Isometry3<f64>,
        side: f64,
        colour: [f32; 3],
    ) -> anyhow::Result<()> {
        let Some(layout) = &self.layout else {
            return Ok(());
        };
        let spread_m = self.parameters.spread_m;
        let frame_from_cloud = layout.beside(side * spread_m) * scan_from_cloud;
        let points = thinned(cloud, &frame_from_cloud, self.parameters.voxel_m)?;
        let caption = layout
            .above(&points, CAPTION_RISE_M)
            .filter(|_| spread_m > 0.0);
        if let Some(place) = caption {
            let words = Words {
                text: name.0.into(),
                colour: CAPTION,
            };
            let key = (&format!("{} caption", name.0)[..], 0);
            self.clouds
                .draw(marker::text(key, &layout.frame, &place, &words));
        }
        let size_m = 0.8 * self.parameters.voxel_m;
        self.clouds
            .draw(marker::points(name, &layout.frame, &points, size_m, colour));
        Ok(())
    }
}

/// One point in each cube of side `voxel_m`, moved by `frame_from_cloud`.
fn thinned(
    cloud: &PointCloud2,
    frame_from_cloud: &Isometry3<f64>,
    voxel_m: f64,
) -> anyhow::Result<Vec<Point3<f64>>> {
    let points = msg::cloud::to_points(cloud)?.points;
    let thinned = voxel::downsample(&points, voxel_m as f32)?;
    Ok(thinned
        .iter()
        .map(|point| frame_from_cloud * point.cast::<f64>())
        .collect())
}

fn over_the_hand(parameters: &Parameters) -> (String, Point3<f64>) {
    let place = Point3::new(0.0, 0.0, parameters.text_height_m);
    (parameters.side.hand_frame().into(), place)
}

/// Radius and height above the hand of the arc that shows the remaining turn, m.
const ARC_RADIUS_M: f64 = 0.13;
const ARC_HEIGHT_M: f64 = 0.12;
const ARC_POINTS: usize = 24;

/// The arc by which the hand still has to turn, in its own frame.
fn arc(turn_rad: f64) -> Vec<Point3<f64>> {
    let point = |step: usize| {
        let angle_rad = turn_rad * step as f64 / (ARC_POINTS - 1) as f64;
        Point3::new(
            ARC_RADIUS_M * angle_rad.cos(),
            ARC_RADIUS_M * angle_rad.sin(),
            ARC_HEIGHT_M,
        )
    };
    (0..ARC_POINTS).map(point).collect()
}
