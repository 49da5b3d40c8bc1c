//! `screen-dda` with layers, backs and Hi-Z.

use super::reference::Dda;
use super::*;
use tracebench_api::Status;
use tracebench_harness::truth::{Ray64, Truth};
use tracebench_kit::NO_SURFACE;

const NAME: &str = "screen-dda";

/// What is built.
const BUILDS: [&[(&str, &str)]; 4] = [
    &[],
    &[("layers", "2"), ("layer_separation", "0.002")],
    &[("thickness_from", "back_faces")],
    &[("layers", "3"), ("thickness_from", "back_faces"), ("memory_access", "texture")],
];

/// What is traced with.
const TRACES: [&[(&str, &str)]; 6] = [
    &[],
    &[("stride", "3"), ("thickness", "0.02")],
    &[("max_steps", "25")],
    &[("thickness", "0"), ("start_bias", "0")],
    &[("hit_point", "depth"), ("start_bias", "4"), ("rays_per_lane", "8")],
    &[("thickness", "10"), ("max_steps", "7"), ("stride", "2")],
];

/// Rays of eyes beside the view's, as far from it as told, through centres and through corners of pixels: all samples of those that enter
/// the image through a side lie on borders between pixels, and some rays run along borders all the way.
fn from_beside(view: &View, reach: f64) -> Vec<Ray> {
    let away = [-1.0, 1.0].into_iter().flat_map(|side| [view.right, view.up].map(|axis| axis * (0.4 * reach * side)));
    let eyes: Vec<DVec3> = away.chain([(view.right - view.up) * (0.3 * reach)]).collect();
    let size = view.size.map(f64::from);
    let places = (1..8).flat_map(|row| (1..8).map(move |column| [column, row].map(|place| f64::from(place) / 8.0)));
    places
        .flat_map(|[x, y]| [0.0, 0.5].map(|inside| [(x * size[0]).floor() + inside, (y * size[1]).floor() + inside]))
        .flat_map(|[x, y]| eyes.iter().map(move |beside| ray(view.eye + *beside, view.direction_through(x, y))))
        .collect()
}

/// Proves that marching by Hi-Z gives the hits and statuses of marching over pixels bit for bit, by every kind of build and of trace, in an
/// open scene and a closed one, of rays from anywhere, along lines between pixels and through the image's sides too; that it looks at
/// fewer samples; and, as a negative control, that another stride is noticed.
#[test]
fn hi_z_gives_the_same_hits() {
    let (room, view_of_room) = room();
    let tracer = tracer(NAME);
    for (geometry, viewpoint, reach) in [(scene(), camera(), 9.0), (room, view_of_room, 3.0)] {
        let view = viewpoint.frame_view();
        let rays = [rays(&view, 1200, reach, 83), from_beside(&view, reach)].concat();
        for build in BUILDS {
            let [pixels, hi_z] = ["pixels", "hi-z"].map(|march| {
                let settings = [build, &[("march", march)]].concat();
                (Built::new(&*tracer, parameters(NAME, &settings), &geometry, &viewpoint), settings)
            });
            let mut looked_at = [0, 0];
            for trace in TRACES {
                let [(of_pixels, by_pixels), (of_hi_z, by_hi_z)] = [&pixels, &hi_z].map(|(built, settings)| {
                    built.hits_with(&parameters(NAME, &[&settings[..], trace].concat()), &rays)
                });
                let differs = of_pixels.iter().zip(&of_hi_z).position(|(a, b)| a != b);
                let shown = differs.map(|index| (&rays[index], &of_pixels[index], &of_hi_z[index]));
                assert_eq!(shown, None, "{build:?} {trace:?}");
                let samples = [&by_pixels, &by_hi_z].map(|counters| total(counters, "depth_samples"));
                assert!(samples[1] <= samples[0], "{samples:?}");
                looked_at = [looked_at[0] + samples[0], looked_at[1] + samples[1]];
                assert!(total(&by_hi_z, "cells_visited") > 0);
            }
            assert!(2 * looked_at[1] < looked_at[0], "{build:?}: {looked_at:?}");
        }
        let [one, other] = ["1", "2"].map(|stride| {
            Built::new(&*tracer, parameters(NAME, &[("march", "hi-z"), ("stride", stride)]), &geometry, &viewpoint)
                .hits(&rays)
        });
        assert!(one != other);
    }
}

/// By cells.
const CELLS: [(&str, &str); 3] = [("march", "cells"), ("hit_point", "depth"), ("max_steps", "65536")];

