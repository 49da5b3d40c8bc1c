//! How many iterations clustering takes at most.

/// Iterations that the device has words for: `FINISHED` of shaders/bvh/build.wgsl, less the count that the last one leaves.
const MAX_ITERATIONS: usize = 127;

/// `LAST_CLUSTERS` of shaders/bvh/cluster.wgsl: so many are left to one workgroup.
pub(super) const LAST_CLUSTERS: u32 = 2048;

/// What an iteration may start with falls by this factor from all triangles in the first one. Searches among 8 neighbours on
/// each side leave six in ten of the triangles, then about eight in ten of the clusters each time; among 16 a little more.
const FACTOR: f64 = 0.87;

/// One iteration as the host bounds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bound {
    /// The most clusters that it can start with.
    pub(super) most: u32,
    /// Of more than these, neighbours are paired without a search.
    pub(super) allowed: u32,
}

/// The iterations until few clusters are left, whatever the searches find: one that starts with more clusters than it may
/// leaves half of them, rounded up.
pub(super) fn bounds(triangle_count: u32) -> Vec<Bound> {
    let mut bounds = Vec::new();
    let mut most = triangle_count;
    while most > LAST_CLUSTERS && bounds.len() < MAX_ITERATIONS {
        let allowed = (f64::from(triangle_count) * FACTOR.powi(bounds.len() as i32)) as u32;
        bounds.push(Bound { most, allowed });
        let paired = if most > allowed { most.div_ceil(2) } else { 0 };
        most = most.min(allowed).max(paired);
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However many clusters each search merges, from none to half, what is left never exceeds the next bound, and few are
    /// left at the end, of the most triangles that 32 bits number, too.
    #[test]
    fn bounds_hold_for_every_search() {
        for count in (1..9000).chain([65_535, 100_003, 1 << 25, u32::MAX]) {
            for share in [0.0, 0.1, 0.3, 0.5] {
                let mut clusters = count;
                for bound in &bounds(count) {
                    assert!(clusters <= bound.most, "{count}: {clusters} clusters, {bound:?}");
                    let merged = if clusters > bound.allowed { 0.5 } else { share };
                    clusters -= (f64::from(clusters) * merged) as u32;
                }
                assert!(clusters <= LAST_CLUSTERS.max(1), "{count}: {clusters}");
            }
        }
    }

    /// Negative control: without pairing, searches that merge nothing exceed the bounds.
    #[test]
    fn searches_alone_exceed_bounds() {
        assert!(bounds(100_000).iter().any(|bound| bound.most < 100_000));
    }
}
