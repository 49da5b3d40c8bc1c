//! Minimal closed scenes: what rays meet from outside and from within.

use super::*;

/// A large box and a small one aside, so that there is free space round them.
fn boxes() -> Vec<[[f32; 3]; 3]> {
    let mut triangles = solid(DVec3::new(-3.0, -2.0, -1.0), DVec3::new(1.0, 2.0, 2.0));
    triangles.extend(solid(DVec3::new(2.5, 2.5, 2.5), DVec3::new(3.5, 3.5, 3.5)));
    triangles
}

/// Onto the large box from all around, and from within it, with the t at which its wall is met.
fn onto_the_box(count: usize) -> Vec<(Ray, f64)> {
    let (low, high) = (DVec3::new(-3.0, -2.0, -1.0), DVec3::new(1.0, 2.0, 2.0));
    let mut numbers = Numbers::new(17);
    let mut found = Vec::new();
    while found.len() < count {
        let within = low + (numbers.point() * 0.45 + 0.5) * (high - low);
        let from = if found.len() % 2 == 0 { within + numbers.direction() * 9.0 } else { within };
        let target = low + (numbers.point() * 0.45 + 0.5) * (high - low);
        let ray = ray(from, if found.len() % 2 == 0 { target - from } else { numbers.direction() });
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        let crossed = |low: DVec3, high: DVec3| {
            let (one, other) = ((low - origin) / direction, (high - origin) / direction);
            (one.min(other).max_element(), one.max(other).min_element())
        };
        let ((entry, exit), aside) = (crossed(low, high), crossed(DVec3::splat(2.5), DVec3::splat(3.5)));
        let t = if found.len() % 2 == 0 { entry } else { exit };
        // Away from edges, where texels show one wall or the other, and not past the small box.
        let at = origin + direction * t;
        let from_walls = [at - low, high - at].map(|to| to.abs());
        let near = from_walls.iter().flat_map(|to| to.to_array()).filter(|distance| *distance < 0.35).count();
        if near == 1 && aside.0 > aside.1 && t > 0.4 {
            found.push((ray, t));
        }
    }
    found
}

/// Rays from outside stop at the wall, rays from within at the opposite one, by parity and by nesting, by the state and by its change, by
/// every search, in a cube and in a box: within a texel along the wall's normal. Any hit answers alike.
#[test]
fn walls_are_met_from_outside_and_from_within() {
    let gpu = gpu();
    let geometry = soup(&boxes(), Some(&gpu));
    let (rays, expected): (Vec<Ray>, Vec<f64>) = onto_the_box(600).into_iter().unzip();
    for fit in ["cube", "box"] {
        let shape = [("abuffer", "128"), ("grid", "16"), ("fit", fit)];
        let of = |inside| built(&gpu, &geometry, &[&shape[..], &[("inside", inside)]].concat());
        let structures = [of("parity"), of("nesting")];
        // 6.5 units over 126 texels.
        let texel = 6.5 / 126.0;
        for search in ["dda2d", "three-step", "one-step"] {
            for (inside, crossing) in
                [("parity", "state"), ("nesting", "state"), ("parity", "change"), ("nesting", "change")]
            {
                let how = [("search", search), ("inside", inside), ("crossing", crossing)];
                let settings = [&shape[..], &how].concat();
                let structure = &structures[usize::from(inside == "nesting")];
                let hits = closest(&gpu, structure, &rays, &settings);
                let right = |(hit, t): &(&Hit, &f64)| hit.is_hit() && (f64::from(hit.t) - **t).abs() < 4.0 * texel;
                let share = hits.iter().zip(&expected).filter(right).count() as f64 / rays.len() as f64;
                assert!(share > 0.99, "{settings:?}: {share}");
                let any = answer(&gpu, structure, &rays, Query::Any, &settings, TraceTo::Hit).0;
                let differ = any.iter().zip(&hits).filter(|(any, hit)| any.is_hit() != hit.is_hit()).count();
                assert_eq!(differ, 0, "{settings:?}");
            }
        }
    }
}

