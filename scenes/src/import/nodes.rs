//! The node tree: which nodes belong to the scene, and where each one stands.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;

/// A node of the chosen scene.
pub(super) struct Placed {
    /// Index of the node in the document.
    pub(super) node: usize,
    /// Which of the placed nodes is its parent; it comes before.
    pub(super) parent: Option<usize>,
    /// To its parent's space, at rest.
    pub(super) local: LocalTransform,
}

/// How a node stands in its parent's space.
#[derive(Clone, Copy)]
pub(super) enum LocalTransform {
    /// By a matrix, which cannot be animated.
    Matrix(DMat4),
    /// By properties, each of which can be.
    Properties(Properties),
}

/// Translation after rotation after scale.
#[derive(Clone, Copy)]
pub(super) struct Properties {
    pub(super) translation: DVec3,
    /// Unit length.
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
}

impl LocalTransform {
    /// As a matrix, in f64.
    pub(super) fn matrix(&self) -> DMat4 {
        match self {
            Self::Matrix(matrix) => *matrix,
            Self::Properties(own) => DMat4::from_scale_rotation_translation(own.scale, own.rotation, own.translation),
        }
    }
}

/// The nodes of the scene, parents before children, in the order of the document.
///
/// The scene is the default one, else the first, else (if the file has none) all nodes that are nobody's child.
pub(super) fn place(root: &Root, warnings: &mut Vec<String>) -> Result<Vec<Placed>, String> {
    let scene = root.scene.map_or_else(|| root.scenes.first(), |index| root.get(index));
    let mut stack: Vec<(usize, Option<usize>)> = match scene {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => parentless(root)?,
    }
    .into_iter()
    .rev()
    .map(|node| (node, None))
    .collect();

    let mut seen = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        let (Some(node), Some(seen)) = (root.nodes.get(index), seen.get_mut(index)) else {
            return Err(format!("there is no nodes[{index}]; export the file again"));
        };
        if std::mem::replace(seen, true) {
            return Err(format!(
                "nodes[{index}] is reached twice: nodes must form a tree, without cycles and with one parent each; export the file again"
            ));
        }
        for child in node.children.iter().flatten().rev() {
            stack.push((child.value(), Some(placed.len())));
        }
        placed.push(Placed { node: index, parent, local: local(index, node, warnings) });
    }
    Ok(placed)
}

fn parentless(root: &Root) -> Result<Vec<usize>, String> {
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let roots: Vec<usize> = (0..root.nodes.len()).filter(|&node| !is_child[node]).collect();
    if roots.is_empty() && !root.nodes.is_empty() {
        return Err("every node is the child of another: nodes must form a tree; export the file again".to_owned());
    }
    Ok(roots)
}

/// A matrix goes before translation, rotation and scale, of which glTF allows it no company.
fn local(index: usize, node: &Node, warnings: &mut Vec<String>) -> LocalTransform {
    if let Some(matrix) = node.matrix {
        let (matrix, given) = affine(matrix.map(f64::from));
        if !given {
            warnings.push(format!("nodes[{index}] has a matrix that is not affine: its last row is taken as 0 0 0 1"));
        }
        return LocalTransform::Matrix(matrix);
    }
    let translation = node.translation.map_or(DVec3::ZERO, to_f64);
    let scale = node.scale.map_or(DVec3::ONE, to_f64);
    let rotation = match node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => unit(DQuat::from_array(rotation.0.map(f64::from))).unwrap_or_else(|| {
            warnings.push(format!("nodes[{index}] has a rotation without direction: it is taken as none"));
            DQuat::IDENTITY
        }),
    };
    LocalTransform::Properties(Properties { translation, rotation, scale })
}

/// A matrix from its columns with 0 0 0 1 for its last row, and whether that is what it was.
pub(super) fn affine(mut columns: [f64; 16]) -> (DMat4, bool) {
    let mut given = true;
    for (slot, value) in [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)] {
        given &= columns[slot] == value;
        columns[slot] = value;
    }
    (DMat4::from_cols_array(&columns), given)
}

/// A rotation with the length taken out: its numbers are rounded, so a length beside 1 is no scale. None without one.
pub(super) fn unit(rotation: DQuat) -> Option<DQuat> {
    let length = rotation.length();
    (length > 0.0 && length.is_finite()).then(|| rotation / length)
}

fn to_f64(vector: [f32; 3]) -> DVec3 {
    DVec3::from_array(vector.map(f64::from))
}
