//! Fragments that are oriented planes: what is stored, and what rays meet, against triangles in f64.

use super::true_hits::{corners, distance_to, fault, true_hit};
use super::*;
use tracebench_api::wgpu::Buffer;
use tracebench_api::{SurfaceStatus, Update};
use tracebench_kit::Built;

const PLANES: (&str, &str) = ("fragments", "planes");

/// No bias: rays are met from where they start.
fn planes(settings: &[(&'static str, &'static str)]) -> Vec<(&'static str, &'static str)> {
    [&[PLANES, ("start_bias", "0")], settings].concat()
}

/// Edge of the largest texel, in the scene.
fn texel(structure: &Built<VoxelStructure>) -> f64 {
    let space = structure.layout.space;
    let least = space.scale.into_iter().fold(f32::INFINITY, f32::min);
    1.0 / (f64::from(least) * f64::from(space.image))
}

/// Holds hits against the triangles, within `near` texels; how many rays truly meet one.
fn check_hits(
    structure: &Built<VoxelStructure>,
    triangles: &[[[f32; 3]; 3]],
    rays: &[Ray],
    hits: &[Hit],
    near: f64,
) -> usize {
    let near = near * texel(structure);
    let mut true_hits = 0;
    for (index, (ray, hit)) in rays.iter().zip(hits).enumerate() {
        let truth = true_hit(triangles, ray);
        true_hits += usize::from(truth.is_some());
        if let Some(fault) = fault(triangles, ray, hit, truth, near) {
            panic!("ray {index} {ray:?} {fault}: {hit:?}");
        }
    }
    true_hits
}

/// A ball of slanted triangles without a gap, each face of an octahedron divided so often.
fn ball(divided: u32, radius: f64) -> Vec<[[f32; 3]; 3]> {
    let mut faces: Vec<[DVec3; 3]> = Vec::new();
    for signs in 0..8 {
        let sign = |bit: u32| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
        faces.push([DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)]);
    }
    for _ in 0..divided {
        let split = |[a, b, c]: [DVec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    // Off the axes, so that nothing is symmetric.
    let centre = DVec3::new(0.3, -0.2, 0.1);
    let placed = |corner: DVec3| (centre + corner * radius).as_vec3().into();
    faces.into_iter().map(|corners| corners.map(placed)).collect()
}

/// All fragments of an axis with their texels, in an order of their own.
fn fragments(gpu: &Gpu, structure: &Built<VoxelStructure>) -> Vec<(usize, u32, [u32; 4])> {
    let lists = structure.buffers.lists.as_ref().unwrap();
    let read =
        |buffer: &Buffer| -> Vec<u32> { bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size()).unwrap()) };
    let heads = read(&lists.heads);
    let mut found = Vec::new();
    for axis in 0..3 {
        let [nodes, data] = structure.nodes_of(lists, axis).unwrap();
        let nodes: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&nodes);
        let data: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&data);
        for texel in 0..structure.layout.texels() as usize {
            let place = axis * structure.layout.head_stride() as usize + texel;
            let mut link = heads[place];
            while link != 0 {
                let node = link as usize - 1;
                found.push((place, nodes[node][0], data[node]));
                link = nodes[node][1];
            }
        }
    }
    found.sort_unstable();
    found
}

