//! Real meshes, where there are any: set `TRACEBENCH_MESHES` to a folder with `.glb` and `.gltf` files.
#![allow(missing_docs)]

use crate::support;

use std::path::PathBuf;
use std::time::Instant;

use support::promises;
use support::watertight::is_watertight;
use tracebench_scenes::import;

/// Proves that every file of the folder is imported and keeps the promises of a scene, and prints what it is.
#[test]
fn files_of_a_folder() {
    let Some(folder) = std::env::var_os("TRACEBENCH_MESHES") else {
        println!("skipped: TRACEBENCH_MESHES names no folder with .glb or .gltf files");
        return;
    };
    let entries = std::fs::read_dir(&folder).expect("the folder that TRACEBENCH_MESHES names");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf"));
    paths.sort();
    assert!(!paths.is_empty(), "{} holds no .glb or .gltf file", folder.display());
    for path in paths {
        let start = Instant::now();
        let scene = import(&path).unwrap();
        let import_s = start.elapsed().as_secs_f64();
        let outcome = promises::check_scene(&scene).unwrap();
        println!(
            "{}: {} triangles, {} vertices, {} materials, {} objects, {} cameras, {outcome:?}, watertight: {}, {import_s:.3} s\n  {:?}",
            scene.name,
            scene.mesh.triangles.len(),
            scene.mesh.positions.len(),
            scene.mesh.materials.len(),
            scene.mesh.objects.len(),
            scene.cameras.len(),
            is_watertight(&scene.mesh),
            scene.notes,
        );
    }
}
