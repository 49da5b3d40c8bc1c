//! Where the pixels' centres of a ray image lie beside those of a frame.

/// Parts of a preset's ray image that studies over resolutions trace: of its edges, before [`between_samples`].
pub const BETWEEN_SAMPLES: [u32; 2] = [15, 16];

/// The largest image of at most a part of an image's edges, of which no pixel's centre but the middle one is one of a frame's pixels, at
/// whatever multiple of its resolution by halves, thirds and powers of those.
///
/// Methods that sample a frame are right where rays go through its samples, whatever they do elsewhere. Centres `(2i + 1) / w` and
/// `(2j + 1) / W` are one only where `w` divides `2i + 1` if `w` has no factor in common with `2W`.
#[must_use]
pub fn between_samples(image: [u32; 2], frame: [u32; 2], [part, of]: [u32; 2]) -> [u32; 2] {
    let edge = |image: u32, frame: u32| {
        let most = (u64::from(image) * u64::from(part) / u64::from(of)).max(1) as u32;
        let is_apart = |edge: &u32| common_divisor(u64::from(*edge), 6 * u64::from(frame)) == 1;
        (1..=most).rev().find(is_apart).unwrap_or(1)
    };
    [edge(image[0], frame[0]), edge(image[1], frame[1])]
}

/// The share of an image's pixels whose centres are those of pixels of a frame, both over the same view.
pub fn shared_centres(image: [u32; 2], frame: [u32; 2]) -> f64 {
    let along = |image: u32, frame: u32| {
        let common = common_divisor(u64::from(image), u64::from(frame)).max(1);
        let [own, other] = [u64::from(image) / common, u64::from(frame) / common];
        // (2i + 1) other = (2j + 1) own, which parity forbids or which holds for every own-th pixel.
        if own % 2 == 1 && other % 2 == 1 { 1.0 / own as f64 } else { 0.0 }
    };
    along(image[0], frame[0]) * along(image[1], frame[1])
}

fn common_divisor(one: u64, other: u64) -> u64 {
    if other == 0 { one } else { common_divisor(other, one % other) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::RUN_PRESETS;

    /// The pixels of an image whose centres are those of a frame's pixels, by trying all, along one axis.
    fn shared(edge: u32, frame: u32) -> u64 {
        let (edge, frame) = (u64::from(edge), u64::from(frame));
        let is_shared = |pixel: &u64| {
            let place = (2 * pixel + 1) * frame;
            place.is_multiple_of(edge) && (place / edge) % 2 == 1
        };
        (0..edge).filter(is_shared).count() as u64
    }

    /// Proves, by trying every pixel, that images between samples share no centre but the middle one with frames of any resolution that
    /// studies take, that they are little smaller than asked for, and that the share of shared centres is told rightly; images that
    /// divide frames are found out.
    #[test]
    fn rays_keep_between_samples() {
        let multiples = [(1, 8), (1, 4), (1, 3), (1, 2), (2, 3), (3, 4), (1, 1), (4, 3), (3, 2), (2, 1), (4, 1)];
        let frames = RUN_PRESETS.map(|preset| (preset.ray_image, preset.frame));
        let further = [([256, 128], [501, 251]), ([200, 100], [717, 357]), ([3, 2], [1, 1]), ([1000, 1], [960, 540])];
        let mut found = 0;
        for (image, frame) in frames.into_iter().chain(further) {
            let between = between_samples(image, frame, BETWEEN_SAMPLES);
            assert!(
                between.iter().zip(image).all(|(less, edge)| *less <= edge && (*less * 5 > edge * 4 || edge < 40)),
                "{image:?} {between:?}"
            );
            for (axis, (of, part)) in (0..2).flat_map(|axis| multiples.map(|multiple| (axis, multiple))) {
                if frame[axis] * of % part != 0 {
                    continue;
                }
                let scaled = frame[axis] * of / part;
                let told = shared_centres([image[axis]; 2], [scaled; 2]).sqrt() * f64::from(image[axis]);
                let exact = shared(image[axis], scaled);
                assert!((told - exact as f64).abs() < 1e-6, "{} {scaled}: {told} for {exact}", image[axis]);
                found += u64::from(exact == u64::from(image[axis]));
                assert!(shared(between[axis], scaled) <= 1, "{} {scaled}", between[axis]);
            }
        }
        assert!(found > 5, "{found}");
    }
}
