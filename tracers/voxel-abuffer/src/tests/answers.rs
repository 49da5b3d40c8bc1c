//! That how a trace reads and is launched changes nothing, and what it counts.

use super::*;
use tracebench_api::{Status, SurfaceStatus};

const SEARCHES: [[(&str, &str); 3]; 7] = [
    [("search", "dda2d"), ("inside", "parity"), ("crossing", "state")],
    [("search", "three-step"), ("inside", "nesting"), ("crossing", "change")],
    [("search", "one-step"), ("inside", "parity"), ("crossing", "change")],
    [("search", "dda2d"), ("inside", "nesting"), ("crossing", "change")],
    [("search", "dda2d"), ("in_texel", "exit"), ("crossing", "state")],
    [("search", "dda2d"), ("depths", "plane"), ("inside", "parity")],
    [("search", "dda2d"), ("depths", "plane"), ("start_along", "normal")],
];

/// Over one buffer of a kind, one an axis with data in halves, or textures of either, with a ray a lane or several, timed or counted, hits
/// and surfaces are the same bits, for every search and both queries.
#[test]
fn every_variant_gives_the_same_bits() {
    let gpu = gpu();
    let shape = [("abuffer", "80"), ("grid", "16")];
    let geometry = soup(&hostile(), Some(&gpu));
    let lists = built(&gpu, &geometry, &shape).buffers.lists.clone().unwrap();
    let most = lists.nodes.capacities.into_iter().max().unwrap();
    // Just the nodes of an axis, and half of its data; and all heads.
    let small = gpu_that_binds((u64::from(most) * 8).max(lists.heads.size()));
    let of_small = soup(&hostile(), Some(&small));
    let rays = rays(1500);
    type Answers = [(Vec<Hit>, Vec<Surface>); 2];
    let mut expected: Vec<Option<Answers>> = vec![None; SEARCHES.len()];
    let mut hits_seen = 0;
    for (device, memory_access, rays_per_lane) in
        [(0, "buffer", "1"), (0, "texture", "7"), (1, "buffer", "3"), (1, "texture", "1")]
    {
        let (gpu, geometry) = if device == 0 { (&gpu, &geometry) } else { (&small, &of_small) };
        let settings = [&shape[..], &[("memory_access", memory_access), ("rays_per_lane", rays_per_lane)]].concat();
        let structure = built(gpu, geometry, &settings);
        let nodes = &structure.buffers.lists.as_ref().unwrap().nodes;
        assert_eq!((nodes.is_by_axis(), nodes.has_halves()), (device == 1, device == 1), "{settings:?}");
        structure.validate_against(geometry).unwrap();
        for (search, expected) in SEARCHES.iter().zip(&mut expected) {
            let settings = [&settings[..], search].concat();
            let structure = built(gpu, geometry, &settings);
            let found = [Query::Closest, Query::Any].map(|query| {
                let found = answer(gpu, &structure, &rays, query, &settings, TraceTo::Surface);
                assert_eq!(answer(gpu, &structure, &rays, query, &settings, TraceTo::Hit).0, found.0, "{settings:?}");
                assert_eq!(counted(gpu, &structure, &rays, query, &settings).0, found.0, "{settings:?}");
                found
            });
            hits_seen += found[0].0.iter().filter(|hit| hit.is_hit()).count();
            let lost = found[0].1.iter().filter(|surface| surface.status == SurfaceStatus::Lost as u32).count();
            assert_eq!(lost, 0, "{settings:?}");
            assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{settings:?}");
        }
    }
    assert!(hits_seen > 7500, "{hits_seen}");
    // Negative control: other searches do give others.
    assert!((1..SEARCHES.len()).all(|other| expected[other] != expected[0]));
}