/// Surfaces are the wall's: its normal, the ray's own point, every hit with one.
#[test]
fn surfaces_are_the_walls() {
    let gpu = gpu();
    let geometry = soup(&boxes(), Some(&gpu));
    let (rays, expected): (Vec<Ray>, Vec<f64>) = onto_the_box(400).into_iter().unzip();
    let structure = built(&gpu, &geometry, &[("abuffer", "128")]);
    let (hits, surfaces) = answer(&gpu, &structure, &rays, Query::Closest, &[("abuffer", "128")], TraceTo::Surface);
    let (low, high) = (DVec3::new(-3.0, -2.0, -1.0), DVec3::new(1.0, 2.0, 2.0));
    let mut right = 0;
    for (index, (hit, surface)) in hits.iter().zip(&surfaces).enumerate() {
        if !hit.is_hit() {
            continue;
        }
        assert_eq!(surface.status, tracebench_api::SurfaceStatus::Written as u32);
        let at =
            Vec3::from(rays[index].origin).as_dvec3() + Vec3::from(rays[index].direction).as_dvec3() * expected[index];
        let (before, behind) = ((at - low).abs(), (high - at).abs());
        let axis = (0..3).min_by(|a, b| before[*a].min(behind[*a]).total_cmp(&before[*b].min(behind[*b]))).unwrap();
        let outwards = DVec3::AXES[axis] * if before[axis] < behind[axis] { -1.0 } else { 1.0 };
        right += usize::from((Vec3::from(surface.normal).as_dvec3() - outwards).length() < 1e-5);
    }
    assert!(right > 390, "{right}");
}

/// An object within another: by parity its surface and that round it are walls alike; nesting tells the two apart, and both find each.
/// Two objects in one another: by parity their common inside is outside; by nesting a ray from outside stops at the first wall, and one
/// from the common inside at the next.
#[test]
fn nesting_counts_objects() {
    let gpu = gpu();
    let mut triangles = solid(DVec3::splat(-2.0), DVec3::splat(0.5));
    triangles.extend(solid(DVec3::splat(-0.5), DVec3::splat(2.0)));
    let geometry = soup(&triangles, Some(&gpu));
    let shape = [("abuffer", "128"), ("grid", "16")];
    let along = DVec3::new(1.0, 0.03, 0.02);
    let rays = [ray(DVec3::new(0.03, 0.02, 0.01), along), ray(DVec3::new(-5.0, 0.02, 0.01), along)];
    let t = |settings: &[(&str, &str)]| {
        let settings = [&shape[..], settings].concat();
        let hits = closest(&gpu, &built(&gpu, &geometry, &settings), &rays, &settings);
        hits.iter().map(|hit| (f64::from(hit.t) * 10.0).round() / 10.0).collect::<Vec<_>>()
    };
    // The first box ends at 0.5, the second begins at -0.5.
    assert_eq!(t(&[("inside", "nesting")]), [0.5, 3.0]);
    assert_eq!(t(&[("inside", "parity")]), [0.5, 3.0]);
    for (inside, expected) in [("nesting", 1), ("parity", 0)] {
        let settings = [&shape[..], &[("inside", inside)]].concat();
        let structure = built(&gpu, &geometry, &settings);
        let (_, counters) = counted(&gpu, &structure, &rays[..1], Query::Closest, &settings);
        assert_eq!(total(&counters, "starts_inside"), expected);
    }
}

/// A wall whose depth is that of a border between voxels is met from both sides: alone in its scene it lies in the middle of the
/// cube.
#[test]
fn walls_on_borders_of_voxels_are_met() {
    let gpu = gpu();
    let mut numbers = Numbers::new(41);
    for search in ["dda2d", "three-step", "one-step"] {
        for axis in 0..3 {
            let [wall_axis, across, down] = [0, 1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3]);
            let corner = -2.0 * (across + down);
            let walls = rectangle(corner, across * 4.0, down * 4.0);
            let settings = [("grid", "16"), ("abuffer", "64"), ("search", search)];
            let geometry = soup(&walls, Some(&gpu));
            let rays: Vec<Ray> = (0..300)
                .map(|index| {
                    let at = 1.9 * (across * numbers.signed() + down * numbers.signed());
                    let off = wall_axis * if index % 2 == 0 { 1.0 } else { -1.0 } + 0.3 * across * numbers.signed();
                    ray(at + off, -off)
                })
                .collect();
            let hits = closest(&gpu, &built(&gpu, &geometry, &settings), &rays, &settings);
            let met = hits.iter().filter(|hit| hit.is_hit() && (0.95..1.1).contains(&hit.t)).count();
            assert!(met >= 297, "{search} {axis}: {met}");
        }
    }
}

