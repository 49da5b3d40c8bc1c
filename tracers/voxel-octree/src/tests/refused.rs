//! Bad input: what is refused, and that it says what to do.

use super::*;

fn refused(gpu: &Arc<Gpu>, triangles: &[[[f32; 3]; 3]], settings: &[(&str, &str)], said: &[&str]) {
    let geometry = soup(triangles, Some(gpu));
    let Err(error) = try_built(gpu, &geometry, settings) else { panic!("{settings:?} is not refused") };
    let error = error.to_string();
    assert!(said.iter().all(|part| error.contains(part)), "{error}");
}

/// More levels than keys have bits, trees that the device cannot bind and places that are no numbers are errors that say what to turn down.
#[test]
fn bad_input_says_what_to_do() {
    let gpu = gpu();
    let mut set = Parameters::preset(&description().parameters, Preset::Published);
    let error = set.set(&description().parameters, "levels", "11").unwrap_err().to_string();
    assert!(error.contains("levels") && error.contains("10"), "{error}");
    // A wall of a million voxels on a device that binds a hundred thousand words.
    let small = gpu_that_binds(400_000);
    refused(&small, &wall(0.0), &[("levels", "10")], &["keys of fragments", "voxel-octree.levels"]);
    refused(&small, &vec![wall(0.0)[0]; 3000], &[("levels", "7")], &["fragments of rows", "voxel-octree.levels"]);
    assert!(try_built(&small, &soup(&wall(0.0), Some(&small)), &[("levels", "6")]).is_ok());
    for wrong in [f32::NAN, f32::INFINITY] {
        let mut triangles = hostile();
        triangles[3][1][2] = wrong;
        refused(&gpu, &triangles, &[], &["1 triangles", "not finite"]);
    }
}