/// What is stored of hostile triangles, of large plates and of a ball is what the host clips in f64, by every shape of the structure; and
/// by the rasterizer and in compute the same fragments are stored, bit for bit, and the same voxels marked.
#[test]
fn planes_are_what_the_host_clips() {
    let gpu = gpu();
    let plates = [
        rectangle(DVec3::new(-3.0, -2.0, 0.4), DVec3::new(6.0, 0.0, 0.9), DVec3::new(0.2, 5.0, 0.0)),
        rectangle(DVec3::new(-3.0, 0.3, -3.0), DVec3::new(6.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 6.0)),
        rectangle(DVec3::new(-1.0, -3.0, -3.0), DVec3::new(0.0, 6.0, 0.0), DVec3::new(1.9, 0.0, 6.0)),
    ]
    .concat();
    for (name, triangles) in [("hostile", hostile()), ("plates", plates), ("ball", ball(3, 2.0))] {
        let geometry = soup(&triangles, Some(&gpu));
        for settings in
            [&[("abuffer", "160")][..], &[("fit", "box")], &[("abuffer", "33"), ("grid", "40")], &[("grid", "7")]]
        {
            let of = |build: &'static str| {
                let settings = planes(&[settings, &[("build", build)]].concat());
                match try_built(&gpu, &geometry, &settings) {
                    // In compute lists bind more at once than some drivers allow.
                    Err(TracerError::Unavailable(why)) if build == "compute" => {
                        assert!(why.contains("storage buffers in a stage"), "{why}");
                        None
                    }
                    built => Some(built.unwrap()),
                }
            };
            let structure = of("raster").unwrap();
            let found = structure.validate_against(&geometry);
            let found = found.unwrap_or_else(|error| panic!("{name} {settings:?}: {error}"));
            let count = |name: &str| found.iter().find(|(each, _)| *each == name).unwrap().1;
            let some = count("occupied_voxels") > 50.0 && count("fragments") > 1000.0;
            assert!(some && count("occupied_voxels") < count("voxels"), "{name} {settings:?}: {found:?}");
            if let Some(other) = of("compute") {
                other.validate_against(&geometry).unwrap_or_else(|error| panic!("{name} {settings:?}: {error}"));
                let both = [&structure, &other].map(|structure| fragments(&gpu, structure));
                let extra = both[0].iter().zip(&both[1]).find(|(one, other)| one != other);
                assert!(both[0] == both[1], "{name} {settings:?} {} {} {extra:?}", both[0].len(), both[1].len());
                assert!(structure.voxel_codes().unwrap() == other.voxel_codes().unwrap(), "{name} {settings:?}");
            }
        }
    }
}

/// The same of scenes of 1e12 units and of 1e-12, of a point, of one triangle and of flat ones.
#[test]
fn planes_of_any_scale_are_stored() {
    let gpu = gpu();
    let plate = rectangle(DVec3::new(-1.0, -2.0, 3.0), DVec3::X * 4.0, DVec3::Y * 2.0);
    let one = [[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]];
    let point = [[[4.0, 5.0, -6.0]; 3]];
    let many = [hostile(), ball(2, 3.0)].concat();
    for triangles in [&plate[..], &one, &point, &many] {
        for scale in [1.0_f32, 1e12, 1e-12] {
            let scaled: Vec<_> =
                triangles.iter().map(|corners| corners.map(|corner| corner.map(|x| x * scale))).collect();
            let geometry = soup(&scaled, Some(&gpu));
            for fit in ["cube", "box"] {
                let settings = planes(&[("fit", fit)]);
                let structure = built(&gpu, &geometry, &settings);
                structure.validate_against(&geometry).unwrap_or_else(|error| panic!("{scale} {fit}: {error}"));
                if triangles.len() < 2 || triangles.len() > 100 {
                    continue;
                }
                let through: Vec<Ray> = (0..50)
                    .map(|index| {
                        let at = DVec3::new(-0.9 + 0.07 * f64::from(index), -1.9 + 0.035 * f64::from(index), 0.0);
                        ray(at * f64::from(scale), DVec3::Z)
                    })
                    .collect();
                let hits = closest(&gpu, &structure, &through, &settings);
                assert_eq!(check_hits(&structure, &scaled, &through, &hits, 0.05), 50, "{scale} {fit}");
            }
        }
    }
}

