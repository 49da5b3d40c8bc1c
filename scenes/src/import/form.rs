//! Where the vertices of a placed primitive stand: displaced by its morph targets, then moved by its node or its skin.

use glam::{DMat4, DVec3};

use super::accessor::Accessor;
use super::parts::Part;

/// What moves vertices to world space.
pub(super) enum Frame<'a> {
    /// The node that holds the mesh.
    Node(DMat4),
    /// The joints of its skin: matrices from the mesh's space. What the node itself says is ignored, as glTF wants it.
    Skin(&'a [DMat4]),
}

/// A primitive in a pose, ready to be asked for vertices.
pub(super) struct Form<'a> {
    part: &'a Part,
    /// Weights that are not zero, with the displacements.
    morphs: Vec<(f64, &'a Accessor)>,
    frame: Frame<'a>,
}

impl<'a> Form<'a> {
    /// `part` with the `weights` of its morph targets; weights that are missing are zero.
    pub(super) fn new(part: &'a Part, weights: &[f64], frame: Frame<'a>) -> Result<Self, String> {
        let targets = part.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
        let morphs = targets.filter_map(|(target, &weight)| Some((weight, target.as_ref()?))).collect();
        if matches!(frame, Frame::Skin(_)) && part.influences.is_empty() {
            return Err(format!(
                "{}: its node has a skin, and it has no JOINTS_0 and WEIGHTS_0; export the file again",
                part.label
            ));
        }
        Ok(Self { part, morphs, frame })
    }

    /// Whether it is seen in a mirror, so that triangles run the other way round. A skin's first joint tells.
    pub(super) fn is_mirrored(&self) -> bool {
        let matrix = match &self.frame {
            Frame::Node(world) => Some(world),
            Frame::Skin(joints) => joints.first(),
        };
        matrix.is_some_and(|matrix| matrix.determinant() < 0.0)
    }

    /// Whether a vertex has no weight at all, so that it follows its first joint.
    pub(super) fn is_weightless(&self, corner: u32) -> bool {
        let mut weights = self.part.influences.iter().flat_map(|(_, weights)| weights.vector::<4>(corner as usize));
        matches!(self.frame, Frame::Skin(_)) && weights.all(|weight| weight == 0.0)
    }

    /// The position of a vertex as it is stored, to the bit.
    pub(super) fn stored(&self, corner: u32) -> Result<[f32; 3], String> {
        let own = DVec3::from_array(self.part.positions.vector(corner as usize));
        self.rounded(corner, own, own)
    }

    /// The position of a vertex in world space, computed in f64 and rounded once.
    pub(super) fn point(&self, corner: u32) -> Result<[f32; 3], String> {
        let own = DVec3::from_array(self.part.positions.vector(corner as usize));
        let mut point = own;
        for (weight, displacements) in &self.morphs {
            point += *weight * DVec3::from_array(displacements.vector(corner as usize));
        }
        let point = match &self.frame {
            Frame::Node(world) => world.transform_point3(point),
            Frame::Skin(matrices) => self.skinned(corner as usize, point, matrices)?,
        };
        self.rounded(corner, own, point)
    }

    /// The mean of where the joints would take a point, by their weights.
    fn skinned(&self, corner: usize, point: DVec3, matrices: &[DMat4]) -> Result<DVec3, String> {
        let label = &self.part.label;
        let mut sum = DVec3::ZERO;
        let mut total = 0.0;
        let mut first = None;
        for (joints, weights) in &self.part.influences {
            for (joint, weight) in joints.vector::<4>(corner).into_iter().zip(weights.vector::<4>(corner)) {
                if !(weight.is_finite() && weight >= 0.0) {
                    return Err(format!(
                        "{label} vertex {corner} has a weight of {weight}, and weights are finite and not negative; export the file again"
                    ));
                }
                let matrix = matrices.get(joint as usize).ok_or_else(|| {
                    format!(
                        "{label} vertex {corner} follows joint {joint}, and its skin has {}; export the file again",
                        matrices.len()
                    )
                })?;
                if weight > 0.0 {
                    sum += weight * matrix.transform_point3(point);
                    total += weight;
                }
                first.get_or_insert(matrix);
            }
        }
        // Weights ought to sum to 1 and do so but for rounding.
        match first {
            Some(first) if total == 0.0 => Ok(first.transform_point3(point)),
            _ => Ok(sum / total),
        }
    }

    /// A point in f32, where it has a place there; `own` is where the vertex was stored.
    fn rounded(&self, corner: u32, own: DVec3, point: DVec3) -> Result<[f32; 3], String> {
        let label = &self.part.label;
        if !own.is_finite() {
            return Err(format!(
                "{label} vertex {corner} is at {own}, which is not finite: repair the mesh and export it again"
            ));
        }
        if !point.is_finite() {
            let mover = match (&self.frame, self.morphs.is_empty()) {
                (Frame::Node(_), true) => "its node's transform",
                (Frame::Node(_), false) => "its morph targets and its node's transform",
                (Frame::Skin(_), _) => "its skin",
            };
            return Err(format!(
                "{label} vertex {corner} is at {point} after {mover}, which is not finite: repair the transform"
            ));
        }
        if point.abs().max_element() > super::MAX_COORDINATE {
            return Err(format!(
                "{label} vertex {corner} is at {point}, and coordinates beyond {:e} are refused because products of lengths overflow f32: scale the scene down",
                super::MAX_COORDINATE
            ));
        }
        Ok(point.as_vec3().to_array())
    }
}