/// What is counted agrees with itself: fewer points are compared at fewer steps, none by binary search where any hit will do, and no more
/// is touched than there is; voxels alone are stepped through, hit where a ray enters them, and have no surfaces.
#[test]
fn counters_count_what_is_done() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let shape = [("abuffer", "80"), ("grid", "8")];
    let structure = built(&gpu, &geometry, &shape);
    let rays = rays(600);
    let of =
        |search: &str, query| counted(&gpu, &structure, &rays, query, &[&shape[..], &[("search", search)]].concat());
    let compared =
        ["one-step", "three-step", "dda2d"].map(|search| total(&of(search, Query::Closest).1, "depth_comparisons"));
    assert!(compared[0] > 0 && compared.is_sorted() && compared[0] < compared[2], "{compared:?}");
    let (hits, counters) = of("dda2d", Query::Closest);
    let (_, of_any) = of("dda2d", Query::Any);
    let found = hits.iter().filter(|hit| hit.is_hit()).count() as u64;
    let saved = total(&counters, "depth_comparisons") - total(&of_any, "depth_comparisons");
    // Eight halvings a hit, but for those at a voxel's entry.
    assert!(saved > 0 && saved <= 8 * found && saved.is_multiple_of(8), "{saved} {found}");
    let [stepped, opened, searches] =
        ["voxels_stepped", "voxels_opened", "searches"].map(|name| total(&counters, name));
    assert!(stepped > opened && opened >= searches && searches > 0, "{stepped} {opened} {searches}");
    let capacity = u64::from(structure.buffers.lists.as_ref().unwrap().nodes.capacity());
    let touched = total(&counters, "fragments_touched");
    assert!(touched > 0 && touched <= capacity && touched <= total(&counters, "layers_tested"));
    let only = [("structure", "voxels-only"), ("grid", "80")];
    let voxels = built(&gpu, &geometry, &only);
    let (hits, counters) = counted(&gpu, &voxels, &rays, Query::Closest, &only);
    assert_eq!(hits, closest(&gpu, &voxels, &rays, &only));
    assert!(
        total(&counters, "voxels_stepped") > rays.len() as u64 && hits.iter().filter(|hit| hit.is_hit()).count() > 100
    );
    let textures = [&only[..], &[("memory_access", "texture"), ("rays_per_lane", "5")]].concat();
    assert_eq!(closest(&gpu, &built(&gpu, &geometry, &textures), &rays, &textures), hits);
    let buffer = RayBuffer::new(Arc::new(rays.clone()), Query::Closest, Some(&gpu));
    let mut hits = HitBuffer::tracing_to(TraceTo::Surface, rays.len(), Residency::Device, Some(&gpu)).unwrap();
    let job = TraceJob { rays: &buffer, trace_to: TraceTo::Surface, parameters: &parameters(&only) };
    let refused = voxels.trace(job, &mut hits, &mut PhaseClock::new(Some(&gpu))).unwrap_err();
    assert!(matches!(&refused, TracerError::Unsupported(what) if what.contains("two-level")), "{refused}");
}

/// Voxels alone: a ray that starts in a wall's voxels leaves them first, and stops as it enters those of the next wall.
#[test]
fn voxels_alone_are_hit_where_they_are_entered() {
    let gpu = gpu();
    let wall = |z: f64| rectangle(DVec3::new(-1.0, -1.0, z), DVec3::X * 2.0, DVec3::Y * 2.0);
    let geometry = soup(&[wall(-1.0), wall(0.31), wall(1.0)].concat(), Some(&gpu));
    let settings = [("structure", "voxels-only"), ("grid", "50")];
    let structure = built(&gpu, &geometry, &settings);
    let rays = [
        ray(DVec3::new(0.1, 0.2, -1.0), DVec3::Z),
        ray(DVec3::new(0.1, 0.2, -3.0), DVec3::Z),
        ray(DVec3::new(0.1, 0.2, 0.9), DVec3::NEG_Z),
    ];
    let hits = closest(&gpu, &structure, &rays, &settings);
    // Voxels are 2/48 wide.
    for (hit, t) in hits.iter().zip([1.31, 2.0, 0.59]) {
        let before = t - f64::from(hit.t);
        assert!(hit.is_hit() && (-1e-3..2.0 / 48.0 + 1e-3).contains(&before), "{hit:?} {t}");
    }
}

/// Rays whose lanes have more to do than a driver lets loops run are answered all the same, as with a ray a lane. Hundreds of layers a
/// texel are tested at dozens of points: ten such rays a lane are more than Mesa's 65,535 rounds.
#[test]
fn rays_of_lanes_that_are_cut_off_are_answered() {
    let gpu = gpu();
    let wall = |z: f64| rectangle(DVec3::new(-9.0, -9.0, z), DVec3::X * 18.0, DVec3::Y * 18.0);
    let walls: Vec<[[f32; 3]; 3]> = (0..300).flat_map(|index| wall(0.01 * f64::from(index))).collect();
    let geometry = soup(&walls, Some(&gpu));
    let mut numbers = Numbers::new(12);
    let along = |index: usize| {
        let origin = DVec3::new(-8.9, 5.0 * numbers.signed(), 1.995 + 0.02 * (index % 5) as f64);
        ray(origin, DVec3::new(1.0, 0.0, if index.is_multiple_of(8) { 0.004 * numbers.signed() } else { 0.0 }))
    };
    let rays: Vec<Ray> = (0..640).map(along).collect();
    let structure = built(&gpu, &geometry, &[]);
    let of = |rays_per_lane| {
        let settings = [("rays_per_lane", rays_per_lane)];
        answer(&gpu, &structure, &rays, Query::Closest, &settings, TraceTo::Surface)
    };
    let one = of("1");
    let count = |is: fn(&Hit) -> bool| one.0.iter().filter(|hit| is(hit)).count();
    assert!(count(Hit::is_hit) > 20 && count(|hit| !hit.is_hit()) > 300, "{}", count(Hit::is_hit));
    assert!(of("10") == one && of("256") == one);
    assert!(count(|hit| hit.status == Status::Unwritten as u32) == 0);
}