/// A box stands on another one, with a gap of a tenth of a texel between. Rays out of the upper one pass both walls in one texel: its
/// layers show both, and the side on which the ray leaves the texel neither.
#[test]
fn what_a_texel_holds_twice_is_met() {
    let gpu = gpu();
    let gap = 0.1 * 4.0 / 126.0;
    let mut triangles = solid(DVec3::new(-2.0, -2.0, -2.0), DVec3::new(2.0, 2.0, 0.0));
    triangles.extend(solid(DVec3::new(-1.5, -1.5, gap), DVec3::new(1.5, 1.5, 1.9)));
    let geometry = soup(&triangles, Some(&gpu));
    let shape = [("abuffer", "128"), ("grid", "16")];
    let structure = built(&gpu, &geometry, &shape);
    let mut numbers = Numbers::new(23);
    let each = |_| {
        let from = DVec3::new(numbers.signed(), numbers.signed(), 1.0);
        ray(from, DVec3::new(0.2 * numbers.signed(), 0.2 * numbers.signed(), -1.0))
    };
    let rays: Vec<Ray> = (0..200).map(each).collect();
    for depths in ["centre", "plane"] {
        let met_at = |in_texel: &str, z: f64| {
            let hits =
                closest(&gpu, &structure, &rays, &[&shape[..], &[("in_texel", in_texel), ("depths", depths)]].concat());
            let at = |(hit, ray): &(&Hit, &Ray)| {
                hit.is_hit() && (f64::from(ray.origin[2] + hit.t * ray.direction[2]) - z).abs() < gap
            };
            hits.iter().zip(&rays).filter(at).count()
        };
        let (met, passed) = (met_at("layers", gap), met_at("exit", -2.0));
        // Of some the texel's border lies in the gap.
        assert!(met == 200 && passed > 185, "{depths}: {met} {passed}");
    }
}

/// Slanted walls have steps where layers are as deep as at their texels' centres, and none by their planes.
#[test]
fn planes_have_no_steps() {
    let gpu = gpu();
    let turned = tracebench_api::glam::DQuat::from_rotation_y(0.5) * tracebench_api::glam::DQuat::from_rotation_x(0.4);
    let half = DVec3::new(2.0, 1.5, 1.0);
    let turn = |corner: [f32; 3]| (turned * Vec3::from(corner).as_dvec3()).as_vec3().into();
    let triangles: Vec<[[f32; 3]; 3]> = solid(-half, half).into_iter().map(|corners| corners.map(turn)).collect();
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(29);
    // Onto the face that is at z = 1 before the box is turned, away from its rims.
    let (rays, expected): (Vec<Ray>, Vec<f64>) = (0..400)
        .map(|_| {
            let at = DVec3::new(1.6 * numbers.signed(), 1.1 * numbers.signed(), 1.0);
            let from = at + DVec3::new(numbers.signed(), numbers.signed(), 2.0);
            (ray(turned * from, turned * (at - from)), (at - from).length())
        })
        .unzip();
    let off = |depths: &str| {
        let settings = [("abuffer", "64"), ("depths", depths)];
        let hits = closest(&gpu, &built(&gpu, &geometry, &settings), &rays, &settings);
        assert!(hits.iter().all(Hit::is_hit), "{depths}");
        let mut off: Vec<f64> = hits.iter().zip(&expected).map(|(hit, t)| (f64::from(hit.t) - t).abs()).collect();
        off.sort_by(f64::total_cmp);
        off[rays.len() / 2]
    };
    let (centre, plane) = (off("centre"), off("plane"));
    assert!(centre > 5e-3 && plane < 0.05 * centre, "{centre} {plane}");
}