/// A ray cut to some depths of a view.
fn cut(view: &View, ray: &Ray, [near, far]: [f64; 2]) -> Ray {
    let of = |vector: [f32; 3]| DVec3::from(vector.map(f64::from));
    let depth = (of(ray.origin) - view.eye).dot(view.forward);
    let along = of(ray.direction).dot(view.forward);
    let ends = [near, far].map(|end| ((end - depth) / along) as f32);
    Ray { t_min: ray.t_min.max(ends[0].min(ends[1])), t_max: ray.t_max.min(ends[0].max(ends[1])), ..*ray }
}

/// Proves that rays which are cut to the depths that the view has hit just the same, bit for bit, by every kind of build and of trace, in
/// an open scene and a closed one, by fewer visits; and, as a negative control, that a cut a fiftieth too narrow is noticed.
#[test]
fn cut_rays_hit_the_same() {
    let (room, view_of_room) = room();
    let tracer = tracer(NAME);
    for (geometry, viewpoint, reach) in [(scene(), camera(), 9.0), (room, view_of_room, 3.0)] {
        let view = viewpoint.frame_view();
        let rays = [rays(&view, 1200, reach, 87), from_beside(&view, reach)].concat();
        for build in BUILDS {
            let settings = [build, &CELLS].concat();
            let built = Built::new(&*tracer, parameters(NAME, &settings), &geometry, &viewpoint);
            let mut visited = [0, 0];
            for trace in [&[][..], &[("hit_point", "step"), ("start_bias", "0")], &[("from_behind", "pass")]] {
                for thickness in [&[][..], &[("thickness", "0")], &[("thickness", "0.1"), ("thickness_in", "depth")]] {
                    let [whole, clipped] = ["off", "on"].map(|clip| {
                        let all = [&settings[..], trace, thickness, &[("depth_clip", clip)]].concat();
                        built.hits_with(&parameters(NAME, &all), &rays)
                    });
                    let same = |(one, other): (&Hit, &Hit)| one == other || !one.is_hit() && !other.is_hit();
                    let differs = whole.0.iter().zip(&clipped.0).position(|pair| !same(pair));
                    let shown = differs.map(|index| (&rays[index], &whole.0[index], &clipped.0[index]));
                    assert_eq!(shown, None, "{build:?} {trace:?} {thickness:?}");
                    for (sum, (_, counters)) in visited.iter_mut().zip([whole, clipped]) {
                        *sum += total(&counters, "cells_visited") + total(&counters, "depth_samples");
                    }
                }
            }
            assert!(visited[1] < visited[0], "{build:?}: {visited:?}");
        }
        let thin = parameters(NAME, &[&CELLS[..], &[("thickness", "0"), ("start_bias", "0")]].concat());
        let built = Built::new(&*tracer, thin, &geometry, &viewpoint);
        let depths = draw(&geometry, &view, 1, 0.0, false);
        let covered = || depths.images[0].iter().filter(|depth| **depth < NO_SURFACE).map(|depth| f64::from(*depth));
        let range = [covered().fold(f64::INFINITY, f64::min) * 1.02, covered().fold(0.0, f64::max) / 1.02];
        let narrow: Vec<Ray> = rays.iter().map(|ray| cut(&view, ray, range)).collect();
        let lost = built.hits(&rays).into_iter().zip(built.hits(&narrow)).filter(|(one, other)| one != other);
        assert!(lost.count() > 5);
    }
}

/// Proves that hits by cells are those of all pixels that rays cross, in f64 over the same depths, by several settings; and, as a negative
/// control, that other settings are noticed.
#[test]
fn cells_are_marched_as_in_f64() {
    let (geometry, tracer, viewpoint) = (scene(), tracer(NAME), camera());
    let view = viewpoint.frame_view();
    let rays = rays(&view, 1500, 9.0, 88);
    for (layers, backs, clip) in [(1, false, "on"), (2, false, "off"), (2, true, "on")] {
        let depths = draw(&geometry, &view, layers, 0.0, backs);
        let from = if backs { "back_faces" } else { "assumed" };
        let told = [("layers", if layers == 1 { "1" } else { "2" }), ("thickness_from", from), ("depth_clip", clip)];
        let settings = [&CELLS[..], &told, &[("thickness", "0.02"), ("thickness_in", "depth")]].concat();
        let built = Built::new(&*tracer, parameters(NAME, &settings), &geometry, &viewpoint);
        let hits = built.hits(&rays);
        let dda = Dda {
            stride: 1.0,
            max_steps: usize::MAX,
            thickness: 0.0,
            thickness_per_depth: 0.02,
            start_bias: 1.0,
            layers: layers as usize,
            backs,
        };
        let (compared, wrong) = compare(&rays, &hits, |ray, shift| depths.cells(ray, &dda, shift));
        assert!(compared > 1000, "{compared}");
        assert_eq!(wrong, Vec::<String>::new(), "{} of {compared}: {settings:?}", wrong.len());
        for other in [Dda { backs: false, thickness_per_depth: 0.08, ..dda }, Dda { start_bias: 4.0, ..dda }] {
            let off = compare(&rays, &hits, |ray, shift| depths.cells(ray, &other, shift)).1.len();
            assert!(off > 10, "{settings:?} {other:?}: {off}");
        }
    }
}

