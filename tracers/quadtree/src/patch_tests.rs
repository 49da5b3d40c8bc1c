//! Planes that end at those beside them, against geometry told by hand.

use std::sync::Arc;

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_api::{Hit, Ray, TraceTo};
use tracebench_tests::{gpu, ray, soup};

use super::structure::Quadtree;
use super::tests::{LOSSLESS, answer, built_by, rectangle, viewpoint};
use super::trace_tests::{JOINED, counted, of};

/// What stands before the eye, as right and ahead have it: the front of a block, its side, of which little more than two pixels are seen,
/// and a wall.
struct Block {
    faces: [[DVec2; 2]; 3],
}

impl Block {
    /// With the front's end so far right.
    fn new(end: f64) -> Self {
        let at = DVec2::new;
        Self {
            faces: [
                [at(-1.0, 4.0), at(end, 4.0)],
                [at(end, 4.0), at(end + 1.6, 8.0)],
                [at(-30.0, 12.0), at(30.0, 12.0)],
            ],
        }
    }

    fn triangles(&self, eye: DVec3) -> Vec<[[f32; 3]; 3]> {
        let upright = |[from, to]: [DVec2; 2]| {
            let low = eye + DVec3::new(from.x, -30.0, -from.y);
            rectangle(low, DVec3::new(to.x - from.x, 0.0, from.y - to.y), DVec3::Y * 60.0)
        };
        self.faces.into_iter().flat_map(upright).collect()
    }

    /// How far a level ray goes.
    fn reach(&self, from: DVec2, towards: DVec2) -> f64 {
        let met = |[a, b]: [DVec2; 2]| {
            let along = b - a;
            let across = towards.perp_dot(along);
            let t = (a - from).perp_dot(along) / across;
            let share = (a - from).perp_dot(towards) / across;
            if t > 0.0 && (0.0..=1.0).contains(&share) { t } else { f64::INFINITY }
        };
        self.faces.into_iter().map(met).fold(f64::INFINITY, f64::min)
    }
}

/// Level rays that pass close before the front, and that come from the right onto front and side near the edge between them.
fn near_edge(end: f64) -> Vec<[DVec2; 2]> {
    let before = (0..20).map(|step| {
        let from = DVec2::new(-0.8, 3.9 - 0.05 * f64::from(step));
        [from, DVec2::X]
    });
    let onto = (0..60).map(|step| {
        let onto = DVec2::new(end, 4.0) + DVec2::new(0.4, 1.0) * 0.02 * f64::from(step);
        let from = DVec2::new(end + 2.0, 2.0 + 0.02 * f64::from(step));
        [from, (onto - from).normalize()]
    });
    before.chain(onto).collect()
}

/// Proves that joined planes end at an edge between two faces: of rays close before the edge, and onto it, more than half of those that
/// pixels' whole squares get wrong are right, wherever in its pixel the edge lies; that those wrong are few; and that of a trace which
/// joins alone neighbours are counted.
#[test]
fn planes_end_at_an_edge() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let (mut wrong, mut all) = ([0; 2], 0);
    for step in 0..12 {
        let end = 0.9 + 0.03 * f64::from(step);
        let block = Block::new(end);
        let geometry = soup(&block.triangles(eye), Some(&gpu));
        let ways = near_edge(end);
        let rays: Vec<Ray> = ways
            .iter()
            .map(|[from, towards]| ray(eye + DVec3::new(from.x, 0.07, -from.y), DVec3::new(towards.x, 0.0, -towards.y)))
            .collect();
        all += rays.len();
        for (wrong, patches) in wrong.iter_mut().zip(["squares", "joined"]) {
            let settings = [&LOSSLESS[..], &JOINED, &[("patches", patches), ("start_bias", "0.1")]].concat();
            let structure = built_by(&tracer, &gpu, &geometry, &settings);
            structure.check(&geometry).unwrap();
            let hits = answer(&gpu, &structure, &rays, &settings, TraceTo::Hit).0;
            let is_wrong = |([from, towards], hit): (&[DVec2; 2], &Hit)| {
                let reach = block.reach(*from, *towards);
                let point = *from + *towards * reach;
                // What lies beside the view is not asked for; a pixel's edge is a thirtieth of the depth.
                let is_seen = point.x.abs() < 0.9 * point.y;
                is_seen && (!hit.is_hit() || (f64::from(hit.t) - reach).abs() > point.y / 30.0)
            };
            *wrong += ways.iter().zip(&hits).filter(|pair| is_wrong((pair.0, pair.1))).count();
            let counters = counted(&gpu, &structure, &rays, &settings);
            let read = counters.iter().any(|counter| counter.name == "neighbours_read");
            assert_eq!(read, patches == "joined");
            assert!(!read || of(&counters, "neighbours_read") >= 4);
        }
    }
    println!("{wrong:?} of {all}");
    assert!(wrong[0] > all / 20 && 2 * wrong[1] < wrong[0] && wrong[1] < all / 20, "{wrong:?} of {all}");
}
