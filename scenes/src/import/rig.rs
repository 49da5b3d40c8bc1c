//! What moves: the nodes of the scene, the channels of its animation and its skins; and how all of it stands at a time.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::animation::{Animation, Channel as JsonChannel, Property};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Kind};
use super::nodes::{LocalTransform, Placed, Properties, affine};
use super::sampler::Sampler;
use crate::scene::ImportNotes;

/// Most joints over all skins.
const MAX_JOINTS: usize = 1_000_000;

/// Nodes, skins and channels.
pub(super) struct Rig {
    /// Nodes of the scene, parents before children.
    pub(super) placed: Vec<Placed>,
    /// By index of the document; empty where no node of the scene uses it.
    skins: Vec<Joints>,
    /// Weights of morph targets at rest, by placed node, where there are any.
    weights: BTreeMap<usize, Vec<f64>>,
    channels: Vec<Channel>,
}

/// Joints of a skin: placed nodes, each with the matrix from the mesh's space to its own.
type Joints = Vec<(usize, DMat4)>;

/// A property of a placed node over time.
struct Channel {
    place: usize,
    property: Property,
    sampler: Sampler,
}

/// How a rig stands at a time.
pub(super) struct Pose {
    /// From each placed node's space to world space.
    pub(super) worlds: Vec<DMat4>,
    skins: Vec<Vec<DMat4>>,
    weights: BTreeMap<usize, Vec<f64>>,
}

impl Pose {
    /// From the mesh's space to world space, a matrix for each joint of the skin of that index.
    pub(super) fn skin(&self, skin: usize) -> &[DMat4] {
        self.skins.get(skin).map_or(&[], Vec::as_slice)
    }

    /// Weights of the morph targets of a placed node's mesh; those that are missing are zero.
    pub(super) fn weights(&self, place: usize) -> &[f64] {
        self.weights.get(&place).map_or(&[], Vec::as_slice)
    }
}

impl Rig {
    /// Reads skins and the first animation of a document whose buffers are loaded.
    pub(super) fn open(
        accessors: &Accessors<'_>,
        placed: Vec<Placed>,
        notes: &mut ImportNotes,
    ) -> Result<Self, String> {
        let root = accessors.root;
        let mut place_of = vec![None; root.nodes.len()];
        for (place, placed) in placed.iter().enumerate() {
            place_of[placed.node] = Some(place);
        }
        let skins = open_skins(accessors, &placed, &place_of, notes)?;
        let mut weights = BTreeMap::new();
        for (place, own) in placed.iter().enumerate() {
            let node = &root.nodes[own.node];
            let mesh = node.mesh.and_then(|mesh| root.get(mesh));
            let given = node.weights.as_ref().or_else(|| mesh.and_then(|mesh| mesh.weights.as_ref()));
            if let Some(given) = given {
                if given.iter().any(|weight| !weight.is_finite()) {
                    return Err(format!("nodes[{}] has morph weights that are not finite", own.node));
                }
                weights.insert(place, given.iter().copied().map(f64::from).collect());
            }
        }
        let mut rig = Self { placed, skins, weights, channels: Vec::new() };
        if let Some(animation) = root.animations.first() {
            for channel in &animation.channels {
                let sampler = channel.sampler;
                rig.add_channel(accessors, animation, channel, &place_of, notes).map_err(|problem| {
                    format!("animations[0].samplers[{sampler}]: {problem}; export the file again")
                })?;
            }
        }
        Ok(rig)
    }

