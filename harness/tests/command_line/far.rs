//! Scenes far from the origin.

use super::*;

/// Proves that a scene which lies far from the origin says so, and that a tracer whose structure is not sound there says what that means.
#[test]
fn far_scenes_say_so() {
    let bench = Bench::new();
    let far = |at: f32| {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let positions: Vec<[f32; 3]> =
            faces.iter().flatten().map(|corner: &usize| corners[*corner].map(|x: f32| x + at)).collect();
        glb(&positions)
    };
    for (at, warned) in [(1e7, true), (0.0, false)] {
        std::fs::write(bench.path("far.glb"), far(at)).unwrap();
        let words =
            ["--tracer", "bvh-cpu", "--rays", "primary", "--samples", "1", "--scene", "far.glb", "--out", "out"];
        let outcome = bench.call(&[&SMOKE[..], &words].concat());
        assert_eq!(outcome.status, 0, "{outcome:?}");
        let said = outcome.stderr.contains("warning: the scene reaches")
            && outcome.stderr.contains("move it towards the origin");
        assert_eq!(said, warned, "{outcome:?}");
        let sampled = [&SMOKE[..], &["--quiet", "--tracer", "fragment-abuffer"], &words[2..]].concat();
        if warned {
            bench.fails(&sampled, 1, &["so it is not measured in this scene", "far from the origin", "move it"]);
        } else {
            assert_eq!(bench.call(&sampled).status, 0);
        }
    }
}