/// Proves that plates in all poses are hit by rays that come from the side that the view sees, and passed by those that come from behind,
/// where that is asked for, but for a few that are before and behind the one depth of a pixel in it; and, as a negative control, that
/// otherwise both hit.
#[test]
fn rays_from_behind_pass() {
    let (tracer, mut numbers) = (tracer(NAME), Numbers::new(89));
    let (mut seen, mut from_behind, mut wrong) = (0, 0, 0);
    while from_behind < 40 {
        let normal = numbers.direction();
        let centre = DVec3::new(0.0, 0.0, -4.0);
        // Not from its edge.
        if normal.dot(centre.normalize()).abs() < 0.4 {
            continue;
        }
        let (x, y) = normal.any_orthonormal_pair();
        let corner = centre - 1.5 * (x + y);
        let plate = tracebench_tests::rectangle(
            corner.as_vec3().into(),
            (3.0 * x).as_vec3().into(),
            (3.0 * y).as_vec3().into(),
        );
        let geometry = soup(&plate, Some(&gpu()));
        let built = Built::new(&*tracer, parameters(NAME, &CELLS), &geometry, &camera());
        for _ in 0..8 {
            let along = numbers.direction();
            if along.dot(normal).abs() < 0.3 {
                continue;
            }
            let through = Ray { t_max: 0.6, ..ray(centre - 0.3 * along, along) };
            let comes_from_behind = (along.dot(normal) < 0.0) != (centre.dot(normal) < 0.0);
            let [kept, passed] = ["hit", "pass"].map(|told| {
                let all = [&CELLS[..], &[("thickness", "0.1"), ("start_bias", "0"), ("from_behind", told)]].concat();
                built.hits_with(&parameters(NAME, &all), &[through]).0[0].is_hit()
            });
            assert!(kept, "{normal} {through:?}");
            wrong += u32::from(passed == comes_from_behind);
            (seen, from_behind) = (seen + u32::from(passed), from_behind + u32::from(!passed));
        }
    }
    assert!(seen > 20 && 8 * wrong <= seen + from_behind, "{wrong} of {seen} and {from_behind}");
}

/// Proves that Hi-Z gives the same hits in frames of one row, one column and one pixel, whose pyramids have few cells or none, and that
/// cells do, cut or not.
#[test]
fn hi_z_serves_every_frame() {
    let (geometry, tracer) = (scene(), tracer(NAME));
    for frame in [[64, 1], [1, 50], [1, 1], [2, 3], [129, 65]] {
        let viewpoint = Viewpoint { frame, ..camera() };
        let rays = rays(&viewpoint.frame_view(), 400, 9.0, 84);
        let [pixels, hi_z] = ["pixels", "hi-z"].map(|march| {
            Built::new(&*tracer, parameters(NAME, &[("march", march)]), &geometry, &viewpoint).hits(&rays)
        });
        assert!(pixels == hi_z, "{frame:?}");
        assert!(pixels.iter().any(Hit::is_hit), "{frame:?}");
        let [whole, clipped] = ["off", "on"].map(|clip| {
            let settings = [&CELLS[..], &[("depth_clip", clip)]].concat();
            let hits = Built::new(&*tracer, parameters(NAME, &settings), &geometry, &viewpoint).hits(&rays);
            hits.into_iter().map(|hit| hit.is_hit().then_some(hit)).collect::<Vec<_>>()
        });
        assert!(whole == clipped && whole.iter().any(Option::is_some), "{frame:?}");
    }
}