/// Rays of every kind go through a ball of slanted triangles, from outside and from within: none slips through, and each is met where the
/// triangles are, within a 50th of a texel. So it is of open triangles of every size, needles and copies, whose rims are within a fourth
/// of a texel; a rim's octagon is as far off.
#[test]
fn rays_meet_the_triangles_in_f64() {
    let gpu = gpu();
    let mut numbers = Numbers::new(77);
    let centre = DVec3::new(0.3, -0.2, 0.1);
    let through: Vec<Ray> = (0..4000)
        .map(|index| {
            let from = centre + numbers.direction() * if index % 2 == 0 { 7.0 } else { 1.2 * numbers.unit() };
            ray(from, if index % 2 == 0 { centre + numbers.point() * 0.9 - from } else { numbers.direction() })
        })
        .collect();
    for (divided, shape) in [
        (4, &[("abuffer", "200")][..]),
        (1, &[("abuffer", "64"), ("grid", "13"), ("fit", "box")]),
        (5, &[("abuffer", "40")]),
    ] {
        let triangles = ball(divided, 2.0);
        let geometry = soup(&triangles, Some(&gpu));
        let settings = planes(shape);
        let structure = built(&gpu, &geometry, &settings);
        let hits = closest(&gpu, &structure, &through, &settings);
        let met = check_hits(&structure, &triangles, &through, &hits, if divided == 5 { 0.2 } else { 0.02 });
        assert!(met >= 3998, "{divided}: {met}");
        assert!(hits.iter().all(Hit::is_hit), "{divided}");
    }
    let triangles = hostile();
    let geometry = soup(&triangles, Some(&gpu));
    let rays = rays(4000);
    for shape in [&[("abuffer", "160")][..], &[("abuffer", "300"), ("fit", "box")]] {
        let settings = planes(shape);
        let structure = built(&gpu, &geometry, &settings);
        let hits = closest(&gpu, &structure, &rays, &settings);
        let met = check_hits(&structure, &triangles, &rays, &hits, 0.25);
        assert!(met > 1500, "{met}");
    }
}

/// Rays that start on a surface, lifted off it by 1e-5 of the scene's diagonal as ray sets are, do not meet it: out of a ball all of them
/// leave, into it all are met at the other side, at grazing angles too, without any part of their way left out; but for few that graze an
/// edge between triangles, beyond which planes go on for a part of a texel.
#[test]
fn rays_leave_the_surface_that_they_start_on() {
    let gpu = gpu();
    let triangles = ball(3, 2.0);
    let geometry = soup(&triangles, Some(&gpu));
    let lift = 1e-5 * (geometry.bounds_max - geometry.bounds_min).as_dvec3().length();
    let mut numbers = Numbers::new(90);
    let mut from = |outwards: f64| -> Vec<Ray> {
        let each = |index: usize| {
            let [a, b, c] = corners(&triangles[index * 7 % triangles.len()]);
            let (u, v) = (numbers.unit(), numbers.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            // Off the edges, beyond which a neighbour's octagon reaches by a part of a texel.
            let (u, v) = (0.05 + 0.85 * u, 0.05 + 0.85 * v);
            let mut normal = (b - a).cross(c - a).normalize();
            // Away from the ball's middle.
            normal *= normal.dot(a - DVec3::new(0.3, -0.2, 0.1)).signum() * outwards;
            let at = (a + (b - a) * u + (c - a) * v + normal * lift).as_vec3().as_dvec3();
            let aside = numbers.direction().cross(normal).normalize();
            ray(at, aside + normal * [0.01, 0.1, 1.0][index % 3])
        };
        (0..1500).map(each).collect()
    };
    let (out, into) = (from(1.0), from(-1.0));
    for shape in [&[("abuffer", "320")][..], &[("abuffer", "1280"), ("fit", "box")]] {
        let settings = planes(shape);
        let structure = built(&gpu, &geometry, &settings);
        let met = |rays: &[Ray]| closest(&gpu, &structure, rays, &settings);
        let stopped: Vec<f32> = met(&out).iter().filter(|hit| hit.is_hit()).map(|hit| hit.t).collect();
        let own = stopped.iter().filter(|t| f64::from(**t) < 0.5 * texel(&structure)).count();
        assert!(own == 0 && stopped.len() < 15, "{shape:?}: {stopped:?}");
        check_hits(&structure, &triangles, &into, &met(&into), 0.5);
    }
}

/// Rays along the borders of texels and of voxels, through the corners of both, and along triangles' common edges are met like others.
#[test]
fn rays_along_borders_are_met() {
    let gpu = gpu();
    // A cube of 62 texels, slightly turned plates within, and rays from all six sides, exactly on texels' lines.
    let mut triangles = solid(DVec3::splat(-31.0), DVec3::splat(31.0));
    triangles.extend(rectangle(DVec3::new(-31.0, -31.0, 3.0), DVec3::new(62.0, 0.0, 8.0), DVec3::new(0.0, 62.0, -5.0)));
    triangles.extend(rectangle(DVec3::new(4.0, -31.0, -31.0), DVec3::new(0.0, 62.0, 0.0), DVec3::new(-8.0, 0.0, 62.0)));
    let geometry = soup(&triangles, Some(&gpu));
    let mut rays = Vec::new();
    for axis in 0..3 {
        let [along, across, down] = [0, 1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3]);
        for index in 0..600 {
            let at = across * f64::from(index % 60 - 30) + down * f64::from(index / 10 - 30);
            let slant = [0.0, 1e-7, -1e-5, 1e-3][index as usize % 4];
            for sense in [1.0, -1.0] {
                rays.push(ray(at - along * 40.0 * sense, along * sense + across * slant));
                rays.push(ray(at - along * 30.5 * sense, along * sense + (across + down) * slant));
            }
        }
    }
    for shape in [&[("abuffer", "64"), ("grid", "16")][..], &[("abuffer", "64"), ("grid", "13")]] {
        let settings = planes(shape);
        let structure = built(&gpu, &geometry, &settings);
        let hits = closest(&gpu, &structure, &rays, &settings);
        let met = check_hits(&structure, &triangles, &rays, &hits, 0.05);
        assert!(met > 7000 && hits.iter().all(Hit::is_hit), "{met} of {}", rays.len());
    }
}

