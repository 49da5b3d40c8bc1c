//! Pixels whose planes end at those beside them, in f64. Trees are lossless: no plane stands for others.

use tracebench_api::glam::DVec2;

use super::{Asked, Leaf, NOWHERE, Reference, Track};
use crate::nodes::{Plane, STEPS};

/// A ray's way through a pixel: its places, whether it just touches a corner, whether it comes out of a volume, and where it left the
/// pixel before close before what is shown there, and whether that is decided.
pub(super) struct Passed {
    pub(super) entry: f64,
    pub(super) exit: f64,
    pub(super) touched: bool,
    pub(super) out_of_volume: bool,
    pub(super) before: (f64, bool),
}

/// What comes of it where planes are joined.
pub(super) struct Joined {
    pub(super) hit: Option<(f64, Plane, DVec2)>,
    /// Whether it enters behind all by more than it must be to lie in the volume.
    pub(super) is_behind: bool,
    pub(super) before_until: (f64, bool),
    pub(super) decided: bool,
}

impl Reference<'_> {
    /// A pixel's own plane with its middle, and that beside it at which it ends: of several that before which it gets most; and whether it
    /// is decided which that is.
    pub(super) fn joined(&self, image: usize, leaf: &Leaf) -> (Vec<(Plane, DVec2)>, bool) {
        let [width, height] = self.structure.shape.size().map(f64::from);
        let (own, middle) = (leaf.plane, (leaf.low + leaf.high) / 2.0);
        let (mut all, mut decided, mut most) = (vec![(own, middle)], true, 0.0);
        if !self.structure.shape.is_joined || !own.flagged || leaf.high.x - leaf.low.x > 1.0 {
            return (all, decided);
        }
        for step in STEPS.map(|[x, y]| DVec2::new(f64::from(x), f64::from(y))) {
            let at = leaf.low + step;
            if at.min_element() < 0.0 || at.x >= width || at.y >= height {
                continue;
            }
            let Some(beside) = self.planes[image][(at.y * width + at.x) as usize] else { continue };
            let [theirs, ours] = [own.z_at(step) - beside.z, beside.z_at(-step) - own.z];
            // Where the neighbour's centre lies on this plane both meet there, out of this pixel; and one plane ends nowhere.
            let turned = 0.5 * (own.slope - beside.slope).abs().element_sum();
            let noise = self.noise(own.z, &beside);
            decided &= ours.abs() > noise || theirs < -self.noise(own.z, &own) || turned < noise;
            let before = own.z_at(0.5 * step) - beside.z_at(-0.5 * step);
            if theirs > 0.0 && ours > 0.0 && before > 0.0 {
                decided &= (before - most).abs() > noise || turned < noise;
                if before > most {
                    (most, all) = (before, vec![(own, middle), (beside, middle + step)]);
                }
            }
        }
        (all, decided)
    }

    /// What a ray meets in a pixel whose plane ends at those beside it: it is behind what is shown where it is behind all.
    pub(super) fn pass_joined(
        &self,
        patches: &[(Plane, DVec2)],
        track: &Track,
        asked: &Asked,
        passed: &Passed,
    ) -> Joined {
        let mut decided = true;
        let Passed { entry, exit, .. } = *passed;
        let behind =
            |(plane, middle): &(Plane, DVec2), place: f64| plane.z_at(track.at(place) - *middle) - track.z(place);
        let ends: Vec<[f64; 2]> = patches.iter().map(|patch| [entry, exit].map(|place| behind(patch, place))).collect();
        let depth = track.z(entry).max(track.z(exit));
        let noise = patches.iter().map(|(plane, _)| self.noise(depth, plane)).fold(0.0, f64::max);
        let close = |value: f64| value.abs() < noise;
        decided &= !ends.iter().flatten().any(|end| close(*end));
        let least = |end: usize| ends.iter().map(|ends| ends[end]).fold(f64::INFINITY, f64::min);
        let [at_entry, at_exit] = [least(0), least(1)];
        let root = |ends: &[f64; 2]| entry + (exit - entry) * ends[0] / (ends[0] - ends[1]);
        let (mut enters, mut leaves) = ((-1.0, 0), (NOWHERE, 0));
        for (index, ends) in ends.iter().enumerate() {
            match ends.map(|end| end > 0.0) {
                [false, false] => enters = (NOWHERE, index),
                [false, true] if root(ends) > enters.0 => enters = (root(ends), index),
                [true, false] if root(ends) < leaves.0 => leaves = (root(ends), index),
                _ => {}
            }
        }
        let tolerances = [entry, exit].map(|place| self.z_of_pixels(track.z(place), asked.occlusion_bias));
        let is_before = (-tolerances[1]..=0.0).contains(&at_exit);
        let before_until = (
            if is_before { exit } else { -1.0 },
            !passed.touched && !close(at_exit) && !close(at_exit + tolerances[1]),
        );
        let was_before = entry <= track.later(passed.before.0, 0.01);
        let of = |(place, index): (f64, usize)| Some((place, patches[index].0, patches[index].1));
        let mut told = Joined { hit: None, is_behind: false, before_until, decided };
        if at_entry <= 0.0 {
            if enters.0 < leaves.0 {
                told.hit = of(enters);
            }
            // Behind all for a short part of the way alone, or for nothing.
            let short = (enters.0 - leaves.0).abs() < 0.05 * (exit - entry).max(1e-9);
            told.decided &= !(enters.0 < NOWHERE && leaves.0 < NOWHERE && short);
        } else if at_entry <= tolerances[0] {
            told.decided &= !close(at_entry - tolerances[0]);
            if was_before && at_exit > at_entry {
                let foremost = (0..ends.len()).min_by(|a, b| ends[*a][0].total_cmp(&ends[*b][0])).unwrap_or(0);
                told.hit = of((entry, foremost));
            } else if passed.out_of_volume && at_exit < 0.0 {
                told.hit = of(leaves);
            }
            told.decided &= passed.before.1 && !(was_before && close(at_exit - at_entry));
        } else {
            told.decided &= !close(at_entry - tolerances[0]);
            told.is_behind = true;
            if at_exit < 0.0 {
                told.hit = of(leaves);
            }
        }
        told
    }
}
