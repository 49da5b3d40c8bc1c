//! What each ray set promises, on scenes small enough to say it by hand.

use std::collections::BTreeSet;

use glam::Vec3;
use tracebench_api::{Geometry, Parameters};
use tracebench_scenes::{Camera, Scene};

use super::*;
use crate::truth::Ray64;
use crate::viewpoint::Pose;

/// A scene with a viewpoint, and what rays are made from.
struct Place {
    truth: Truth,
    viewpoint: Viewpoint,
    path: Option<CameraPath>,
    mirrors: Vec<bool>,
    parameters: Parameters,
    seed: u64,
}

const IMAGE: [u32; 2] = [24, 16];

impl Place {
    fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, pose: &str) -> Self {
        let geometry = Geometry::new(positions, triangles, None).unwrap();
        let viewpoint = Pose::parse(pose).unwrap().viewpoint(&geometry, [4, 4], 4);
        let truth = Truth::new(&geometry, "rays");
        Self { truth, viewpoint, path: None, mirrors: Vec::new(), parameters: default_parameters(), seed: 5 }
    }

    /// A floor of 30 x 40, whose diagonal is 50, from 8 above it.
    fn floor() -> Self {
        let corners = vec![[-15.0, 0.0, -20.0], [15.0, 0.0, -20.0], [15.0, 0.0, 20.0], [-15.0, 0.0, 20.0]];
        Self::new(corners, vec![[0, 2, 1], [0, 3, 2]], "1,8,1:1,0,0.5")
    }

    /// A closed box from (-1, -1, -1) to (1, 1, 1), wound outward, from the front, above and the right.
    fn solid() -> Self {
        let corners = (0..8_u8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| f32::from(bit) * 2.0 - 1.0));
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        Self::new(corners.collect(), triangles.collect(), "1.5,2,4:0,0,0")
    }

    /// A small `room` from where its camera path starts.
    fn room() -> Self {
        let scene: Scene = tracebench_scenes::procedural("room", 0.02).unwrap();
        let camera: &Camera = &scene.cameras[0];
        let is_mirror = |material: &u32| scene.mesh.materials[*material as usize].is_mirror();
        let mirrors = scene.mesh.triangle_materials.iter().map(is_mirror).collect();
        let pose = Pose::from(camera);
        let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, None).unwrap();
        let viewpoint = pose.viewpoint(&geometry, [4, 4], 4);
        let (path, parameters) = (scene.camera_path, default_parameters());
        Self { truth: Truth::new(&geometry, "room"), viewpoint, path, mirrors, parameters, seed: 5 }
    }

    fn with(mut self, parameter: &str, value: &str) -> Self {
        self.parameters.set(&ray_parameters(), parameter, value).unwrap();
        self
    }

    fn tell(&self, rays: &[Ray]) -> Vec<Answer> {
        rays.iter().map(|ray| self.truth.answer_one(&Ray64::from(ray), Query::Closest)).collect()
    }

    fn primary(&self) -> Starts {
        let rays = Arc::new(primary_rays(&self.viewpoint, IMAGE));
        let answers = Arc::new(self.tell(&rays));
        Starts::primary(rays, answers)
    }

    fn try_make(&self, name: &str) -> Result<Vec<Ray>, RayError> {
        let scene = RayScene {
            truth: &self.truth,
            viewpoint: &self.viewpoint,
            path: self.path.as_ref(),
            mirrors: &self.mirrors,
            image: IMAGE,
            seed: self.seed,
            parameters: &RayParameters::try_from(&self.parameters).unwrap(),
        };
        let set = RAY_SETS.iter().find(|set| set.name == name).unwrap();
        make(set, &scene, &self.primary(), |rays| Ok(self.tell(rays))).map(|made| made.rays.to_vec())
    }

    fn make(&self, name: &str) -> Vec<Ray> {
        self.try_make(name).unwrap()
    }

    fn hits(&self) -> usize {
        self.primary().answers.iter().filter(|answer| answer.hit.is_some()).count()
    }
}

fn origin(ray: &Ray) -> DVec3 {
    Ray64::from(ray).origin
}

fn direction(ray: &Ray) -> DVec3 {
    Ray64::from(ray).direction
}

fn bits(rays: &[Ray]) -> BTreeSet<[u32; 8]> {
    rays.iter().map(|ray| bytemuck::cast(*ray)).collect()
}

