//! Values over time: keys, and what lies between them.

use glam::DQuat;
use gltf::json::animation::Interpolation;

use super::accessor::{Accessor, Accessors, Kind, partition_point};
use super::nodes::unit;

/// Values at keys.
pub(super) struct Sampler {
    times: Accessor,
    values: Accessor,
    interpolation: Interpolation,
    /// Numbers of a value.
    pub(super) width: usize,
    /// Whether a value is a rotation, of which only the direction counts.
    is_rotation: bool,
}

impl Sampler {
    /// Opens accessors `times` and `values`, the latter of `kind` with `width` numbers a key.
    ///
    /// Times must rise from zero or later, and everything be finite.
    pub(super) fn open(
        accessors: &Accessors<'_>,
        times: usize,
        values: usize,
        interpolation: Interpolation,
        kind: Kind,
        width: usize,
    ) -> Result<Self, String> {
        let times = accessors.open(times, Kind::TIME)?;
        let values = accessors.open(values, kind)?;
        let sampler = Self { times, values, interpolation, width, is_rotation: kind == Kind::ROTATION };
        sampler.check(accessors)?;
        Ok(sampler)
    }

    fn check(&self, accessors: &Accessors<'_>) -> Result<(), String> {
        let keys = self.times.count();
        if keys == 0 {
            return Err("it has no keys".to_owned());
        }
        // Elements of rotations and vectors have the width of the value, those of morph weights one number.
        let numbers = self.values.numbers();
        let wanted = self.width.checked_mul(self.parts()).and_then(|each| each.checked_mul(keys));
        if numbers != wanted || wanted.is_none() {
            let found = self.values.count();
            return Err(format!("it has {keys} keys and {found} values, and these do not go together"));
        }
        accessors.charge(keys as u64)?;
        accessors.charge(numbers.unwrap_or(0) as u64)?;
        let mut previous = -1.0;
        for key in 0..keys {
            let time = self.times.value(key);
            if !time.is_finite() || time < 0.0 {
                return Err(format!("key {key} is at {time} s, and times are finite and not negative"));
            }
            if time <= previous {
                return Err(format!("key {key} is at {time} s, not later than the one before it at {previous} s"));
            }
            previous = time;
        }
        for number in 0..numbers.unwrap_or(0) {
            let value = self.values.value(number);
            if !value.is_finite() {
                return Err(format!("number {number} of its values is {value}, which is not finite"));
            }
        }
        Ok(())
    }

    /// Time of the last key in seconds.
    pub(super) fn end_s(&self) -> f64 {
        self.times.value(self.times.count().saturating_sub(1))
    }

    /// The value at a time in seconds: before the first key that of the first, after the last that of the last. A
    /// rotation has unit length; where its numbers are all zero it is none.
    pub(super) fn at(&self, time_s: f64) -> Vec<f64> {
        let keys = self.times.count();
        let next = partition_point(keys, |key| self.times.value(key) <= time_s);
        let mut value = if next == 0 || next == keys || self.interpolation == Interpolation::Step {
            self.key(next.saturating_sub(1))
        } else if self.interpolation == Interpolation::CubicSpline {
            self.spline(next - 1, time_s)
        } else if self.is_rotation {
            let [from, to] = [next - 1, next].map(|key| rotation(&self.key(key)));
            slerp(from, to, self.share(next - 1, time_s)).to_array().to_vec()
        } else {
            let share = self.share(next - 1, time_s);
            let pairs = self.key(next - 1).into_iter().zip(self.key(next));
            pairs.map(|(from, to)| from * (1.0 - share) + to * share).collect()
        };
        if self.is_rotation {
            value = rotation(&value).to_array().to_vec();
        }
        value
    }

    /// How far a time is from key `from` to the next, in [0, 1].
    fn share(&self, from: usize, time_s: f64) -> f64 {
        let (start, end) = (self.times.value(from), self.times.value(from + 1));
        (time_s - start) / (end - start)
    }

    /// Values that each key has: on a spline between its in-tangent and its out-tangent.
    fn parts(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 }
    }

    /// The value at a key.
    fn key(&self, key: usize) -> Vec<f64> {
        self.part(key, self.parts() / 2)
    }

    /// One of the values that a key has.
    fn part(&self, key: usize, slot: usize) -> Vec<f64> {
        let start = (key * self.parts() + slot) * self.width;
        (start..start + self.width).map(|number| self.values.value(number)).collect()
    }

    /// Cubic Hermite spline from key `from` to the next (glTF 2.0, appendix C.5); tangents are per second.
    fn spline(&self, from: usize, time_s: f64) -> Vec<f64> {
        let span = self.times.value(from + 1) - self.times.value(from);
        let t = self.share(from, time_s);
        let (t2, t3) = (t * t, t * t * t);
        let [start, leave] = [1, 2].map(|part| self.part(from, part));
        let [arrive, end] = [0, 1].map(|part| self.part(from + 1, part));
        (0..self.width)
            .map(|axis| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * start[axis]
                    + span * (t3 - 2.0 * t2 + t) * leave[axis]
                    + (3.0 * t2 - 2.0 * t3) * end[axis]
                    + span * (t3 - t2) * arrive[axis]
            })
            .collect()
    }
}

/// The unit rotation of four numbers; none if they have no direction.
fn rotation(value: &[f64]) -> DQuat {
    match value {
        &[x, y, z, w] => unit(DQuat::from_xyzw(x, y, z, w)).unwrap_or(DQuat::IDENTITY),
        _ => DQuat::IDENTITY,
    }
}

/// Spherical linear interpolation between unit rotations, the shorter way (glTF 2.0, appendix C.4).
fn slerp(from: DQuat, to: DQuat, share: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    // The arc cosine of the dot product loses half of the digits near zero; this does not. glam's own uses the
    // platform's functions, which differ between platforms.
    let angle = 2.0 * libm::atan2((from - to).length(), (from + to).length());
    let sine = libm::sin(angle);
    if sine <= 1e-12 {
        return from * (1.0 - share) + to * share;
    }
    from * (libm::sin(angle * (1.0 - share)) / sine) + to * (libm::sin(angle * share) / sine)
}
