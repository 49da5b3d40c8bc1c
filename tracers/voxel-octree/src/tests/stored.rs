//! What a build stores, against voxels that are found in f64, and that the check notices what is wrong.

use super::*;
use crate::validate::{Stored, unpacked_normal};
use tracebench_api::Update;
use tracebench_kit::Built;

/// Trees of every kind of scene and of one to ten levels hold the voxels that their triangles touch, as f64 has it, with their normals
/// and materials: hostile triangles, one, flat ones, all of them in one voxel, none with an area.
#[test]
fn trees_are_those_of_f64() {
    let gpu = gpu();
    let far = |triangle: [[f32; 3]; 3]| triangle.map(|corner| corner.map(|value| value * 3.0 + 4e3));
    let speck = |triangle: [[f32; 3]; 3]| triangle.map(|corner| corner.map(|value| value * 1e-6));
    let scattered = hostile();
    let flat: Vec<_> = scattered.iter().map(|triangle| triangle.map(|[x, y, _]| [x, y, 2.5])).collect();
    let hollow: Vec<_> = scattered.iter().copied().map(speck).chain([[[9.0; 3], [9.0; 3], [-9.0; 3]]]).collect();
    let ends = vec![[[1.0; 3]; 3], [[-1.0; 3]; 3]];
    let single = vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.25]]];
    let scenes = [scattered.clone(), scattered.into_iter().map(far).collect(), flat, single, hollow, ends];
    for (scene, triangles) in scenes.iter().enumerate() {
        let geometry = soup(triangles, Some(&gpu));
        for levels in ["1", "3", "6"] {
            let structure = built(&gpu, &geometry, &[("levels", levels)]);
            let statistics =
                structure.validate_against(&geometry).unwrap_or_else(|error| panic!("{scene}, {levels}: {error}"));
            let of = |name: &str| statistics.iter().find(|(of, _)| *of == name).unwrap().1;
            assert_eq!(of("leaves"), of("compared_leaves"));
            assert!(of("nodes") >= 1.0 && of("fragments") >= of("leaves"));
            match scene {
                4 => assert!(of("leaves") <= 8.0, "{}", of("leaves")),
                5 => assert_eq!(of("leaves"), 0.0),
                _ => assert!(of("leaves") >= 1.0),
            }
        }
    }
    let geometry = soup(&scenes[3], Some(&gpu));
    let structure = built(&gpu, &geometry, &[("levels", "10")]);
    let statistics = structure.validate_against(&geometry).unwrap();
    assert!(statistics.iter().any(|(name, value)| *name == "leaves" && *value > 4e5), "{statistics:?}");
}

/// Two builds give the same bytes, and one that follows a scene which takes ever more room the same tree as a fresh one.
#[test]
fn builds_are_repeatable_and_grow() {
    let gpu = gpu();
    let bytes = |structure: &Built<OctreeStructure>| {
        let Stored { counts, leaves, .. } = structure.read().unwrap();
        (structure.read().unwrap().keys().unwrap(), leaves[..counts[5] as usize].to_vec())
    };
    let large = soup(&hostile(), Some(&gpu));
    let expected = bytes(&built(&gpu, &large, &[]));
    assert_eq!(bytes(&built(&gpu, &large, &[])), expected);
    let shrunk: Vec<_> = hostile()
        .iter()
        .map(|triangle| {
            let middle = Vec3::from(triangle[0]);
            triangle.map(|corner| (middle + (Vec3::from(corner) - middle) * 0.1).to_array())
        })
        .collect();
    let small = soup(&shrunk, Some(&gpu));
    let mut structure = built(&gpu, &small, &[]);
    let before = structure.tree.room;
    let rebuild = |structure: &mut Built<OctreeStructure>| {
        let mut clock = PhaseClock::new(Some(&gpu));
        structure.update(Update::Rebuild, &large, &viewpoint(), &parameters(&[]), &mut clock).unwrap();
        clock.finish().unwrap();
        structure.grow_on_overflow().unwrap()
    };
    assert!(rebuild(&mut structure), "there was room already");
    assert!(structure.validate_against(&large).is_err(), "a tree that lacks room passes");
    assert!(!rebuild(&mut structure) && structure.tree.room.hold(&before));
    structure.validate_against(&large).unwrap();
    assert_eq!(bytes(&structure), expected);
    // Room that is left changes nothing.
    let mut clock = PhaseClock::new(Some(&gpu));
    structure.update(Update::Rebuild, &small, &viewpoint(), &parameters(&[]), &mut clock).unwrap();
    clock.finish().unwrap();
    assert!(!structure.grow_on_overflow().unwrap());
    assert_eq!(bytes(&structure), bytes(&built(&gpu, &small, &[])));
}