/// Every set in the room: unit directions, spans that begin at 0, the same rays when made again and in every order,
/// other rays by another seed where chance has a part.
#[test]
fn every_set_is_sound_and_repeats() {
    let room = Place::room();
    let reseeded = Place { seed: 6, ..Place::room() };
    for set in RAY_SETS {
        // The room is closed: what is entered is its furniture, which all sets can show.
        let rays = room.make(set.name);
        assert!(rays.len() > 20, "{}: {}", set.name, rays.len());
        assert!(rays.iter().all(|ray| (direction(ray).length() - 1.0).abs() < 1e-6), "{}", set.name);
        assert!(rays.iter().all(|ray| ray.t_min == 0.0 && ray.t_max > 0.0 && origin(ray).is_finite()), "{}", set.name);
        assert_eq!(bits(&room.make(set.name)), bits(&rays), "{}", set.name);
        for order in ["tile", "shuffled"] {
            let arranged = Place::room().with("order", order).make(set.name);
            assert!(arranged != rays && bits(&arranged) == bits(&rays), "{} {order}", set.name);
        }
        let chances = ["diffuse", "ao", "glossy", "glossy2", "glossy3", "bounce2", "random", "pixel-random", "lens"];
        let by_chance = chances.contains(&set.name);
        assert_eq!(bits(&reseeded.make(set.name)) != bits(&rays), by_chance, "{}", set.name);
    }
}

/// A tenth of the diagonal for `ao`, no end for the others that leave a surface, origins lifted by what the
/// documentation says: given here as plain numbers, so that a changed constant is noticed.
#[test]
fn lengths_and_offsets_are_the_documented_ones() {
    let floor = Place::floor();
    assert!((f64::from(floor.viewpoint.near) - 0.05).abs() < 1e-7);
    for (name, t_max) in [("diffuse", Ray::UNBOUNDED), ("ao", 5.0), ("specular", Ray::UNBOUNDED), ("glossy", 1e30)] {
        let rays = floor.make(name);
        assert_eq!(rays.len(), floor.hits(), "{name}");
        assert!(rays.iter().all(|ray| ray.t_max == t_max), "{name}");
        assert!(rays.iter().all(|ray| (ray.origin[1] - 5e-4).abs() < 5e-5 && ray.direction[1] > 0.0), "{name}");
    }
}

/// A surface that is seen from behind sends its rays back to the side that it is seen from: out of a box that is wound
/// inside out, where its normals point inward.
#[test]
fn rays_leave_on_the_side_that_is_seen() {
    let solid = Place::solid();
    let geometry = solid.truth.geometry();
    let turned: Vec<[u32; 3]> = geometry.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let turned = Place::new(geometry.positions.to_vec(), turned, "1.5,2,4:0,0,0");
    for name in ["diffuse", "ao", "specular", "glossy", "visibility", "pixel-random"] {
        for place in [&solid, &turned] {
            let rays = place.make(name);
            assert!(rays.iter().all(|ray| origin(ray).abs().max_element() > 1.0), "{name}");
            let leaves = |ray: &Ray| place.truth.closest(&Ray64::from(ray)).is_none();
            assert!(!rays.is_empty() && rays.iter().all(leaves), "{name}: nothing lies outside of a box");
        }
    }
}

/// Primary rays start at the eye and go through the centres of the pixels, from the top left on.
#[test]
fn primary_rays_go_through_pixel_centres() {
    let floor = Place::floor();
    let view = Viewpoint { frame: IMAGE, ..floor.viewpoint }.frame_view();
    for (pixel, ray) in floor.make("primary").iter().enumerate() {
        assert_eq!(Vec3::from(ray.origin), floor.viewpoint.eye);
        let at = view.project(view.eye + direction(ray)).unwrap();
        let expected = ((pixel % 24) as f64 + 0.5, (pixel / 24) as f64 + 0.5);
        assert!((at.x - expected.0).abs() < 1e-4 && (at.y - expected.1).abs() < 1e-4, "{pixel}");
    }
}

