//! The node tree: which nodes belong to the scene, and where each one stands.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;

/// A node of the chosen scene with its transform to world space.
pub(super) struct Placed {
    /// Index of the node.
    pub(super) node: usize,
    /// From the node's space to world space, accumulated in f64.
    pub(super) world: DMat4,
}

/// The nodes of the scene, parents before children, in the order of the document.
///
/// The scene is the default one, else the first, else (if the file has none) all nodes that are nobody's child.
pub(super) fn place(root: &Root, warnings: &mut Vec<String>) -> Result<Vec<Placed>, String> {
    let scene = root.scene.map_or_else(|| root.scenes.first(), |index| root.get(index));
    let mut stack: Vec<(usize, DMat4)> = match scene {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => parentless(root)?,
    }
    .into_iter()
    .rev()
    .map(|node| (node, DMat4::IDENTITY))
    .collect();

    let mut seen = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        let (Some(node), Some(seen)) = (root.nodes.get(index), seen.get_mut(index)) else {
            return Err(format!("there is no node {index}; export the file again"));
        };
        if std::mem::replace(seen, true) {
            return Err(format!(
                "node {index} is reached twice: nodes must form a tree, without cycles and with one parent each; export the file again"
            ));
        }
        let world = parent * local(index, node, warnings);
        for child in node.children.iter().flatten().rev() {
            stack.push((child.value(), world));
        }
        placed.push(Placed { node: index, world });
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
fn local(index: usize, node: &Node, warnings: &mut Vec<String>) -> DMat4 {
    if let Some(matrix) = node.matrix {
        let mut columns = matrix.map(f64::from);
        let last_row = [columns[3], columns[7], columns[11], columns[15]];
        if last_row != [0.0, 0.0, 0.0, 1.0] {
            warnings.push(format!("node {index} has a matrix that is not affine: its last row is taken as 0 0 0 1"));
            for (slot, value) in [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)] {
                columns[slot] = value;
            }
        }
        return DMat4::from_cols_array(&columns);
    }
    let translation = node.translation.map_or(DVec3::ZERO, to_f64);
    let scale = node.scale.map_or(DVec3::ONE, to_f64);
    let rotation = match node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => {
            let rotation = DQuat::from_array(rotation.0.map(f64::from));
            let length = rotation.length();
            if length > 0.0 && length.is_finite() {
                // The four numbers are rounded to f32: a length that is off by that much is no scale.
                rotation / length
            } else {
                warnings.push(format!("node {index} has a rotation without direction: it is taken as none"));
                DQuat::IDENTITY
            }
        }
    };
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}

fn to_f64(vector: [f32; 3]) -> DVec3 {
    DVec3::from_array(vector.map(f64::from))
}
