//! Rays that leave what primary rays hit.

use super::*;

/// A surface that is seen from behind sends its rays back to the side that it is seen from: out of a box that is wound
/// inside out, where its normals point inward.
#[test]
fn rays_leave_on_the_side_that_is_seen() {
    let solid = TestScene::solid();
    let geometry = solid.truth.geometry();
    let turned: Vec<[u32; 3]> = geometry.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let turned = TestScene::new(geometry.positions.to_vec(), turned, "1.5,2,4:0,0,0");
    for name in ["diffuse", "ao", "specular", "glossy", "visibility", "pixel-random"] {
        for place in [&solid, &turned] {
            let rays = place.make(name);
            assert!(rays.iter().all(|ray| origin(ray).abs().max_element() > 1.0), "{name}");
            let leaves = |ray: &Ray| place.truth.closest(&Ray64::from(ray)).is_none();
            assert!(!rays.is_empty() && rays.iter().all(leaves), "{name}: nothing lies outside of a box");
        }
    }
}

/// Mirrored rays start on mirrors alone where there are any, everywhere where there are none, and obey the law.
#[test]
fn specular_rays_leave_mirrors() {
    let room = TestScene::room();
    let primary = room.primary();
    let on_mirror = |answer: &Answer| answer.hit.is_some_and(|hit| room.mirrors[hit.primitive as usize]);
    let expected = primary.answers.iter().filter(|answer| on_mirror(answer)).count();
    assert_eq!(room.make("specular").len(), expected);
    assert!(expected > 0 && expected < room.hits());
    let floor = TestScene::floor();
    for (ray, came) in floor.make("specular").iter().zip(floor.primary().rays.iter()) {
        let flipped = direction(came) * DVec3::new(1.0, -1.0, 1.0);
        assert!((direction(ray) - flipped).length() < 1e-6);
    }
    let none = TestScene { mirrors: vec![false; 12], ..TestScene::solid() };
    assert_eq!(none.make("specular").len(), none.hits());
}

/// Glossy rays leave about the mirrored direction, nearer to it the smoother the surface is, and never into it.
#[test]
fn glossy_rays_keep_to_the_mirrored_direction() {
    let spread = |roughness: &str| {
        let floor = TestScene::floor().with("glossy_roughness", roughness);
        let (glossy, mirrored) = (floor.make("glossy"), floor.make("specular"));
        assert!(glossy.iter().all(|ray| ray.direction[1] > 0.0));
        let cosines = glossy.iter().zip(&mirrored).map(|(ray, mirrored)| direction(ray).dot(direction(mirrored)));
        cosines.sum::<f64>() / glossy.len() as f64
    };
    let (smooth, middle, rough) = (spread("0.001"), spread("0.25"), spread("1"));
    assert!(smooth > 0.9999 && middle < 0.999 && middle > rough && rough > 0.3, "{smooth} {middle} {rough}");
}

/// Each bounce of glossy rays starts where the one before hit, lifted by an offset, and keeps to the mirrored direction the
/// better the smoother surfaces are; its chances are its own: with those of the bounce before, facets would lie alike.
#[test]
fn glossy_bounces_start_at_the_hits_before() {
    let room = TestScene::room().with("glossy_roughness", "0.001");
    let offset = 2.0 * ORIGIN_OFFSET_DIAGONALS * room.truth.diagonal();
    let sets = ["glossy", "glossy2", "glossy3"].map(|name| room.make(name));
    for pair in sets.windows(2) {
        let starts = pair[0].iter().filter_map(|ray| {
            let came = Ray64::from(ray);
            room.truth.closest(&came).map(|hit| (came.at(hit.t), came.direction, room.truth.normal(hit.primitive)))
        });
        let starts: Vec<_> = starts.collect();
        assert!(starts.len() > 100 && starts.len() == pair[1].len(), "{} of {}", pair[1].len(), starts.len());
        let mut off = 0;
        for (ray, (point, came, normal)) in pair[1].iter().zip(&starts) {
            assert!(origin(ray).distance(*point) < offset, "{ray:?}");
            let mirrored = *came - *normal * (2.0 * came.dot(*normal));
            // A facet of so narrow a lobe is nearly the surface; one that would send the ray into it is none.
            off += usize::from(direction(ray).distance(mirrored) > 0.02);
        }
        assert!(off * 50 < starts.len(), "{off} of {}", starts.len());
    }
    // The floor's glossy rays go up and away.
    assert!(
        matches!(TestScene::floor().try_make("glossy2"), Err(RayError::Empty(reason)) if reason.contains("glossy"))
    );
    // In terms of the surface: how far a facet's normal lies off it is the same only where the numbers are.
    let room = TestScene::room();
    let facets = |rays: &[Ray], came: &Starts| -> Vec<f64> {
        let hits = came.rays.iter().zip(came.answers.iter()).filter_map(|(ray, answer)| Some((ray, answer.hit?)));
        let facet = |(ray, (came, hit)): (&Ray, (&Ray, crate::truth::TrueHit))| {
            (direction(ray) - direction(came)).normalize_or_zero().dot(room.truth.normal(hit.primitive)).abs()
        };
        rays.iter().zip(hits).map(facet).collect()
    };
    let first = room.make("glossy");
    let told = Starts::primary(Arc::new(first.clone()), Arc::new(room.tell(&first)));
    let (first, second) = (facets(&first, &room.primary()), facets(&room.make("glossy2"), &told));
    let same = first.iter().zip(&second).filter(|(a, b)| (*a - *b).abs() < 1e-5).count();
    assert!(same * 20 < second.len(), "{same} of {}", second.len());
}