/// Long rays over an empty view look at nearly none of its samples by Hi-Z, whether they start in it or enter it through any of its sides,
/// where their samples lie on borders between pixels, or run along borders.
#[test]
fn hi_z_crosses_emptiness_at_once() {
    let viewpoint = Viewpoint { frame: [1024, 512], ..camera() };
    let (geometry, tracer) = (scene(), tracer(NAME));
    let built = Built::new(&*tracer, parameters(NAME, &[("march", "hi-z")]), &geometry, &viewpoint);
    // Before all blocks.
    let ahead = DVec3::NEG_Z * 0.5;
    let mut numbers = Numbers::new(85);
    let mut crosses = |from: DVec3, slant: f64| -> Vec<Ray> {
        let along = -from.normalize();
        let aside = along.cross(DVec3::Z);
        let mut beside = || aside * numbers.signed();
        (0..100).map(|_| ray(from + ahead + beside() * 0.15, along + beside() * slant)).collect()
    };
    let starts = [[-0.3, 0.0], [-3.0, 0.0], [3.0, 0.0], [0.0, -3.0], [0.0, 3.0]];
    let mut all = starts.map(|[x, y]| crosses(DVec3::new(x, y, 0.0), 0.1)).to_vec();
    // Along rows of corners.
    let view = viewpoint.frame_view();
    let rows = (1..101).map(|row| view.direction_through(512.0, 5.0 * f64::from(row)) * 0.5);
    all.push(rows.map(|at| ray(at + DVec3::X * 3.0, DVec3::NEG_X)).collect());
    for rays in all {
        let counters = built.hits_with(&built.parameters, &rays).1;
        let [samples, cells] = ["depth_samples", "cells_visited"].map(|name| total(&counters, name) / 100);
        assert!(samples < 20 && cells < 60, "{:?}: {samples} {cells}", rays[0]);
    }
}

/// Proves that hits of several layers and by back faces are those of the same march in f64 over the same depths, by several settings;
/// and, as a negative control, that other settings are noticed.
#[test]
fn layers_and_backs_are_marched_as_in_f64() {
    let (geometry, tracer, viewpoint) = (scene(), tracer(NAME), camera());
    let view = viewpoint.frame_view();
    let rays = rays(&view, 1500, 9.0, 86);
    let diagonal = geometry.diagonal();
    for (layers, backs, stride, max_steps) in
        [(1, false, 1, 4096), (2, false, 1, 4096), (4, false, 2, 30), (1, true, 1, 4096), (2, true, 1, 4096)]
    {
        let depths = draw(&geometry, &view, layers, 0.0, backs);
        let from = if backs { "back_faces" } else { "assumed" };
        let told = [layers, stride, max_steps].map(|value| value.to_string());
        let settings =
            [("layers", &*told[0]), ("thickness_from", from), ("stride", &*told[1]), ("max_steps", &*told[2])];
        let built = Built::new(&*tracer, parameters(NAME, &settings), &geometry, &viewpoint);
        let hits = built.hits(&rays);
        let dda = Dda {
            stride: f64::from(stride),
            max_steps: max_steps as usize,
            thickness: 0.005 * diagonal,
            thickness_per_depth: 0.0,
            start_bias: 1.0,
            layers: layers as usize,
            backs,
        };
        let (compared, wrong) = compare(&rays, &hits, |ray, shift| depths.dda(ray, &dda, shift));
        assert!(compared > 1000, "{compared}");
        assert_eq!(wrong, Vec::<String>::new(), "{} of {compared}: {settings:?}", wrong.len());
        // Blocks have backs all over: of them no thickness is assumed.
        let as_thick = if backs { Dda { backs: false, ..dda } } else { Dda { thickness: 0.02 * diagonal, ..dda } };
        for other in [as_thick, Dda { stride: dda.stride * 2.0, ..dda }] {
            let off = compare(&rays, &hits, |ray, shift| depths.dda(ray, &other, shift)).1.len();
            assert!(off > 10, "{settings:?} {other:?}: {off}");
        }
    }
}

/// The depths along a line of sight from a true hit on: the nearest, each next one farther by a distance.
fn layers_of(truth: &Truth, view: &View, at: [f64; 2], count: usize, separation: f64) -> Vec<(f64, u32)> {
    let direction = view.direction_through(at[0], at[1]);
    let mut found: Vec<(f64, u32)> = Vec::new();
    while found.len() < count {
        let t_min = found.last().map_or(view.near, |(depth, _)| depth * (1.0 + 8e-6) + separation);
        let Some(hit) = truth.closest(&Ray64 { origin: view.eye, direction, t_min, t_max: view.far }) else { break };
        found.push((hit.t, hit.primitive));
    }
    found
}

