//! The interleaved set of structures that follow an animation.

use tracebench_api::Geometry;

use super::RunError;
use super::interleaved_set::InterleavedSet;
use crate::results::{InterleavedSetRecord, SampleSchedule};

/// What the interleaved set is called.
pub(super) const UPDATES: &str = "updates";

impl InterleavedSet<'_> {
    /// Lets those follow the film who do: one pass to warm up, then the counted ones; every pass begins with fresh builds over
    /// the first frame, outside of the times. A round is a frame.
    pub(super) fn follow(&mut self, passes: u32) -> Result<Option<InterleavedSetRecord>, RunError> {
        let Some(film) = self.film else { return Ok(None) };
        let followers: Vec<usize> = (0..self.slots.len()).filter(|slot| self.slots[*slot].follows.is_some()).collect();
        let gpu = self.session.gpu();
        let (triangles, materials) = (film.triangles.clone(), film.materials.clone());
        let mut geometry = Geometry::with_materials(film.positions[0].clone(), triangles, materials, gpu)?;
        let steps = film.positions.len() as u64 * followers.len() as u64;
        let bar = self.progress.bar(UPDATES, steps * (u64::from(passes) + 1));
        let frames = film.positions.len().saturating_sub(1);
        let sampling = SampleSchedule { min_rounds: passes * frames as u32, adaptive: None };
        let seed = self.order_seed(UPDATES, 0);
        let sampling = (self.options.timed && passes > 0).then_some(sampling);
        let mut rounds = self.rounds(seed, followers.len(), followers.iter().copied(), sampling);
        for pass in 0..=passes {
            for (frame, positions) in film.positions.iter().enumerate() {
                geometry = geometry.with_positions(positions.clone(), gpu)?;
                let counts = pass > 0 && frame > 0;
                // The first round warms up.
                let round = if counts || (pass, frame) == (0, 0) { rounds.next(gpu, || [Vec::new()])? } else { None };
                let order = round.map_or_else(|| (0..followers.len()).collect(), |round| round.order);
                for place in order {
                    let slot = followers[place];
                    let sample = self.attempt(slot, |one| match (frame, one.follows) {
                        (0, _) | (_, None) => one.config.build(&geometry, &one.viewpoint, gpu).map(Some),
                        (_, Some(update)) => one.config.update(update, &geometry, &one.viewpoint, gpu),
                    });
                    if let Some(sample) = sample.flatten().filter(|_| counts) {
                        self.slots[slot].builds.push_update(sample);
                    }
                    bar.inc(1);
                }
            }
        }
        rounds.next(gpu, || [followers.iter().map(|slot| &self.slots[*slot].builds.steady[..]).collect()])?;
        Ok(self.record(UPDATES, seed, &rounds, followers.iter().map(|slot| self.slot_label(*slot)).collect()))
    }
}
