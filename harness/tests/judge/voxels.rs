//! Causes of methods that know the scene by voxels, each from a scene that shows it and from one that is nearly the same and does
//! not.

use super::*;
use glam::DVec2;
use tracebench_api::{ImageChoice, Orthographic};

/// A cube of edge 4 about the middle: voxels of 1/2, texels of 1/16, whose centres lie at odd multiples of 1/32.
fn grid() -> VoxelGrid {
    let images = ImageChoice {
        by_dominant_axis: false,
        as_lines: false,
        cancelled_below: 0.1,
        points: None,
        layers_passed: false,
        from_start: true,
        start_texels: 1.0,
    };
    VoxelGrid { low: DVec3::splat(-2.0), voxel: DVec3::splat(0.5), size: 8, images: Some(images) }
}

fn images() -> Vec<SampledImage> {
    let image = |axis: usize| Orthographic {
        origin: DVec3::splat(-2.0),
        right: DVec3::AXES[(axis + 1) % 3],
        up: -DVec3::AXES[(axis + 2) % 3],
        axis: DVec3::AXES[axis],
        texel: DVec2::splat(1.0 / 16.0),
        far: 4.0,
        size: [64, 64],
    };
    let sampling = |axis| SampledImage::new(Projection::Orthographic(image(axis)), Layers::All);
    (0..3).map(sampling).collect()
}

/// A solid with six sides by its corners: x, y and z count up in this order.
fn hexahedron(corners: [[f32; 3]; 8]) -> Vec<[[f32; 3]; 3]> {
    // Seen from outside, counter-clockwise.
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let halves = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|half| half.map(|corner: usize| corners[corner])).collect()
}