/// Large plates, one triangle of which covers thousands of texels, are met everywhere, and by both builds alike, however triangles are
/// dealt out.
#[test]
fn large_plates_are_met_by_both_builds() {
    let gpu = gpu();
    let triangles = [
        rectangle(DVec3::new(-9.0, -9.0, 0.0), DVec3::new(18.0, 0.0, 3.0), DVec3::new(0.0, 18.0, -2.0)),
        rectangle(DVec3::new(-9.0, -9.0, -9.0), DVec3::new(18.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 18.0)),
        rectangle(DVec3::new(9.0, -9.0, -9.0), DVec3::new(0.0, 0.0, 18.0), DVec3::new(0.0, 18.0, 0.0)),
    ]
    .concat();
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(3);
    let rays: Vec<Ray> = (0..6000).map(|_| ray(numbers.point() * 8.5, numbers.direction())).collect();
    let of = |build: &'static str| {
        let settings = planes(&[("abuffer", "500"), ("build", build)]);
        let structure = match try_built(&gpu, &geometry, &settings) {
            Err(TracerError::Unavailable(_)) if build == "compute" => return None,
            built => built.unwrap(),
        };
        let hits = closest(&gpu, &structure, &rays, &settings);
        let met = check_hits(&structure, &triangles, &rays, &hits, 0.05);
        assert!(met > 2000, "{met}");
        Some(hits)
    };
    let raster = of("raster").unwrap();
    assert!(of("compute").is_none_or(|compute| compute == raster));
}

/// Over one buffer of a kind, one an axis with data in halves, or textures of either, with a ray a lane or several, timed or counted, hits
/// and surfaces are the same bits; to hits and to surfaces alike, ties too, and any hit answers as the nearest does.
#[test]
fn planes_give_the_same_bits_by_every_variant() {
    let gpu = gpu();
    let shape = [("abuffer", "80"), ("grid", "16")];
    // Copies of other materials lie where they do.
    let triangles = [hostile(), hostile()].concat();
    let geometry = soup(&triangles, Some(&gpu));
    let lists = built(&gpu, &geometry, &planes(&shape)).buffers.lists.clone().unwrap();
    let most = lists.nodes.capacities.into_iter().max().unwrap();
    let small = gpu_that_binds((u64::from(most) * 8).max(lists.heads.size()));
    let of_small = soup(&triangles, Some(&small));
    let rays = rays(1500);
    let mut expected = None;
    for (device, memory_access, rays_per_lane) in
        [(0, "buffer", "1"), (0, "texture", "7"), (1, "buffer", "3"), (1, "texture", "1")]
    {
        let (gpu, geometry) = if device == 0 { (&gpu, &geometry) } else { (&small, &of_small) };
        let settings =
            planes(&[&shape[..], &[("memory_access", memory_access), ("rays_per_lane", rays_per_lane)]].concat());
        let structure = built(gpu, geometry, &settings);
        let nodes = &structure.buffers.lists.as_ref().unwrap().nodes;
        assert_eq!((nodes.is_by_axis(), nodes.has_halves()), (device == 1, device == 1), "{settings:?}");
        structure.validate_against(geometry).unwrap();
        let found = [Query::Closest, Query::Any].map(|query| {
            let found = answer(gpu, &structure, &rays, query, &settings, TraceTo::Surface);
            assert_eq!(answer(gpu, &structure, &rays, query, &settings, TraceTo::Hit).0, found.0, "{settings:?}");
            assert_eq!(counted(gpu, &structure, &rays, query, &settings).0, found.0, "{settings:?}");
            found
        });
        let [hits, any] = [0, 1].map(|query| found[query].0.iter().map(Hit::is_hit).collect::<Vec<_>>());
        assert!(hits == any && hits.iter().filter(|is| **is).count() > 400, "{settings:?}");
        let lost = found[0].1.iter().filter(|surface| surface.status == SurfaceStatus::Lost as u32).count();
        assert_eq!(lost, 0, "{settings:?}");
        assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{settings:?}");
    }
}