/// The second bounce starts where diffuse rays hit, lifted by an offset; nothing else does.
#[test]
fn second_bounces_start_at_diffuse_hits() {
    let room = TestScene::room();
    let diffuse = room.make("diffuse");
    let points: Vec<DVec3> = diffuse
        .iter()
        .filter_map(|ray| room.truth.closest(&Ray64::from(ray)).map(|hit| Ray64::from(ray).at(hit.t)))
        .collect();
    let offset = ORIGIN_OFFSET_DIAGONALS * room.truth.diagonal();
    let starts = room.make("bounce2");
    assert_eq!(starts.len(), points.len());
    assert!(starts.iter().zip(&points).all(|(ray, point)| origin(ray).distance(*point) < 2.0 * offset));
    assert!(diffuse.iter().zip(&points).any(|(ray, point)| origin(ray).distance(*point) > 100.0 * offset));
    // By numbers of its own: with those of the first bounce the angles to the surfaces would be the same.
    let angles = |rays: &[Ray], starts: &Starts| -> Vec<f64> {
        let hits = starts.rays.iter().zip(starts.answers.iter()).filter_map(|(ray, answer)| Some((ray, answer.hit?)));
        let normals = hits.map(|(_, hit)| room.truth.normal(hit.primitive));
        rays.iter().zip(normals).map(|(ray, normal)| direction(ray).dot(normal).abs()).collect()
    };
    let told = Starts::primary(Arc::new(diffuse.clone()), Arc::new(room.tell(&diffuse)));
    let (first, second) = (angles(&diffuse, &room.primary()), angles(&starts, &told));
    let same = first.iter().zip(&second).filter(|(a, b)| (*a - *b).abs() < 1e-4).count();
    assert!(same * 20 < first.len(), "{same} of {}", first.len());
}

/// Refracted rays start inside of the box, bent by Snell's law, and leave it; a sheet without an inside has none, nor
/// has the box when it is wound inside out.
#[test]
fn refraction_starts_inside_solids() {
    let solid = TestScene::solid();
    let rays = solid.make("refraction");
    assert_eq!(rays.len(), solid.hits());
    let came: Vec<Ray> = {
        let primary = solid.primary();
        let hit = |(ray, answer): (&Ray, &Answer)| answer.hit.map(|_| *ray);
        primary.rays.iter().zip(primary.answers.iter()).filter_map(hit).collect()
    };
    for (ray, came) in rays.iter().zip(&came) {
        assert!(origin(ray).abs().max_element() < 1.0, "{ray:?}");
        let hit = solid.truth.closest(&Ray64::from(ray)).unwrap();
        assert!(solid.truth.normal(hit.primitive).dot(direction(ray)) > 0.0);
        // The face that was entered is the one that the start is nearest to.
        let axis = origin(ray).abs().max_position();
        let sine = |ray: &Ray| (1.0 - direction(ray)[axis] * direction(ray)[axis]).max(0.0).sqrt();
        assert!((sine(ray) * 1.5 - sine(came)).abs() < 1e-5, "{ray:?}");
    }
    let straight = TestScene::solid().with("refractive_index", "1").make("refraction");
    assert!(straight.iter().zip(&came).all(|(ray, came)| direction(ray).distance(direction(came)) < 1e-6));
    assert!(
        matches!(TestScene::floor().try_make("refraction"), Err(RayError::Empty(reason)) if reason.contains("solid"))
    );
    let geometry = solid.truth.geometry();
    let turned: Vec<[u32; 3]> = geometry.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let turned = TestScene::new(geometry.positions.to_vec(), turned, "1.5,2,4:0,0,0");
    assert!(turned.try_make("refraction").is_err());
}

/// Twenty rays a primary hit, all different; more rays than can be held are refused by name.
#[test]
fn pixel_random_starts_twenty_a_pixel() {
    let floor = TestScene::floor();
    let rays = floor.make("pixel-random");
    assert_eq!((rays.len(), bits(&rays).len()), (20 * floor.hits(), 20 * floor.hits()));
    // The floor has one normal: directions that recur would be those of one stream.
    let directions: BTreeSet<[u32; 3]> = rays.iter().map(|ray| ray.direction.map(f32::to_bits)).collect();
    assert_eq!(directions.len(), rays.len());
    assert!(rays.chunks(20).all(|chunk| chunk.iter().all(|ray| ray.origin == chunk[0].origin)));
    assert_eq!(TestScene::floor().with("pixel_random_count", "3").make("pixel-random").len(), 3 * floor.hits());
    let scene = RayScene {
        truth: &floor.truth,
        viewpoint: &floor.viewpoint,
        path: None,
        mirrors: &[],
        image: [1000, 1000],
        seed: 1,
        parameters: &RayParameters::try_from(&floor.parameters).unwrap(),
    };
    let ray = floor.primary().rays[0];
    let miss = Answer { hit: None, perturbed: None };
    let many = Starts::primary(Arc::new(vec![ray; 1_000_000]), Arc::new(vec![miss; 1_000_000]));
    let set = RAY_SETS.iter().find(|set| set.name == "pixel-random").unwrap();
    let error = make(set, &scene, &many, |_| Ok(Vec::new())).unwrap_err().to_string();
    assert!(error.contains("20000000") && error.contains("pixel_random_count"), "{error}");
}
