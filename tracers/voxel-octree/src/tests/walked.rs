//! Hits against a march of the voxels that are stored, in f64.

use super::*;
use crate::reference::CellPosition;
use tracebench_kit::{Built, to_scene, to_unit};

/// Within which distance of a voxel's side f32 may take a ray for in or out, voxels.
const BORDER: f64 = 1e-2;

/// The voxels of a tree, and rays through them in voxels.
struct March<'a> {
    structure: &'a Built<OctreeStructure>,
    voxels: Vec<DVec3>,
}

impl<'a> March<'a> {
    fn of(structure: &'a Built<OctreeStructure>) -> Self {
        let levels = structure.layout.levels;
        let keys = structure.read().unwrap().keys().unwrap();
        let voxel = |key: u32| DVec3::from(CellPosition { depth: levels, key }.cell().map(f64::from));
        Self { structure, voxels: keys.into_iter().map(voxel).collect() }
    }

    /// The parameters at which a ray is in a box, within its span.
    fn span(origin: DVec3, direction: DVec3, low: DVec3, high: DVec3, [t_min, t_max]: [f64; 2]) -> Option<[f64; 2]> {
        let (mut begin, mut end) = (t_min, t_max);
        for axis in 0..3 {
            let ends = [low[axis] - origin[axis], high[axis] - origin[axis]];
            if direction[axis] == 0.0 {
                if ends[0] > 0.0 || ends[1] < 0.0 {
                    return None;
                }
                continue;
            }
            let [first, second] = ends.map(|end| end / direction[axis]);
            begin = begin.max(first.min(second));
            end = end.min(first.max(second));
        }
        (begin <= end).then_some([begin, end])
    }

    /// What is wrong with a hit. Voxels that are a little smaller than they are must be hit, those a little larger may be; those that hold
    /// the start are left first: all that the ray goes through until it is in none.
    fn wrong(&self, ray: &Ray, hit: &Hit) -> Option<String> {
        let (layout, edge) = (&self.structure.layout, f64::from(self.structure.layout.edge()));
        let origin = to_unit(&layout.space, Vec3::from(ray.origin).as_dvec3()) * edge;
        let direction = Vec3::from(ray.direction).as_dvec3() * f64::from(layout.space.scale[0]) * edge;
        let whole = [f64::from(ray.t_min), f64::from(ray.t_max)];
        let of = |by: f64| -> Vec<[f64; 2]> {
            let (wider, size) = (DVec3::splat(by), DVec3::ONE);
            let spans =
                self.voxels.iter().map(|low| Self::span(origin, direction, *low - wider, *low + size + wider, whole));
            let mut spans: Vec<[f64; 2]> = spans.flatten().collect();
            spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
            spans
        };
        let (must, may) = (of(-BORDER), of(BORDER));
        // The first parameter that lies in none of some spans.
        let leaves = |spans: &[[f64; 2]]| {
            spans.iter().fold(whole[0], |at, [begin, end]| if *begin <= at { at.max(*end) } else { at })
        };
        // Grown spans meet where the ray is in a voxel and then the next one: until there it may be leaving, or may have left.
        let (soonest, latest) = (leaves(&must), leaves(&may));
        // Shrunk ones have gaps between neighbours, which a walk does not: what it certainly passes through is in both.
        let after = must.iter().find(|[begin, _]| *begin > latest).map(|[begin, end]| [*begin, *end]);
        let tolerance = 2.0 * BORDER / direction.length();
        if !hit.is_hit() {
            return after.map(|[begin, end]| format!("a miss instead of {begin}..{end}, after {latest}"));
        }
        let t = f64::from(hit.t);
        if !may.iter().any(|[begin, end]| t >= begin - tolerance && t <= end + tolerance) {
            return Some(format!("a hit at {t} in no voxel"));
        }
        if t < soonest - tolerance {
            return Some(format!("a hit at {t} in the voxels of the start, which end at {soonest}"));
        }
        after
            .filter(|[_, end]| t > end + tolerance)
            .map(|[begin, end]| format!("a hit at {t} instead of {begin}..{end}"))
    }
}

/// Rays of every kind that is hard: along axes, along voxels' sides and edges and through their corners, from within voxels and from
/// outside, bounded, and with zeros of either sign.
fn rays(structure: &Built<OctreeStructure>) -> Vec<Ray> {
    let mut numbers = Numbers::new(4);
    let space = structure.layout.space;
    let edge = f64::from(structure.layout.edge());
    let corner = |numbers: &mut Numbers| to_scene(&space, (numbers.point() * 0.5 + 0.5) * edge / edge);
    let snapped = |numbers: &mut Numbers| to_scene(&space, ((numbers.point() * 0.5 + 0.5) * edge).round() / edge);
    let axes = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z];
    let diagonals = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(0.0, -1.0, -1.0)];
    let one = |index: usize, numbers: &mut Numbers| match index % 8 {
        0 => {
            let from = numbers.direction() * 20.0;
            ray(from, numbers.point() * 5.0 - from)
        }
        1 => ray(corner(numbers), axes[index / 8 % 6]),
        2 => ray(snapped(numbers), axes[index / 8 % 6]),
        3 => ray(snapped(numbers), diagonals[index / 8 % 3]),
        4 => ray(corner(numbers), numbers.direction()),
        5 => Ray { t_min: 0.5, t_max: 4.0, ..ray(corner(numbers), numbers.direction()) },
        6 => {
            let along = ray(snapped(numbers), axes[index / 8 % 6]);
            Ray { direction: along.direction.map(|value| if value == 0.0 { -0.0 } else { value }), ..along }
        }
        _ => ray(snapped(numbers), snapped(numbers) - snapped(numbers)),
    };
    let all = (0..1600).map(|index| one(index, &mut numbers));
    all.filter(|ray| Vec3::from(ray.direction).is_finite()).collect()
}