fn solid(low: [f32; 3], high: [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    let corner = |index: usize| std::array::from_fn(|axis| if index >> axis & 1 == 0 { low[axis] } else { high[axis] });
    hexahedron(std::array::from_fn(corner))
}

/// The cause of a wrong answer to a ray.
fn cause_by(grid: VoxelGrid, triangles: Vec<[[f32; 3]; 3]>, ray: Ray, answer: Hit) -> String {
    let mut case = Case::new(framed(triangles), vec![ray], Query::Closest);
    // Far off, so that a pixel of the reference camera is small and hides no cause.
    case.eye = Vec3::from(ray.origin).as_dvec3();
    assert!(!case.answers[0].is_ambiguous());
    (case.samplings, case.voxels) = (images(), Some(grid));
    case.cause("tight", &[answer])
}

fn cause(triangles: Vec<[[f32; 3]; 3]>, ray: Ray, answer: Hit) -> String {
    cause_by(grid(), triangles, ray, answer)
}

fn towards(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    ray(origin, Vec3::from(direction).normalize().into())
}

fn with(change: impl FnOnce(&mut ImageChoice)) -> VoxelGrid {
    let mut choice = grid().images.unwrap();
    change(&mut choice);
    VoxelGrid { images: Some(choice), ..grid() }
}

/// Proves `open_mesh`: over a single sheet the image that looks onto it has another side than the one along which the ray
/// comes. A hit that was invented there is so explained, and so is the sheet being missed; of a closed solid with the same
/// top neither is, and the sheet's being missed is not by a ray that is told by one image all the way.
#[test]
fn open_meshes_contradict_themselves() {
    let sheet = || rectangle([-1.0, -1.0, -0.3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec();
    let block = || solid([-1.0, -1.0, -1.3], [1.0, 1.0, -0.3]);
    let over = towards([-1.7, 0.1, -0.1], [1.0, 0.0, 0.0]);
    assert_eq!(cause(sheet(), over, hit(0.8)), "open_mesh");
    assert_eq!(cause(block(), over, hit(0.8)), "unexplained");
    let slanted = towards([-0.9, 0.1, 0.1], [1.0, 0.1, -0.5]);
    assert_eq!(cause(sheet(), slanted, miss()), "open_mesh");
    assert_eq!(cause(block(), slanted, miss()), "unexplained");
    let steep = towards([-0.3, 0.1, 0.1], [0.3, 0.1, -1.0]);
    assert_ne!(cause(sheet(), steep, miss()), "open_mesh");
}

/// Proves `wrong_side_at_start`: the start lies lower than the slope's height at its texel's centre, uphill of it. As a negative
/// control, not where the centre lies downhill, nor far off by a method that tells sides anew, nor once the start is left behind
/// by more.
#[test]
fn starts_are_told_by_their_texels_centre() {
    let rise = 0.8;
    let corner = |index: usize| {
        let x = if index & 1 == 0 { -1.0 } else { 1.0 };
        let y = if index & 2 == 0 { -1.0 } else { 1.0 };
        [x, y, if index & 4 == 0 { -1.5 } else { rise * x }]
    };
    let slope = || hexahedron(std::array::from_fn(corner));
    // Along a contour, so that the ray stays as near to the slope; the texel is that of x from 1/16 to 2/16.
    let start = |across: f32, lift: f32| [across, 0.1, rise * across + lift];
    let along = |x: f32| towards(start(x, 0.005), [0.0, 1.0, 0.0]);
    assert_eq!(cause(slope(), along(1.1 / 16.0), hit(0.3)), "wrong_side_at_start");
    assert_eq!(cause(slope(), along(1.9 / 16.0), hit(0.3)), "between_samples");
    // By a method that tells sides anew it goes no farther than the voxels that follow one another.
    let by_change = with(|choice| choice.from_start = false);
    for (t, expected) in [(0.3, "wrong_side_at_start"), (1.6, "unexplained")] {
        assert_eq!(cause_by(by_change, slope(), along(1.1 / 16.0), hit(t)), expected);
        assert_eq!(cause(slope(), along(1.1 / 16.0), hit(t)), "wrong_side_at_start");
    }
    // Uphill away from the slope: a texel on the start is told rightly, at once it is not.
    let away = towards(start(1.1 / 16.0, 0.005), [0.0, 1.0, 1.0]);
    let at_once = with(|choice| choice.start_texels = 0.0);
    assert_eq!(cause_by(at_once, slope(), away, hit(0.02)), "wrong_side_at_start");
    assert_eq!(cause(slope(), away, hit(0.02)), "between_samples");
}

/// Proves `thinner_than_texel` and `several_surfaces`: a wall that is crossed within a voxel by a ray along the image's axis is
/// missed for its thinness, or, thicker than a texel, since the ray's side is not asked before it is out again. As a negative
/// control, neither explains a wall in which the side is asked, as it goes through a border of voxels.
#[test]
fn what_is_left_in_the_same_voxel_is_not_asked() {
    let wall = |from: f32, to: f32| solid([from, -1.0, -1.0], [to, 1.0, 1.0]);
    let through = towards([-0.9, 0.1, 0.1], [1.0, 0.0, 0.0]);
    assert_eq!(cause(wall(0.1, 0.14), through, miss()), "thinner_than_texel");
    assert_eq!(cause(wall(0.1, 0.2), through, miss()), "several_surfaces");
    assert_eq!(cause(wall(0.4, 0.6), through, miss()), "unexplained");
    // Slanted, it is asked in every texel, but not at one point a voxel.
    let slanted = towards([-0.9, 0.1, 0.1], [1.0, 0.6, 0.0]);
    assert_eq!(cause(wall(0.1, 0.3), slanted, miss()), "unexplained");
    let once = with(|choice| choice.points = Some(1));
    assert_eq!(cause_by(once, wall(0.1, 0.3), slanted, miss()), "several_surfaces");
    // Where layers are seen that are passed within a texel, they would have been.
    let passed = with(|choice| choice.layers_passed = true);
    assert_eq!(cause_by(passed, wall(0.1, 0.3), through, miss()), "unexplained");
    // A hit behind it says no more than a miss.
    assert_eq!(cause(wall(0.1, 0.2), through, hit(1.6)), "several_surfaces");
}

/// Proves `wrong_axis`: the normals of a thin wall cancel, so that the ray depends on the image that shows it edge-on, between
/// the texels' centres, where the one along its normals would show it. As a negative control, not where the wall covers a row of
/// centres, nor where normals are averaged as lines and choose the right image.
#[test]
fn cancelled_normals_choose_the_wrong_image() {
    let wall = |from: f32| solid([from, -1.0, -1.0], [from + 0.04, 1.0, 1.0]);
    let along = |x: f32| towards([x, 0.0, 0.7], [0.1, 0.05, -1.0]);
    assert_eq!(cause(wall(0.1), along(0.05), miss()), "wrong_axis");
    assert_eq!(cause(wall(0.13), along(0.08), miss()), "thinner_than_texel");
    let as_lines = with(|choice| choice.as_lines = true);
    assert_eq!(cause_by(as_lines, wall(0.1), along(0.05), miss()), "thinner_than_texel");
}

/// Proves `between_samples`: a hit was told within a texel of a surface that the ray passes, or too late within a texel of the one
/// that it goes through, or a surface lies on the border of voxels; as a negative control, neither farther off, nor off the border.
#[test]
fn near_surfaces_lie_between_samples() {
    let block = || solid([-1.0, -1.0, -1.3], [1.0, 1.0, 0.0]);
    for (height, expected) in [(0.05, "between_samples"), (0.075, "unexplained")] {
        let over = towards([-1.5, 0.1, height], [1.0, 0.0, 0.0]);
        assert_eq!(cause(block(), over, hit(1.0)), expected);
    }
    // Down by 0.1 to the right by 1: too late by half a unit is too deep by 0.05.
    let grazing = towards([-0.9, 0.1, 0.1], [1.0, 0.0, -0.1]);
    assert_eq!(cause(block(), grazing, hit(1.5)), "between_samples");
    assert_eq!(cause(block(), grazing, hit(1.9)), "unexplained");
    for (bottom, expected) in [(-0.5, "between_samples"), (-0.55, "unexplained")] {
        let within = solid([-1.2, -1.2, bottom], [1.2, 1.2, 0.7]);
        assert_eq!(cause(within, towards([0.1, 0.1, 0.3], [0.1, 0.2, -1.0]), miss()), expected);
    }
}

/// Proves that a method that sees the layers of every texel is held to have asked those of the texel that its ray enters, too: a
/// sheet that covers that texel's centre, and nothing where the ray is, contradicts itself there. As negative controls, not for one that
/// asks as it leaves a texel, nor a closed block with the same top, nor a sheet that leaves the centre free.
#[test]
fn the_texel_that_a_ray_enters_is_asked() {
    // A border of texels at 1/16, the next centre at 1.5/16.
    let sheet = |from: f32| rectangle([from, -1.0, -0.3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec();
    let block = || solid([0.09, -1.0, -1.3], [1.09, 1.0, -0.3]);
    let over = towards([-1.7, 0.1, -0.1], [1.0, 0.0, 0.0]);
    let told = hit(1.7 + 1.0 / 16.0);
    let passed = with(|choice| choice.layers_passed = true);
    assert_eq!(cause_by(passed, sheet(0.09), over, told), "open_mesh");
    assert_eq!(cause(sheet(0.09), over, told), "unexplained");
    assert_eq!(cause_by(passed, block(), over, told), "unexplained");
    assert_eq!(cause_by(passed, sheet(0.1), over, told), "unexplained");
}

/// Proves that a layer at the centre of a texel explains the end of a ray that goes past it within the texel, as far as the voxel
/// is looked into at once. As negative controls, neither in the next texel, nor a voxel farther, nor for one that asks sides alone.
#[test]
fn a_layer_beside_the_ray_lies_between_samples() {
    // About the centre of the texel from 1/16 to 2/16.
    let grain = || solid([0.088, 0.088, 0.3], [0.1, 0.1, 0.33]);
    let past = |x: f32| towards([x, 0.07, 0.9], [0.0, 0.0, -1.0]);
    let passed = with(|choice| choice.layers_passed = true);
    assert_eq!(cause_by(passed, grain(), past(0.07), hit(0.9)), "between_samples");
    assert_eq!(cause(grain(), past(0.07), hit(0.9)), "unexplained");
    assert_eq!(cause_by(passed, grain(), past(0.05), hit(0.9)), "unexplained");
    assert_eq!(cause_by(passed, grain(), past(0.07), hit(1.4)), "unexplained");
}

/// Proves that what no texel's centre shows where a side is asked lies between samples: a hole in the bottom of a
/// block, about a centre, shows its inside as its outside. As a negative control, not where it lies beside the centre.
#[test]
fn what_is_not_shown_lies_between_samples() {
    let holed = |hole: f32| {
        // A block whose bottom has a hole: four plates about it.
        let [low, high] = [hole - 0.005, hole + 0.005];
        let mut triangles = solid([-1.0, -1.0, -0.95], [1.0, 1.0, 1.0]);
        triangles.drain(8..10);
        let plate = |x: f32, y: f32, wide: f32, deep: f32| rectangle([x, y, -0.95], [0.0, deep, 0.0], [wide, 0.0, 0.0]);
        triangles.extend(plate(-1.0, -1.0, low + 1.0, 2.0));
        triangles.extend(plate(high, -1.0, 1.0 - high, 2.0));
        triangles.extend(plate(low, -1.0, high - low, low + 1.0));
        triangles.extend(plate(low, high, high - low, 1.0 - high));
        triangles
    };
    let up = towards([0.08, 0.08, -1.4], [0.0, 0.0, 1.0]);
    for (hole, expected) in [(1.5 / 16.0, "between_samples"), (1.8 / 16.0, "unexplained")] {
        assert_eq!(cause(holed(hole), up, hit(1.2)), expected);
    }
}

/// Proves `near_start`: the true hit lies in what a ray leaves out of its way. As a negative control, not once it leaves out less.
#[test]
fn what_is_left_out_is_near_the_start() {
    let block = || solid([-1.0, -1.0, -1.3], [1.0, 1.0, -0.1]);
    let down = towards([0.1, 0.1, 0.0], [0.1, 0.2, -1.0]);
    for (texels, expected) in [(1.0, "unexplained"), (2.0, "near_start")] {
        let grid = with(|choice| choice.start_texels = texels);
        assert_eq!(cause_by(grid, block(), down, miss()), expected);
    }
}

/// Proves the causes of methods that know of voxels no more than that they have anything: a hit in a voxel that a surface goes
/// through, or less than a voxel too late, or what covers no voxel's middle line, lie between samples; what is met before the
/// voxels about the start have ended is near the start. As negative controls, none of these a voxel farther.
#[test]
fn voxels_alone_are_as_wide_as_they_are() {
    let alone = VoxelGrid { images: None, ..grid() };
    let block = || solid([-1.2, -1.2, -1.3], [1.2, 1.2, 0.2]);
    for (height, expected) in [(0.4, "between_samples"), (0.6, "unexplained")] {
        let over = towards([-1.7, 0.1, height], [1.0, 0.0, 0.0]);
        assert_eq!(cause_by(alone, block(), over, hit(1.0)), expected);
    }
    // Voxels are taken as wide as methods take them, which round: 1/256 of one more.
    for (top, expected) in [(0.499, "between_samples"), (0.49, "unexplained")] {
        let over = towards([-1.7, 0.1, 0.6], [1.0, 0.0, 0.0]);
        assert_eq!(cause_by(alone, solid([-1.2, -1.2, -1.3], [1.2, 1.2, top]), over, hit(1.0)), expected);
    }
    let down = |from: f32| towards([0.1, 0.1, from], [0.0, 0.1, -1.0]);
    assert_eq!(cause_by(alone, block(), down(0.45), miss()), "near_start");
    assert_eq!(cause_by(alone, block(), down(0.9), miss()), "unexplained");
    // In the voxel of the true hit, wherever a leaf is held to be met, and not in the next, which the ray comes to later.
    assert_eq!(cause_by(alone, block(), down(0.9), hit(0.85)), "between_samples");
    assert_eq!(cause_by(alone, block(), down(0.9), hit(1.1)), "unexplained");
    assert_eq!(cause_by(alone, block(), down(0.9), hit(1.9)), "unexplained");
    // Middle lines lie at odd multiples of 1/4.
    let patch = |at: f32| rectangle([at, at, 0.05], [0.05, 0.0, 0.0], [0.0, 0.05, 0.0]).to_vec();
    let onto = |at: f32| towards([at + 0.02, at + 0.03, 0.9], [0.0, 0.0, -1.0]);
    assert_eq!(cause_by(alone, patch(0.1), onto(0.1), miss()), "between_samples");
    assert_eq!(cause_by(alone, patch(0.23), onto(0.23), miss()), "unexplained");
}