/// The nearest back face behind a depth.
fn back_of(truth: &Truth, view: &View, at: [f64; 2], depth: f64) -> Option<(f64, u32)> {
    let direction = view.direction_through(at[0], at[1]);
    let mut t_min = depth * (1.0 + 8e-6);
    loop {
        let hit = truth.closest(&Ray64 { origin: view.eye, direction, t_min, t_max: view.far })?;
        if truth.normal(hit.primitive).dot(direction) > 0.0 {
            return Some((hit.t, hit.primitive));
        }
        t_min = hit.t * (1.0 + 1e-9);
    }
}

/// Pixels compared, and how many are off: the images of layers and backs against f64 over all triangles, at pixels round whose centres
/// the same triangles are seen.
fn compare_layers(truth: &Truth, depths: &Depths, layers: usize, separation: f64, backs: bool) -> (usize, usize) {
    let view = &depths.view;
    let snap = 1.0 / 64.0 + tracebench_kit::rasterizer(&gpu()).unwrap().border_pixels();
    let (mut compared, mut off) = (0, 0);
    for pixel in 0..depths.images[0].len() {
        let (column, row) = (pixel as u32 % view.size[0], pixel as u32 / view.size[0]);
        let around = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.0)].map(|(across, down)| {
            let at = [f64::from(column) + 0.5 + across * snap, f64::from(row) + 0.5 + down * snap];
            let found = layers_of(truth, view, at, layers, separation);
            let behind = |(depth, _): &(f64, u32)| if backs { back_of(truth, view, at, *depth) } else { None };
            let of_backs: Vec<_> = found.iter().map(behind).collect();
            (found, of_backs)
        });
        let names = around.each_ref().map(|(found, of_backs)| {
            let backs: Vec<_> = of_backs.iter().map(|back| back.map(|(_, primitive)| primitive)).collect();
            (found.iter().map(|(_, primitive)| *primitive).collect::<Vec<_>>(), backs)
        });
        if names.iter().any(|each| *each != names[0]) {
            continue;
        }
        compared += 1;
        let fits = |stored: f32, seen: &[Option<f64>]| {
            let seen: Vec<f64> = seen.iter().flatten().copied().collect();
            if seen.is_empty() {
                return stored == NO_SURFACE;
            }
            let (least, most) =
                (seen.iter().copied().fold(f64::INFINITY, f64::min), seen.iter().copied().fold(0.0, f64::max));
            (least * (1.0 - 3e-5)..=most * (1.0 + 3e-5)).contains(&f64::from(stored))
        };
        let right = (0..layers).all(|layer| {
            let fronts = around.each_ref().map(|(found, _)| found.get(layer).map(|(depth, _)| *depth));
            let behind =
                around.each_ref().map(|(_, backs)| backs.get(layer).copied().flatten().map(|(depth, _)| depth));
            fits(depths.images[layer][pixel], &fronts)
                && (!backs || fits(depths.images[layers + layer][pixel], &behind))
        });
        off += usize::from(!right);
    }
    (compared, off)
}

/// Proves that layers and backs are those of f64 over all triangles, with and without a separation; and, as negative controls, that
/// layers of another separation, and fronts in the place of backs, are noticed.
#[test]
fn layers_are_those_of_f64() {
    let geometry = scene();
    let view = camera().frame_view();
    let truth = Truth::new(&geometry, "layers");
    for (separation, backs) in [(0.0, true), (0.6, false)] {
        let depths = draw(&geometry, &view, 3, separation as f32, backs);
        let (compared, off) = compare_layers(&truth, &depths, 3, separation, backs);
        assert!(compared > 1500, "{compared}");
        assert_eq!(off, 0, "of {compared}");
        let covered = depths.images.iter().map(|image| image.iter().filter(|depth| **depth < NO_SURFACE).count());
        assert!(covered.clone().all(|covered| covered > 150), "{:?}", covered.collect::<Vec<_>>());
        assert!(compare_layers(&truth, &depths, 3, separation + 0.3, false).1 > 50);
        if backs {
            let swapped = Depths { images: [&depths.images[..3], &depths.images[..3]].concat(), ..depths };
            assert!(compare_layers(&truth, &swapped, 3, separation, true).1 > 500);
        }
    }
}

fn one(built: &Built, ray: Ray) -> (Status, f32) {
    let hit = built.hits(&[ray])[0];
    (Status::from_code(hit.status).unwrap(), hit.t)
}