/// Opposite normals cancel, and the lowest triangle's is left; of others the average, each triangle counted once; the material is the
/// lowest triangle's.
#[test]
fn leaves_average_normals() {
    let gpu = gpu();
    let plate = wall(0.0)[0];
    let turned = [plate[0], plate[2], plate[1]];
    let leaf = |triangles: &[[[f32; 3]; 3]]| {
        let positions = triangles.as_flattened().to_vec();
        let indices = (0..triangles.len() as u32).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
        let materials = (0..triangles.len() as u32).map(|index| 7 + index).collect();
        let geometry = Geometry::with_materials(positions, indices, materials, Some(&gpu)).unwrap();
        let structure = built(&gpu, &geometry, &[("levels", "1")]);
        structure.validate_against(&geometry).unwrap();
        let leaf = structure.read().unwrap().leaves[0];
        (unpacked_normal(leaf[0]).as_vec3(), leaf[1])
    };
    assert_eq!(leaf(&[plate, turned]), (Vec3::Z, 7));
    assert_eq!(leaf(&[turned, plate]), (Vec3::NEG_Z, 7));
    assert_eq!(leaf(&[plate, turned, plate]), (Vec3::Z, 7));
    let upright = plate.map(|[x, y, z]| [x, z, y]);
    let (normal, _) = leaf(&[plate, upright, upright]);
    let expected = Vec3::new(0.0, -2.0, 1.0).normalize();
    assert!((normal - expected).length() < 1e-4, "{normal}");
    // Sums of very many stay within 32 bits.
    let (normal, _) = leaf(&vec![plate; 70_000]);
    assert_eq!(normal, Vec3::Z);
}

/// Negative control: each thing that may be wrong with a tree is noticed.
#[test]
fn unsound_trees_are_noticed() {
    let gpu = gpu();
    let triangles = hostile();
    let geometry = soup(&triangles, Some(&gpu));
    let structure = built(&gpu, &geometry, &[]);
    let sound = structure.read().unwrap();
    structure.check(&sound, &geometry).unwrap();
    let noticed = |what: &str, spoil: &dyn Fn(&mut Stored)| {
        let mut spoilt = sound.clone();
        spoil(&mut spoilt);
        assert!(structure.check(&spoilt, &geometry).is_err(), "{what} is not noticed");
    };
    // A node of the lowest depth with room for another part, and one that may lose one.
    let lowest = sound.firsts[4] as usize;
    noticed("another first child", &|tree| tree.nodes[lowest + 1][0] += 1);
    noticed("an empty node", &|tree| tree.nodes[lowest][1] = 0);
    noticed("a part too many", &|tree| tree.nodes[lowest][1] = 0xff);
    noticed("a part that does not exist", &|tree| tree.nodes[lowest][1] |= 0x100);
    noticed("another number of leaves", &|tree| tree.counts[5] -= 1);
    noticed("another part", &|tree| {
        // All of one part moved to the one across: as many leaves, elsewhere.
        let first = lowest + (0..).find(|node| tree.nodes[lowest + node][1].count_ones() == 1).unwrap();
        tree.nodes[first][1] = 0xff ^ (1 << (7 - tree.nodes[first][1].trailing_zeros())) & 0xff;
    });
    noticed("a turned normal", &|tree| tree.leaves.iter_mut().for_each(|leaf| leaf[0] ^= 0x7000_7000));
    noticed("another material", &|tree| tree.leaves[3][1] += 1);
    let mut moved = triangles.clone();
    moved[60] = moved[60].map(|corner| corner.map(|value| value * 0.5));
    assert!(structure.validate_against(&soup(&moved, Some(&gpu))).is_err(), "another scene is not noticed");
}