/// Rays of `visibility` end at two points, one outside and one inside of the bounds; the room lets none reach the outer
/// one; one target alone gives its half.
#[test]
fn visibility_ends_at_its_targets() {
    let room = Place::room();
    let geometry = room.truth.geometry();
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    let rays = room.make("visibility");
    let end = |ray: &Ray| Ray64::from(ray).at(f64::from(ray.t_max));
    let within = |point: DVec3| point.cmpge(low).all() && point.cmple(high).all();
    let (inside, outside): (Vec<&Ray>, Vec<&Ray>) = rays.iter().partition(|ray| within(end(ray)));
    assert!(inside.len() > 50 && outside.len() > 50);
    for rays in [&inside, &outside] {
        assert!(rays.iter().all(|ray| end(ray).distance(end(rays[0])) < 1e-4), "one target each");
    }
    // As documented, in plain numbers.
    let (size, diagonal) = (high - low, (high - low).length());
    let expected =
        [low + size * DVec3::new(0.5, 0.8, 0.5), (low + high) / 2.0 + diagonal * DVec3::new(0.35, 0.9, 0.25)];
    for (rays, expected) in [&inside, &outside].into_iter().zip(expected) {
        assert!(end(rays[0]).distance(expected) < 1e-4, "{expected}");
    }
    let reaches = |ray: &Ray| room.truth.closest(&Ray64::from(ray)).is_none();
    assert!(!outside.iter().any(|ray| reaches(ray)));
    let free = inside.iter().filter(|ray| reaches(ray)).count();
    assert!(free > 20 && free < inside.len(), "{free} of {}", inside.len());
    for (target, half) in [("inside", &inside), ("outside", &outside)] {
        let alone = Place::room().with("visibility_target", target).make("visibility");
        assert_eq!(bits(&alone), half.iter().map(|ray| bytemuck::cast(**ray)).collect(), "{target}");
    }
}

/// Mirrored rays start on mirrors alone where there are any, everywhere where there are none, and obey the law.
#[test]
fn specular_rays_leave_mirrors() {
    let room = Place::room();
    let primary = room.primary();
    let on_mirror = |answer: &Answer| answer.hit.is_some_and(|hit| room.mirrors[hit.primitive as usize]);
    let expected = primary.answers.iter().filter(|answer| on_mirror(answer)).count();
    assert_eq!(room.make("specular").len(), expected);
    assert!(expected > 0 && expected < room.hits());
    let floor = Place::floor();
    for (ray, came) in floor.make("specular").iter().zip(floor.primary().rays.iter()) {
        let flipped = direction(came) * DVec3::new(1.0, -1.0, 1.0);
        assert!((direction(ray) - flipped).length() < 1e-6);
    }
    let none = Place { mirrors: vec![false; 12], ..Place::solid() };
    assert_eq!(none.make("specular").len(), none.hits());
}