/// Proves what layers are for: a plate that another one hides is hit by rays that pass between them with two layers, not with one; a
/// third needs three, or a separation that takes the second for the first.
#[test]
fn hidden_plates_need_layers() {
    let plates = [(-4.0, 1.5), (-4.5, 1.5), (-6.0, 2.0)];
    let mut triangles = vec![[[30.0, 0.0, 30.0], [30.1, 0.0, 30.0], [30.0, 0.1, 30.0]]];
    for (depth, half) in plates {
        triangles.extend(tracebench_tests::rectangle(
            [-half, -half, depth],
            [2.0 * half, 0.0, 0.0],
            [0.0, 2.0 * half, 0.0],
        ));
    }
    let (geometry, tracer) = (soup(&triangles, Some(&gpu())), tracer(NAME));
    let built = |settings: &[(&str, &str)]| {
        let settings = [&[("thickness", "0.0001"), ("hit_point", "depth")][..], settings].concat();
        Built::new(&*tracer, parameters(NAME, &settings), &geometry, &camera())
    };
    // Each ends before it meets the next plate.
    let to_second = Ray { t_max: 0.8, ..ray(DVec3::new(-0.5, 0.1, -4.2), DVec3::new(1.0, 0.0, -1.0)) };
    let to_third = Ray { t_max: 2.5, ..ray(DVec3::new(-0.5, 0.1, -5.0), DVec3::new(1.0, 0.0, -1.0)) };
    let between = (1.0 / geometry.diagonal()).to_string();
    let separated = [("layers", "2"), ("layer_separation", &*between)];
    type Settings<'a> = &'a [(&'a str, &'a str)];
    let expected: [(Settings, bool, bool); 5] = [
        (&[], false, false),
        (&[("layers", "2")], true, false),
        (&[("layers", "3")], true, true),
        (&[("layers", "4"), ("march", "hi-z")], true, true),
        (&separated, false, true),
    ];
    for (settings, second, third) in expected {
        let built = built(settings);
        for (ray, found, depth) in [(to_second, second, 4.5), (to_third, third, 6.0)] {
            let (status, t) = one(&built, ray);
            let expected = (-depth - f64::from(ray.origin[2])) / f64::from(ray.direction[2]);
            assert_eq!(status, if found { Status::Hit } else { Status::ThicknessRejected }, "{settings:?}");
            assert!(!found || (f64::from(t) - expected).abs() < 1e-3, "{settings:?}: {t} instead of {expected}");
        }
    }
    // From behind the deepest layer is met first.
    let towards = ray(DVec3::new(-0.5, 0.1, -8.0), DVec3::new(0.3, 0.0, 1.0));
    let (_, t) = one(&built(&[("layers", "3"), ("thickness_from", "assumed"), ("stride", "256")]), towards);
    assert!((f64::from(t) - 2.0 * 1.09_f64.sqrt()).abs() < 1e-3, "{t}");
}

/// Proves what backs are for: of a block as thick as it is, rays that pass behind it pass, and rays that cross it hit; by an assumed
/// thickness the ones or the others are wrong. A plate, which has no back, is as thick as is assumed.
#[test]
fn back_faces_tell_thickness() {
    let mut triangles = block(DVec3::new(-1.0, 0.0, -4.0), [DVec3::X * 0.5, DVec3::Y, DVec3::Z * 0.5]);
    triangles.extend(tracebench_tests::rectangle([0.5, -1.0, -4.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
    let (geometry, tracer) = (soup(&triangles, Some(&gpu())), tracer(NAME));
    // Into the block's middle, behind the block, behind the plate.
    let through = Ray { t_max: 2.2, ..ray(DVec3::new(-3.0, 0.1, -4.0), DVec3::X) };
    let behind = Ray { t_max: 2.5, ..ray(DVec3::new(-3.0, 0.1, -5.0), DVec3::X) };
    let behind_plate = ray(DVec3::new(0.45, 0.1, -4.3), DVec3::X);
    for (from, thickness, expected) in [
        ("assumed", 0.1, [false, false, false]),
        ("assumed", 1.6, [true, true, true]),
        ("back_faces", 0.1, [true, false, false]),
        ("back_faces", 1.6, [true, false, true]),
    ] {
        let thickness = (thickness / geometry.diagonal()).to_string();
        let settings = [("thickness_from", from), ("thickness", &*thickness)];
        let built = Built::new(&*tracer, parameters(NAME, &settings), &geometry, &camera());
        let found = [through, behind, behind_plate].map(|ray| built.hits(&[ray])[0].is_hit());
        assert_eq!(found, expected, "{settings:?}");
    }
}