    fn add_channel(
        &mut self,
        accessors: &Accessors<'_>,
        animation: &Animation,
        channel: &JsonChannel,
        place_of: &[Option<usize>],
        notes: &mut ImportNotes,
    ) -> Result<(), String> {
        let node = channel.target.node.value();
        let Some(place) = *place_of.get(node).ok_or_else(|| format!("there is no nodes[{node}]"))? else {
            // The node belongs to another scene.
            return Ok(());
        };
        let (Checked::Valid(property), Some(sampler)) =
            (channel.target.path, animation.samplers.get(channel.sampler.value()))
        else {
            return Err("its path or its sampler does not exist".to_owned());
        };
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err("its interpolation does not exist".to_owned());
        };
        let (kind, width) = match property {
            Property::Translation | Property::Scale => (Kind::VECTOR, 3),
            Property::Rotation => (Kind::ROTATION, 4),
            Property::MorphTargetWeights => (Kind::MORPH_WEIGHT, target_count(accessors.root, node)?),
        };
        if width == 0 {
            notes.warnings.push(format!("nodes[{node}] has animated weights and no morph targets: they are ignored"));
            return Ok(());
        }
        let has_matrix = matches!(self.placed[place].local, LocalTransform::Matrix(_));
        if has_matrix && property != Property::MorphTargetWeights {
            return Err(format!(
                "nodes[{node}] has a matrix, and only translation, rotation and scale can be animated"
            ));
        }
        let (times, values) = (sampler.input.value(), sampler.output.value());
        let sampler = Sampler::open(accessors, times, values, interpolation, kind, width)?;
        self.channels.push(Channel { place, property, sampler });
        Ok(())
    }

    /// Time of the last key of all channels in seconds; 0 if there is none.
    pub(super) fn duration_s(&self) -> f64 {
        self.channels.iter().map(|channel| channel.sampler.end_s()).fold(0.0, f64::max)
    }

    /// What it takes to compute a pose: nodes, joints, and numbers of channels.
    pub(super) fn size(&self) -> usize {
        let joints: usize = self.skins.iter().map(Vec::len).sum();
        self.placed.len() + joints + self.channels.iter().map(|channel| channel.sampler.width).sum::<usize>()
    }

    /// For each placed node, whether it moves, by itself or by a parent.
    pub(super) fn moving_nodes(&self) -> Vec<bool> {
        let mut moving = vec![false; self.placed.len()];
        for channel in &self.channels {
            moving[channel.place] |= channel.property != Property::MorphTargetWeights;
        }
        for place in 0..self.placed.len() {
            // Parents come before children.
            moving[place] |= self.placed[place].parent.is_some_and(|parent| moving[parent]);
        }
        moving
    }

    /// For each placed node, whether a mesh that it holds moves, by itself, a parent, its joints or its weights.
    pub(super) fn moving(&self, root: &Root) -> Vec<bool> {
        let by_node = self.moving_nodes();
        let mut by_weights = vec![false; self.placed.len()];
        for channel in &self.channels {
            by_weights[channel.place] |= channel.property == Property::MorphTargetWeights;
        }
        let by_skin: Vec<bool> = self.skins.iter().map(|skin| skin.iter().any(|joint| by_node[joint.0])).collect();
        let moving = |(place, own): (usize, &Placed)| {
            let skin = root.nodes[own.node].skin.and_then(|skin| by_skin.get(skin.value()));
            *skin.unwrap_or(&by_node[place]) || by_weights[place]
        };
        self.placed.iter().enumerate().map(moving).collect()
    }

    /// How everything stands at a time in seconds; nothing is checked to be finite. Of two channels for one property the
    /// later one counts.
    pub(super) fn pose(&self, time_s: f64) -> Pose {
        let mut moved: BTreeMap<usize, Properties> = BTreeMap::new();
        let mut weights = self.weights.clone();
        for channel in &self.channels {
            let value = channel.sampler.at(time_s);
            if channel.property == Property::MorphTargetWeights {
                weights.insert(channel.place, value);
            } else if let LocalTransform::Properties(rest) = self.placed[channel.place].local {
                let own = moved.entry(channel.place).or_insert(rest);
                match (channel.property, value.as_slice()) {
                    (Property::Translation, &[x, y, z]) => own.translation = DVec3::new(x, y, z),
                    (Property::Scale, &[x, y, z]) => own.scale = DVec3::new(x, y, z),
                    (Property::Rotation, &[x, y, z, w]) => own.rotation = DQuat::from_xyzw(x, y, z, w),
                    _ => {}
                }
            }
        }
        let mut worlds: Vec<DMat4> = Vec::with_capacity(self.placed.len());
        for (place, own) in self.placed.iter().enumerate() {
            let local =
                moved.get(&place).map_or(own.local, |properties| LocalTransform::Properties(*properties)).matrix();
            worlds.push(own.parent.map_or(local, |parent| worlds[parent] * local));
        }
        let joint = |&(place, inverse_bind): &(usize, DMat4)| worlds[place] * inverse_bind;
        let skins = self.skins.iter().map(|skin| skin.iter().map(joint).collect()).collect();
        Pose { worlds, skins, weights }
    }
}