/// Surfaces are the triangle's: its normal on the side that the triangle has it, the ray's own point, its material.
#[test]
fn surfaces_are_the_planes() {
    let gpu = gpu();
    let triangles = ball(2, 2.0);
    let geometry = soup(&triangles, Some(&gpu));
    for fit in ["cube", "box"] {
        let settings = planes(&[("abuffer", "160"), ("fit", fit)]);
        let structure = built(&gpu, &geometry, &settings);
        let mut numbers = Numbers::new(8);
        let centre = DVec3::new(0.3, -0.2, 0.1);
        let rays: Vec<Ray> = (0..800).map(|_| ray(centre, numbers.direction())).collect();
        let (hits, surfaces) = answer(&gpu, &structure, &rays, Query::Closest, &settings, TraceTo::Surface);
        let mut right = 0;
        for ((ray, hit), surface) in rays.iter().zip(&hits).zip(&surfaces) {
            assert_eq!(surface.status, SurfaceStatus::Written as u32);
            let point = Vec3::from(ray.origin).as_dvec3() + Vec3::from(ray.direction).as_dvec3() * f64::from(hit.t);
            assert!((Vec3::from(surface.position).as_dvec3() - point).length() < 1e-5);
            let nearest = |triangle: &&[[f32; 3]; 3]| distance_to(triangle, point);
            let [a, b, c] = corners(triangles.iter().min_by(|a, b| nearest(a).total_cmp(&nearest(b))).unwrap());
            let normal = (b - a).cross(c - a).normalize();
            right += usize::from((Vec3::from(surface.normal).as_dvec3() - normal).length() < 2e-4);
        }
        // At common edges the neighbour's may be as near.
        assert!(right > 780, "{fit} {right}");
    }
}

/// What is counted agrees with itself, and a structure that overflows says so, grows, and is then a fresh one's.
#[test]
fn planes_are_counted_and_grow() {
    let gpu = gpu();
    let all = hostile();
    let few = soup(&[&all[..4], &all[all.len() - 100..]].concat(), Some(&gpu));
    let many = soup(&all, Some(&gpu));
    let (rays, settings) = (rays(600), planes(&[]));
    let mut structure = built(&gpu, &few, &settings);
    assert!(!structure.grow_on_overflow().unwrap());
    let update = |structure: &mut Built<VoxelStructure>| {
        let mut clock = PhaseClock::new(Some(&gpu));
        structure.update(Update::Rebuild, &many, &viewpoint(), &parameters(&settings), &mut clock).unwrap();
        clock.finish().unwrap();
    };
    update(&mut structure);
    assert!(structure.validate_against(&many).is_err());
    assert!(structure.grow_on_overflow().unwrap());
    update(&mut structure);
    assert!(!structure.grow_on_overflow().unwrap());
    structure.validate_against(&many).unwrap();
    let of =
        |structure: &Built<VoxelStructure>| answer(&gpu, structure, &rays, Query::Closest, &settings, TraceTo::Surface);
    assert_eq!(of(&structure), of(&built(&gpu, &many, &settings)));
    let (hits, counters) = counted(&gpu, &structure, &rays, Query::Closest, &settings);
    let (_, of_any) = counted(&gpu, &structure, &rays, Query::Any, &settings);
    let count = |name: &str| total(&counters, name);
    let [stepped, opened, searches] = ["voxels_stepped", "voxels_opened", "searches"].map(count);
    assert!(stepped > opened && searches >= opened && opened > 0, "{stepped} {opened} {searches}");
    let met = hits.iter().filter(|hit| hit.is_hit()).count() as u64;
    let [tested, read, touched] = ["depth_comparisons", "layers_tested", "payloads_touched"].map(count);
    assert!(tested >= met && read >= tested && touched <= tested && touched > 0, "{met} {tested} {read} {touched}");
    assert!(total(&of_any, "voxels_opened") <= opened);
    // Nothing is told inside from outside.
    assert!(counters.iter().all(|counter| counter.name != "starts_inside"), "{counters:?}");
    let report = structure.memory();
    assert!(report.structure.iter().all(|entry| !entry.name.contains("sums of normals")), "{report:?}");
}

