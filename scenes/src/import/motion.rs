//! The positions of all vertices over time.

use std::sync::Arc;

use super::form::{Form, Frame};
use super::geometry::Geometry;
use super::parts::Part;
use super::rig::Pose;
use crate::error::SceneError;
use crate::scene::Animation;

/// A primitive of a placed node, as often as there are such.
pub(super) struct Instance {
    /// Index of the placed node.
    pub(super) place: usize,
    /// Index of its mesh, and of the part of that.
    pub(super) part: (usize, usize),
    /// Index of its skin, if it has one.
    pub(super) skin: Option<usize>,
}

impl Instance {
    /// The primitive in a pose.
    pub(super) fn form<'a>(&self, part: &'a Part, pose: &'a Pose) -> Result<Form<'a>, String> {
        let frame = match self.skin {
            Some(skin) => Frame::Skin(pose.skin(skin)),
            None => Frame::Node(pose.worlds[self.place]),
        };
        Form::new(part, pose.weights(self.place), frame)
    }
}

/// All that positions are computed from.
pub(super) struct Motion {
    /// How errors call the scene.
    pub(super) label: String,
    pub(super) geometry: Geometry,
    /// Instances, each with the end of its vertices in `sources`.
    pub(super) instances: Vec<(Instance, usize)>,
    /// For each vertex of the scene the vertex of its primitive.
    pub(super) sources: Vec<u32>,
}

impl Motion {
    /// As an animation of `duration_s` seconds.
    pub(super) fn animation(self, duration_s: f64) -> Animation {
        let positions_at = move |time_s: f64| {
            if time_s.is_nan() {
                return Err(self.invalid("the time is not a number".to_owned()));
            }
            self.positions(time_s).map_err(|problem| self.invalid(format!("at {time_s} s: {problem}")))
        };
        Animation { duration_s, positions_at: Arc::new(positions_at), left_out: None }
    }

    fn positions(&self, time_s: f64) -> Result<Vec<[f32; 3]>, String> {
        let pose = self.geometry.rig.pose(time_s);
        let mut positions = Vec::with_capacity(self.sources.len());
        for (instance, end) in &self.instances {
            let (mesh, part) = instance.part;
            let form = instance.form(&self.geometry.parts[mesh][part], &pose)?;
            for &corner in &self.sources[positions.len()..*end] {
                positions.push(form.point(corner)?);
            }
        }
        Ok(positions)
    }

    fn invalid(&self, problem: String) -> SceneError {
        SceneError::Invalid { scene: self.label.clone(), problem }
    }
}