/// Every ray is answered as by a march in f64 through all voxels that are stored, and wrong answers are noticed.
#[test]
fn hits_are_those_of_a_march() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    for levels in ["1", "4", "6"] {
        let settings = [("levels", levels)];
        let structure = built(&gpu, &geometry, &settings);
        let march = March::of(&structure);
        let rays = rays(&structure);
        let hits = closest(&structure, &rays, &settings);
        let found = hits.iter().filter(|hit| hit.is_hit()).count();
        assert!(levels == "1" || (found > 300 && found < hits.len() - 100), "{levels}: {found} of {}", hits.len());
        for (index, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            assert_eq!(march.wrong(ray, hit), None, "{levels}: ray {index}, {ray:?} {hit:?}");
        }
        if levels == "1" {
            continue;
        }
        // Negative controls: a hit missed, one too early, one too late, one that is not there.
        let noticed = |spoil: &dyn Fn(&Hit) -> Option<Hit>| {
            let spoilt =
                rays.iter().zip(&hits).filter_map(|(ray, hit)| spoil(hit).map(|other| march.wrong(ray, &other)));
            let (wrong, all) = spoilt.fold((0, 0), |(wrong, all), each| (wrong + usize::from(each.is_some()), all + 1));
            assert!(wrong * 2 > all, "{wrong} of {all} are noticed");
        };
        let voxel = geometry.diagonal() as f32 / structure.layout.edge() as f32;
        noticed(&|hit| hit.is_hit().then(|| Hit::miss(tracebench_api::Status::Miss)));
        noticed(&|hit| hit.is_hit().then_some(Hit { t: hit.t + 8.0 * voxel, ..*hit }));
        noticed(&|hit| (!hit.is_hit()).then_some(Hit { t: 100.0, status: 1, ..*hit }));
    }
}

/// A ray leaves the voxels that hold its start, and ends where it enters those of the next wall, or nearest to the first of their centres;
/// the wall behind its start is not met, nor that beyond its end.
#[test]
fn starts_are_left_and_walls_are_met() {
    let gpu = gpu();
    let geometry = soup(&[wall(-1.0), wall(0.31), wall(1.0)].concat(), Some(&gpu));
    let settings = [("levels", "6")];
    let structure = built(&gpu, &geometry, &settings);
    let voxel = 2.0 / 62.0;
    let from = |z: f64, direction| ray(DVec3::new(0.1, 0.2, z), direction);
    let rays = [from(-1.0, DVec3::Z), from(-3.0, DVec3::Z), from(0.9, DVec3::NEG_Z), from(0.5, DVec3::X)];
    let bounded = [Ray { t_max: 1.2, ..rays[0] }, Ray { t_max: 1.35, ..rays[0] }, Ray { t_min: 2.1, ..rays[1] }];
    for (place, most) in [("entry", 1.1), ("centre", 0.6)] {
        let settings = [settings[0], ("hit", place)];
        let hits = closest(&structure, &rays, &settings);
        for (hit, t) in hits.iter().zip([1.31, 2.0, 0.59]) {
            let before = t - f64::from(hit.t);
            assert!(
                hit.is_hit() && before.abs() < most * voxel && (place == "centre" || before > -1e-4),
                "{hit:?} {t}"
            );
        }
        assert!(!hits[3].is_hit());
        let ends = closest(&structure, &bounded, &settings);
        assert_eq!(ends.iter().map(Hit::is_hit).collect::<Vec<_>>(), [false, true, true]);
        assert!(f64::from(ends[2].t) > 3.2 && ends[1].t <= 1.35);
    }
}

/// No ray gets through a closed, tilted surface between any of its triangles, however thin its voxels are: from within a sphere every ray
/// hits, from close to it as well.
#[test]
fn surfaces_have_no_holes() {
    let gpu = gpu();
    let mut numbers = Numbers::new(17);
    let at = |theta: f64, phi: f64| {
        DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()).as_vec3().to_array()
    };
    let (rings, sectors) = (24, 40);
    let step = |ring: i32, sector: i32| {
        at(
            std::f64::consts::PI * f64::from(ring) / f64::from(rings),
            std::f64::consts::TAU * f64::from(sector) / f64::from(sectors),
        )
    };
    let mut sphere = Vec::new();
    for (ring, sector) in (0..rings).flat_map(|ring| (0..sectors).map(move |sector| (ring, sector))) {
        let [a, b, c, d] =
            [step(ring, sector), step(ring, sector + 1), step(ring + 1, sector), step(ring + 1, sector + 1)];
        sphere.extend([[a, b, c], [b, d, c]]);
    }
    let geometry = soup(&sphere, Some(&gpu));
    for levels in ["4", "8"] {
        let structure = built(&gpu, &geometry, &[("levels", levels)]);
        let rays: Vec<Ray> = (0..4000).map(|_| ray(numbers.point() * 0.4, numbers.direction())).collect();
        let hits = closest(&structure, &rays, &[("levels", levels)]);
        assert_eq!(hits.iter().filter(|hit| !hit.is_hit()).count(), 0, "{levels}");
        // From five hundred diagonals away, where a position in f32 is a share of a voxel.
        let far: Vec<Ray> = (0..4000)
            .map(|_| {
                let from = numbers.direction() * 1000.0;
                ray(from, numbers.point() * 0.5 - from)
            })
            .collect();
        assert_eq!(
            closest(&structure, &far, &[("levels", levels)]).iter().filter(|hit| !hit.is_hit()).count(),
            0,
            "{levels}"
        );
    }
}