/// Opens the skins that placed nodes with a mesh use.
fn open_skins(
    accessors: &Accessors<'_>,
    placed: &[Placed],
    place_of: &[Option<usize>],
    notes: &mut ImportNotes,
) -> Result<Vec<Joints>, String> {
    let root = accessors.root;
    let mut skins = vec![Joints::new(); root.skins.len()];
    let mut joints = 0usize;
    for index in used_skins(root, placed) {
        let (Some(json), Some(skin)) = (root.skins.get(index), skins.get_mut(index)) else {
            return Err(format!("there is no skins[{index}]; export the file again"));
        };
        joints = joints.saturating_add(json.joints.len());
        if joints > MAX_JOINTS {
            return Err(format!("its skins have more than {MAX_JOINTS} joints, which is too much: reduce them"));
        }
        let opened = open_skin(accessors, json, place_of, &format!("skins[{index}]"), notes);
        *skin = opened.map_err(|problem| format!("skins[{index}]: {problem}; export the file again"))?;
    }
    Ok(skins)
}

fn open_skin(
    accessors: &Accessors<'_>,
    json: &gltf::json::Skin,
    place_of: &[Option<usize>],
    label: &str,
    notes: &mut ImportNotes,
) -> Result<Joints, String> {
    if json.joints.is_empty() {
        return Err("it has no joints".to_owned());
    }
    let matrices = accessors.open_some(json.inverse_bind_matrices, Kind::MATRIX)?;
    if let Some(matrices) = &matrices
        && matrices.count() < json.joints.len()
    {
        let (joints, found) = (json.joints.len(), matrices.count());
        return Err(format!("it has {joints} joints and {found} inverse bind matrices"));
    }
    let mut skewed = 0;
    let mut joints = Vec::with_capacity(json.joints.len());
    for (slot, node) in json.joints.iter().enumerate() {
        let node = node.value();
        let place = place_of.get(node).copied().flatten();
        let place = place.ok_or_else(|| format!("joints[{slot}] is {node}, a node which is not part of the scene"))?;
        // Without matrices each joint is bound where it has its origin.
        let matrix = match &matrices {
            None => DMat4::IDENTITY,
            Some(matrices) => {
                let (matrix, given) = affine(matrices.vector(slot));
                skewed += u32::from(!given);
                matrix
            }
        };
        if !matrix.is_finite() {
            return Err(format!("the inverse bind matrix of joints[{slot}] is not finite"));
        }
        joints.push((place, matrix));
    }
    if skewed > 0 {
        notes.warnings.push(format!(
            "{label} has inverse bind matrices that are not affine ({skewed}): their last row is taken as 0 0 0 1"
        ));
    }
    Ok(joints)
}

/// Skins of the placed nodes that hold a mesh, each once, in rising order.
pub(super) fn used_skins(root: &Root, placed: &[Placed]) -> Vec<usize> {
    let nodes = placed.iter().filter_map(|own| root.nodes.get(own.node)).filter(|node| node.mesh.is_some());
    let mut skins: Vec<usize> = nodes.filter_map(|node| node.skin).map(|skin| skin.value()).collect();
    skins.sort_unstable();
    skins.dedup();
    skins
}

/// Number of morph targets of a node's mesh, the same for all of its primitives.
fn target_count(root: &Root, node: usize) -> Result<usize, String> {
    let mesh = root.nodes.get(node).and_then(|node| node.mesh).and_then(|mesh| root.get(mesh));
    let mut counts =
        mesh.iter().flat_map(|mesh| &mesh.primitives).map(|primitive| primitive.targets.as_ref().map_or(0, Vec::len));
    let first = counts.next().unwrap_or(0);
    if counts.any(|count| count != first) {
        return Err(format!("the primitives of nodes[{node}]'s mesh have different numbers of morph targets"));
    }
    Ok(first)
}