/// Depths out of order, lists cut off or led astray, other planes, octagons and marks of voxels are noticed; and so is another scene.
#[test]
fn spoilt_planes_are_noticed() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let aside = hostile().iter().map(|corners| corners.map(|[x, y, z]| [x + 0.1 * y, y, z])).collect::<Vec<_>>();
    let other = soup(&aside, Some(&gpu));
    let settings = planes(&[]);
    let read =
        |buffer: &Buffer| -> Vec<u32> { bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size()).unwrap()) };
    let spoil = |what: &str, buffer: &dyn Fn(&Built<VoxelStructure>) -> Buffer, change: &dyn Fn(usize, u32) -> u32| {
        let structure = built(&gpu, &geometry, &settings);
        structure.validate_against(&geometry).unwrap();
        assert!(structure.validate_against(&other).is_err(), "another scene is not noticed");
        let buffer = buffer(&structure);
        let words: Vec<u32> = read(&buffer).into_iter().enumerate().map(|(at, word)| change(at, word)).collect();
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
        assert!(structure.validate_against(&geometry).is_err(), "{what} is not noticed");
    };
    let nodes =
        |structure: &Built<VoxelStructure>| structure.buffers.lists.as_ref().unwrap().nodes.buffers()[0][0].clone();
    let data =
        |structure: &Built<VoxelStructure>| structure.buffers.lists.as_ref().unwrap().nodes.buffers()[1][0].clone();
    let heads = |structure: &Built<VoxelStructure>| structure.buffers.lists.as_ref().unwrap().heads.clone();
    let cells = |structure: &Built<VoxelStructure>| structure.buffers.cells.clone();
    let depth = |by: f32| {
        move |at: usize, word: u32| if at.is_multiple_of(2) { (f32::from_bits(word) + by).to_bits() } else { word }
    };
    spoil("another depth", &nodes, &depth(1e-4));
    spoil("another facing", &nodes, &|at, word| if at % 2 == 0 { word ^ 1 } else { word });
    spoil("a list cut off", &nodes, &|at, word| if at % 2 == 1 { 0 } else { word });
    spoil("another list", &heads, &|at, word| if at == 0 { 1 } else { word });
    spoil("another slope", &data, &|at, word| if at % 4 == 0 { word ^ 0x100 } else { word });
    spoil("a smaller box", &data, &|at, word| if at % 4 == 1 { word.wrapping_add(0x10) } else { word });
    spoil("a larger diagonal", &data, &|at, word| if at % 4 == 2 { word | 0xf000_0000 } else { word });
    spoil("another material", &data, &|at, word| if at % 4 == 3 { word + 1 } else { word });
    spoil("voxels that are not marked", &cells, &|_, word| word & 0x6666_6666);
    spoil("voxels that are marked for nothing", &cells, &|_, word| word | 0x1);
}

/// What the device cannot bind is an error that says what to turn down.
#[test]
fn too_many_planes_are_refused() {
    let gpu = gpu_that_binds(1 << 19);
    let geometry = soup(&[hostile(), hostile(), hostile(), hostile()].concat(), Some(&gpu));
    for settings in [planes(&[("abuffer", "16384")]), planes(&[("abuffer", "300"), ("grid", "8")])] {
        let refused = try_built(&gpu, &geometry, &settings).err();
        let told = |what: &TracerError| matches!(what, TracerError::TooLarge { hint, .. } if hint.contains("voxel-abuffer.abuffer"));
        assert!(refused.as_ref().is_some_and(told), "{settings:?}: {refused:?}");
    }
    built(&gpu, &geometry, &planes(&[("abuffer", "64")]));
}
