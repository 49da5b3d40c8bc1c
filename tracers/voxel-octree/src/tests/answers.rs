//! That how a trace finds its way, reads and is launched changes nothing, and what it counts.

use super::*;
use tracebench_api::SurfaceStatus;

fn rays(count: usize) -> Vec<Ray> {
    let mut numbers = Numbers::new(9);
    (0..count).map(|_| ray(numbers.point() * 8.0, numbers.direction())).collect()
}

/// From the root every time or off a stack, over buffers or textures, with a ray a lane or several, timed or counted, hits and surfaces are
/// the same bits; any hit is there where the closest is; and where in a voxel a hit is does not change whether there is one.
#[test]
fn every_variant_gives_the_same_bits() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let rays = rays(1500);
    let mut by_place = Vec::new();
    for place in ["entry", "centre"] {
        let mut expected: Option<[(Vec<Hit>, Vec<Surface>); 2]> = None;
        for (traversal, memory_access, rays_per_lane) in [
            ("restart", "buffer", "1"),
            ("stack", "buffer", "3"),
            ("restart", "texture", "7"),
            ("stack", "texture", "1"),
        ] {
            let settings = [
                ("traversal", traversal),
                ("memory_access", memory_access),
                ("rays_per_lane", rays_per_lane),
                ("hit", place),
            ];
            let structure = built(&gpu, &geometry, &settings);
            structure.validate_against(&geometry).unwrap();
            let found = [Query::Closest, Query::Any].map(|query| {
                let (hits, surfaces, _) = answer(&structure, &rays, query, &settings, TraceTo::Surface, false);
                assert_eq!(answer(&structure, &rays, query, &settings, TraceTo::Hit, false).0, hits, "{settings:?}");
                for end in TraceTo::ALL {
                    let counted = answer(&structure, &rays, query, &settings, end, true);
                    assert!(counted.0 == hits && (end == TraceTo::Hit || counted.1 == surfaces), "{settings:?}");
                }
                (hits, surfaces)
            });
            let is_hit = |hits: &[Hit]| hits.iter().map(Hit::is_hit).collect::<Vec<_>>();
            assert_eq!(is_hit(&found[0].0), is_hit(&found[1].0), "{settings:?}");
            let written = found[0].1.iter().filter(|surface| surface.status == SurfaceStatus::Written as u32).count();
            assert_eq!(written, found[0].0.iter().filter(|hit| hit.is_hit()).count(), "{settings:?}");
            assert!(written > 300 && written < 1400, "{written}");
            assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{settings:?}");
        }
        by_place.push(expected.unwrap()[0].0.clone());
    }
    let [entry, centre] = &by_place[..] else { panic!("two places") };
    assert!(entry.iter().zip(centre).all(|(entry, centre)| entry.is_hit() == centre.is_hit() && entry.t <= centre.t));
    // Negative control: the places do differ.
    assert!(entry != centre);
}

/// What is counted agrees with itself: from the root as many nodes are read as there are levels to the part of every step, off a stack
/// fewer, in as many steps; no more is touched than there is; and no ray takes more rounds than lanes are dealt out by.
#[test]
fn counters_count_what_is_done() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let rays = rays(800);
    for levels in ["1", "4", "7"] {
        let structure = built(&gpu, &geometry, &[("levels", levels)]);
        let of = |traversal| {
            let settings = [("levels", levels), ("traversal", traversal)];
            answer(&structure, &rays, Query::Closest, &settings, TraceTo::Hit, true).2
        };
        let (restart, stack) = (of("restart"), of("stack"));
        let count = |name| [total(&restart, name), total(&stack, name)];
        let [restarted, stacked] = count("nodes_visited");
        let [steps, same] = count("steps");
        let depth: u64 = levels.parse().unwrap();
        assert!(
            steps == same && steps >= rays.len() as u64 / 2 && restarted >= steps && restarted <= depth * steps,
            "{levels}"
        );
        assert!(if depth == 1 { stacked == restarted } else { stacked < restarted && stacked >= steps }, "{levels}");
        assert!(stacked <= 3 * steps + depth * rays.len() as u64, "{levels}: {stacked} of {steps}");
        let room = structure.tree.room;
        for (name, stored) in
            [("nodes_touched", room.nodes_before(depth as u32)), ("leaves_touched", room.leaves(depth as u32))]
        {
            let [touched, same] = count(name);
            assert!(
                touched == same && touched > 0 && touched <= u64::from(stored),
                "{levels}: {name} {touched} of {stored}"
            );
        }
    }
}

/// Rays that go through as much of a tree as any may are answered by every traversal: along a stack of walls, between two of them.
#[test]
fn the_longest_ways_are_walked_to_their_ends() {
    let gpu = gpu();
    let walls: Vec<_> = (0..40).flat_map(|index| wall(f64::from(index) * 0.05 - 1.0)).collect();
    let geometry = soup(&walls, Some(&gpu));
    let mut numbers = Numbers::new(3);
    let rays: Vec<Ray> = (0..256)
        .map(|index| ray(DVec3::new(-2.0, numbers.signed(), f64::from(index % 39) * 0.05 - 0.975), DVec3::X))
        .collect();
    let settings = |traversal| [("levels", "7"), ("traversal", traversal), ("rays_per_lane", "256")];
    let structure = built(&gpu, &geometry, &settings("restart"));
    for traversal in ["restart", "stack"] {
        let hits = closest(&structure, &rays, &settings(traversal));
        assert!(hits.iter().all(|hit| hit.status == tracebench_api::Status::Miss as u32), "{traversal}");
    }
    let counters = answer(&structure, &rays, Query::Closest, &settings("stack"), TraceTo::Hit, true).2;
    let most = counters.iter().find(|counter| counter.name == "steps").unwrap().max_per_ray.unwrap();
    assert!(most >= 100, "{most}");
}