/// Glossy rays leave about the mirrored direction, nearer to it the smoother the surface is, and never into it.
#[test]
fn glossy_rays_keep_to_the_mirrored_direction() {
    let spread = |roughness: &str| {
        let floor = Place::floor().with("glossy_roughness", roughness);
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
    let room = Place::room().with("glossy_roughness", "0.001");
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
    assert!(matches!(Place::floor().try_make("glossy2"), Err(RayError::Empty(reason)) if reason.contains("glossy")));
    // In terms of the surface: how far a facet's normal lies off it is the same only where the numbers are.
    let room = Place::room();
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
    let room = Place::room();
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
    let solid = Place::solid();
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
    let straight = Place::solid().with("refractive_index", "1").make("refraction");
    assert!(straight.iter().zip(&came).all(|(ray, came)| direction(ray).distance(direction(came)) < 1e-6));
    assert!(matches!(Place::floor().try_make("refraction"), Err(RayError::Empty(reason)) if reason.contains("solid")));
    let geometry = solid.truth.geometry();
    let turned: Vec<[u32; 3]> = geometry.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let turned = Place::new(geometry.positions.to_vec(), turned, "1.5,2,4:0,0,0");
    assert!(turned.try_make("refraction").is_err());
}

/// Random rays start all over the bounds, in all directions.
#[test]
fn random_rays_fill_the_bounds() {
    let rays = Place::solid().make("random");
    assert_eq!(rays.len(), 24 * 16);
    assert!(rays.iter().all(|ray| origin(ray).abs().max_element() <= 1.0));
    let on_a_plane = |ray: &&Ray| (0..3).any(|axis| ray.origin[axis] == ray.origin[(axis + 1) % 3]);
    assert_eq!(rays.iter().filter(on_a_plane).count(), 0);
    for axis in 0..3 {
        for part in [|ray: &Ray| ray.origin, |ray: &Ray| ray.direction] {
            let above = rays.iter().filter(|ray| part(ray)[axis] > 0.0).count();
            assert!((150..234).contains(&above), "{axis} {above}");
        }
    }
}

/// Twenty rays a primary hit, all different; more rays than can be held are refused by name.
#[test]
fn pixel_random_starts_twenty_a_pixel() {
    let floor = Place::floor();
    let rays = floor.make("pixel-random");
    assert_eq!((rays.len(), bits(&rays).len()), (20 * floor.hits(), 20 * floor.hits()));
    // The floor has one normal: directions that recur would be those of one stream.
    let directions: BTreeSet<[u32; 3]> = rays.iter().map(|ray| ray.direction.map(f32::to_bits)).collect();
    assert_eq!(directions.len(), rays.len());
    assert!(rays.chunks(20).all(|chunk| chunk.iter().all(|ray| ray.origin == chunk[0].origin)));
    assert_eq!(Place::floor().with("pixel_random_count", "3").make("pixel-random").len(), 3 * floor.hits());
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
    let miss = Answer { hit: None, tie: false };
    let many = Starts::primary(Arc::new(vec![ray; 1_000_000]), Arc::new(vec![miss; 1_000_000]));
    let set = RAY_SETS.iter().find(|set| set.name == "pixel-random").unwrap();
    let error = make(set, &scene, &many, |_| Ok(Vec::new())).unwrap_err().to_string();
    assert!(error.contains("20000000") && error.contains("pixel_random_count"), "{error}");
}

/// The second eye stands 3.2 cm to the right and looks the same way.
#[test]
fn stereo_moves_the_eye_to_the_right() {
    let floor = Place::floor();
    let right = floor.viewpoint.frame_view().right * 0.032;
    for (ray, first) in floor.make("stereo").iter().zip(floor.make("primary").iter()) {
        assert!((origin(ray) - origin(first) - right).length() < 1e-6 && ray.direction == first.direction);
    }
}

/// From the start of a camera path the later camera is the path's own; without a path it has moved ahead; no time later
/// nothing has moved.
#[test]
fn temporal_follows_the_camera_path() {
    let room = Place::room();
    let camera = room.path.as_ref().unwrap().at(0.5);
    let later = Pose::from(&camera).viewpoint(room.truth.geometry(), IMAGE, 1);
    let expected = primary_rays(&later, IMAGE);
    for (ray, expected) in room.make("temporal").iter().zip(&expected) {
        assert!(origin(ray).distance(origin(expected)) < 1e-5);
        assert!(direction(ray).distance(direction(expected)) < 1e-5);
    }
    let same = |a: &[Ray], b: &[Ray]| a.iter().zip(b).all(|(a, b)| direction(a).distance(direction(b)) < 1e-5);
    assert!(!same(&room.make("temporal"), &room.make("primary")));
    assert!(same(&Place::room().with("temporal_shift_s", "0").make("temporal"), &room.make("primary")));
    let floor = Place::floor();
    let moved = origin(&floor.make("temporal")[0]) - floor.viewpoint.eye.as_dvec3();
    assert!((moved - floor.viewpoint.forward.as_dvec3() * 0.5).length() < 1e-5);
}

/// Rays through the lens start within its rim and meet the primary ray of their pixel in the plane in focus: by default
/// that of what the centre shows. Without an aperture they are the primary rays.
#[test]
fn lens_rays_meet_in_focus() {
    let floor = Place::floor();
    let view = Viewpoint { frame: IMAGE, ..floor.viewpoint }.frame_view();
    let meet = |rays: &[Ray], focus: f64| {
        rays.iter().zip(floor.make("primary").iter()).all(|(ray, straight)| {
            let point = view.eye + direction(straight) * (focus / direction(straight).dot(view.forward));
            let t = (point - origin(ray)).dot(view.forward) / direction(ray).dot(view.forward);
            (Ray64::from(ray).at(t) - point).length() < 1e-4
        })
    };
    let centre = (IMAGE[1] / 2 * IMAGE[0] + IMAGE[0] / 2) as usize;
    let primary = floor.primary();
    let depth = primary.answers[centre].hit.unwrap().t * direction(&primary.rays[centre]).dot(view.forward);
    let rays = floor.make("lens");
    assert!(meet(&rays, depth) && !meet(&rays, depth * 1.2));
    assert!(meet(&Place::floor().with("lens_focus", "0.5").make("lens"), 25.0));
    let distances: Vec<f64> = rays.iter().map(|ray| origin(ray).distance(view.eye)).collect();
    assert!(distances.iter().all(|distance| *distance <= 0.25 + 1e-5) && distances.iter().any(|each| *each > 0.2));
    let closed = Place::floor().with("lens_aperture", "0").make("lens");
    assert!(closed.iter().zip(primary.rays.iter()).all(|(a, b)| direction(a).distance(direction(b)) < 1e-6));
}

/// Several rays a pixel stay together, each from a place of its own on the lens through its pixel's point in focus; more
/// than can be held are refused by the parameter's name.
#[test]
fn lenses_start_several_rays_a_pixel() {
    let floor = Place::floor().with("lens_count", "4").with("lens_focus", "0.5");
    let view = Viewpoint { frame: IMAGE, ..floor.viewpoint }.frame_view();
    let (rays, straight) = (floor.make("lens"), floor.make("primary"));
    assert_eq!((rays.len(), bits(&rays).len()), (4 * straight.len(), 4 * straight.len()));
    for (four, straight) in rays.chunks(4).zip(&straight) {
        let point = view.eye + direction(straight) * (25.0 / direction(straight).dot(view.forward));
        for ray in four {
            let t = (point - origin(ray)).dot(view.forward) / direction(ray).dot(view.forward);
            assert!((Ray64::from(ray).at(t) - point).length() < 1e-4 && origin(ray).distance(view.eye) <= 0.25 + 1e-5);
        }
    }
    let origins: BTreeSet<[u32; 3]> = rays.iter().map(|ray| ray.origin.map(f32::to_bits)).collect();
    assert_eq!(origins.len(), rays.len());
    let parameters = Place::floor().with("lens_count", "64").parameters;
    let scene = RayScene {
        truth: &floor.truth,
        viewpoint: &floor.viewpoint,
        path: None,
        mirrors: &[],
        image: [1000, 1000],
        seed: 1,
        parameters: &RayParameters::try_from(&parameters).unwrap(),
    };
    let many = Starts::primary(
        Arc::new(vec![straight[0]; 1_000_000]),
        Arc::new(vec![Answer { hit: None, tie: false }; 1_000_000]),
    );
    let set = RAY_SETS.iter().find(|set| set.name == "lens").unwrap();
    let error = make(set, &scene, &many, |_| Ok(Vec::new())).unwrap_err().to_string();
    assert!(error.contains("64000000") && error.contains("lens_count"), "{error}");
}

/// Sixteen eyes in a square of the stated width, each with its part of the image and the whole field of view; one camera
/// is the viewpoint's.
#[test]
fn light_fields_are_squares_of_cameras() {
    let floor = Place::floor();
    let rays = floor.make("light-field");
    let mut eyes: Vec<DVec3> = Vec::new();
    for ray in &rays {
        if eyes.iter().all(|eye| eye.distance(origin(ray)) > 1e-4) {
            eyes.push(origin(ray));
        }
    }
    let view = floor.viewpoint.frame_view();
    assert_eq!(eyes.len(), 16);
    let across = eyes.iter().map(|eye| (*eye - view.eye).dot(view.right));
    assert!((across.clone().fold(f64::MIN, f64::max) - 1.25).abs() < 1e-4);
    assert!((across.fold(f64::MAX, f64::min) + 1.25).abs() < 1e-4);
    // The image's first pixel is the left upper camera's; its neighbour there looks four pixels to the right.
    assert!((origin(&rays[0]) - view.eye - (view.up - view.right) * 1.25).length() < 1e-4);
    assert!(rays[5].origin == rays[0].origin && rays[6].origin != rays[0].origin);
    let one = Place::floor().with("light_field_cameras", "1").make("light-field");
    let primary = floor.make("primary");
    assert!(one.iter().zip(&primary).all(|(a, b)| direction(a).distance(direction(b)) < 1e-6 && a.origin == b.origin));
}

/// Looking away from everything only the sets that need no hit have rays; the others say why.
#[test]
fn sets_without_hits_are_empty_for_a_reason() {
    let mut away = Place::floor();
    away.viewpoint = Pose::parse("0,1,0:0,2,0.1").unwrap().viewpoint(away.truth.geometry(), [4, 4], 4);
    for set in RAY_SETS {
        let made = away.try_make(set.name);
        let needs_none = ["primary", "random", "stereo", "temporal", "lens", "light-field"].contains(&set.name);
        match made {
            Ok(rays) => assert!(needs_none && rays.len() == 24 * 16, "{}", set.name),
            Err(error) => assert!(!needs_none && error.to_string().contains("no primary ray"), "{} {error}", set.name),
        }
    }
}