/// Two plates that face apart, far closer than a voxel: their normals cancel. Then the image along which the ray goes most is asked, which
/// shows them to rays square to them and to others nothing; averaged as lines nothing cancels, and all are seen.
#[test]
fn opposite_normals_cancel() {
    let gpu = gpu();
    let (x, y, z) = (DVec3::X * 4.0, DVec3::Y * 4.0, DVec3::Z * 0.08);
    let corner = DVec3::new(-2.0, -2.0, 0.0);
    let mut triangles = [rectangle(corner + z, x, y), rectangle(corner - z, y, x)].concat();
    triangles.extend(solid(DVec3::splat(2.6), DVec3::splat(3.0)));
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(9);
    let mut through = |slope: f64| -> Vec<Ray> {
        let each = (0..300).map(|_| {
            let target = DVec3::new(numbers.signed(), numbers.signed(), 0.0) * 1.2;
            let turn = std::f64::consts::PI * numbers.signed();
            ray(
                target + DVec3::new(slope * turn.cos(), slope * turn.sin(), 1.0) * 0.5,
                DVec3::new(-slope * turn.cos(), -slope * turn.sin(), -1.0),
            )
        });
        each.collect()
    };
    let (square, oblique) = (through(0.3), through(2.5));
    let found = |average: &str, rays: &[Ray]| {
        let settings = [("abuffer", "128"), ("grid", "8"), ("average", average)];
        let structure = built(&gpu, &geometry, &settings);
        let statistics = structure.validate_against(&geometry).unwrap();
        let cancelled = statistics.iter().find(|(name, _)| *name == "cancelled_voxels").unwrap().1;
        let hits = closest(&gpu, &structure, rays, &settings);
        (cancelled, hits.iter().filter(|hit| hit.is_hit()).count() as f64 / rays.len() as f64)
    };
    let (cancelled, seen) = found("normals", &square);
    assert!(cancelled >= 10.0 && seen > 0.98, "{cancelled} {seen}");
    let (_, seen) = found("normals", &oblique);
    assert!(seen < 0.5, "{seen}");
    let (cancelled, seen) = found("lines", &square);
    assert!(cancelled == 0.0 && seen > 0.98, "{cancelled} {seen}");
    let (_, seen) = found("lines", &oblique);
    assert!(seen > 0.98, "{seen}");
}

/// A surface that is there twice is one layer: by parity two would cancel each other.
#[test]
fn copies_are_one_surface() {
    let gpu = gpu();
    let (rays, _): (Vec<Ray>, Vec<f64>) = onto_the_box(300).into_iter().unzip();
    let once = soup(&boxes(), Some(&gpu));
    let twice = soup(&[boxes(), boxes()].concat(), Some(&gpu));
    let of = |geometry: &Geometry| closest(&gpu, &built(&gpu, geometry, &[]), &rays, &[]);
    assert_eq!(of(&twice), of(&once));
}

/// An open mesh: behind a plate everything is inside by parity. By the state rays from either side find it and go on to the end of the
/// scene; the side at a voxel's entry finds it from both, too.
#[test]
fn open_plates_are_met_from_both_sides() {
    let gpu = gpu();
    let mut triangles = rectangle(DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0).to_vec();
    triangles.extend(rectangle(DVec3::new(-2.0, -2.0, 3.0), DVec3::X * 0.1, DVec3::Y * 0.1));
    let geometry = soup(&triangles, Some(&gpu));
    let structure = built(&gpu, &geometry, &[]);
    let mut numbers = Numbers::new(6);
    for down in [-1.0, 1.0] {
        let each = |_| {
            let target = DVec3::new(numbers.signed(), numbers.signed(), 0.0);
            ray(target + DVec3::new(0.2, 0.1, 1.0) * -down, DVec3::new(0.2, 0.1, 1.0) * down)
        };
        let rays: Vec<Ray> = (0..200).map(each).collect();
        for crossing in ["state", "change"] {
            let hits = closest(&gpu, &structure, &rays, &[("crossing", crossing)]);
            let right = hits.iter().filter(|hit| hit.is_hit() && (hit.t - 1.0247).abs() < 0.3).count();
            assert!(right >= 196, "{down} {crossing}: {right}");
        }
    }
}
