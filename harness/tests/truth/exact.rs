//! Ray against triangles without rounding: Möller and Trumbore's determinants in integers, t as a fraction.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};
use tracebench_api::Geometry;
use tracebench_harness::truth::{Ray64, Truth};

/// A vector of integers.
pub type Integers = [i128; 3];

fn minus(a: Integers, b: Integers) -> Integers {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn cross(a: Integers, b: Integers) -> Integers {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Integers, b: Integers) -> i128 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

/// A fraction with a positive denominator.
#[derive(Clone, Copy, Debug)]
pub struct Fraction {
    pub above: i128,
    pub below: i128,
}

impl Fraction {
    pub const ZERO: Self = Self { above: 0, below: 1 };

    pub fn compare(self, other: Self) -> Ordering {
        (self.above * other.below).cmp(&(other.above * self.below))
    }

    /// The nearest f64, where numerator and denominator have at most 53 bits.
    pub fn value(self) -> f64 {
        self.above as f64 / self.below as f64
    }
}

/// A ray whose origin and direction are integers.
#[derive(Clone, Copy, Debug)]
pub struct ExactRay {
    pub origin: Integers,
    pub direction: Integers,
    pub t_min: Fraction,
    /// `None` for a ray without an end.
    pub t_max: Option<Fraction>,
}

impl ExactRay {
    /// From t = 0 without an end.
    pub fn endless(origin: Integers, direction: Integers) -> Self {
        Self { origin, direction, t_min: Fraction::ZERO, t_max: None }
    }

    /// The same ray as the truth takes it.
    pub fn rounded(&self) -> Ray64 {
        let vector = |integers: Integers| DVec3::from(integers.map(|integer| integer as f64));
        Ray64 {
            origin: vector(self.origin),
            direction: vector(self.direction),
            t_min: self.t_min.value(),
            t_max: self.t_max.map_or(f64::INFINITY, Fraction::value),
        }
    }

    /// Whether f64 answers this ray without rounding: the direction's largest component is a power of two, so that the
    /// shear of the truth's triangle test is exact.
    pub fn shears_exactly(&self) -> bool {
        self.direction.iter().map(|component| component.unsigned_abs()).max().is_some_and(u128::is_power_of_two)
    }
}

/// How a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Where within the span, if it does. Edges, corners and the ends of the span count; a triangle seen edge-on, or
    /// without area, does not.
    pub t: Option<Fraction>,
    /// Whether the answer hangs on an exact zero: an edge, a corner, or a plane that holds the ray.
    pub on_the_edge: bool,
    /// Whether it hangs on an end of the span.
    pub at_an_end: bool,
}

pub fn meet(ray: &ExactRay, [a, b, c]: [Integers; 3]) -> Meeting {
    let (first, second, offset) = (minus(b, a), minus(c, a), minus(ray.origin, a));
    let normal = cross(ray.direction, second);
    let determinant = dot(first, normal);
    if determinant == 0 {
        return Meeting { t: None, on_the_edge: true, at_an_end: false };
    }
    let sign = determinant.signum();
    let across = cross(offset, first);
    let below = determinant * sign;
    let (u, v, above) = (dot(offset, normal) * sign, dot(ray.direction, across) * sign, dot(second, across) * sign);
    let t = Fraction { above, below };
    let (after, before) = (t.compare(ray.t_min), ray.t_max.map_or(Ordering::Less, |end| t.compare(end)));
    let hit = u >= 0 && v >= 0 && u + v <= below && after.is_ge() && before.is_le();
    Meeting {
        t: hit.then_some(t),
        on_the_edge: u == 0 || v == 0 || u + v == below,
        at_an_end: after.is_eq() || before.is_eq(),
    }
}

/// Triangles whose corners are integers.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub triangles: Vec<[Integers; 3]>,
}

impl Scene {
    /// As the truth takes it; every triangle has vertices of its own.
    pub fn truth(&self) -> Truth {
        let positions = self.triangles.as_flattened().iter().map(|corner| {
            let rounded = corner.map(|integer| integer as f32);
            assert!(rounded.iter().zip(corner).all(|(f, i)| *f as i128 == *i), "{corner:?} is not exact in f32");
            rounded
        });
        let indices = (0..self.triangles.len() as u32).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]);
        Truth::new(&Geometry::new(positions.collect(), indices.collect(), None).unwrap(), "exact")
    }

    /// The nearest hit; of several at equal t the lowest triangle.
    pub fn closest(&self, ray: &ExactRay) -> Closest {
        let mut closest = Closest { hit: None, on_an_edge: false, at_an_end: false, at_equal_t: false };
        for (triangle, primitive) in self.triangles.iter().zip(0..) {
            let meeting = meet(ray, *triangle);
            closest.on_an_edge |= meeting.on_the_edge;
            closest.at_an_end |= meeting.at_an_end;
            let Some(t) = meeting.t else { continue };
            match closest.hit.map(|(least, _)| t.compare(least)) {
                None | Some(Ordering::Less) => closest.hit = Some((t, primitive)),
                Some(Ordering::Equal) => closest.at_equal_t = true,
                Some(Ordering::Greater) => {}
            }
        }
        closest
    }
}

/// The nearest hit, and what of the scene makes it hang on exact zeros.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Where, and which triangle.
    pub hit: Option<(Fraction, u32)>,
    /// Some triangle is met on an edge, or holds the ray in its plane.
    pub on_an_edge: bool,
    /// Some triangle is met at an end of the span.
    pub at_an_end: bool,
    /// Several triangles are met at equal t.
    pub at_equal_t: bool,
}

/// Small integers that are the same on every machine (a linear congruence, high bits).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn below(&mut self, count: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % count
    }

    /// An integer in [-most, most].
    pub fn within(&mut self, most: i128) -> i128 {
        i128::from(self.below(2 * most as u64 + 1)) - most
    }

    pub fn vector(&mut self, most: i128) -> Integers {
        std::array::from_fn(|_| self.within(most))
    }

    pub fn triangle(&mut self, most: i128) -> [Integers; 3] {
        std::array::from_fn(|_| self.vector(most))
    }

    /// Not zero.
    pub fn direction(&mut self, most: i128) -> Integers {
        loop {
            let direction = self.vector(most);
            if direction != [0; 3] {
                return direction;
            }
        }
    }

    /// A direction whose largest component is a power of two.
    pub fn exact_direction(&mut self) -> Integers {
        let largest = 1 << self.below(4);
        let mut direction = self.vector(largest);
        let axis = self.below(3) as usize;
        direction[axis] = if self.below(2) == 0 { largest } else { -largest };
        direction
    }
}

/// A closed surface round the origin: an octahedron of `radius`, divided `levels` times, pushed out to a sphere,
/// rounded to integers and stretched along the axes.
pub fn sphere(radius: f64, levels: usize, stretch: Integers) -> Scene {
    let axis = |axis: usize, sign: f64| {
        let mut point = DVec3::ZERO;
        point[axis] = sign;
        point
    };
    let mut faces: Vec<[DVec3; 3]> = Vec::new();
    for (x, y, z) in (0..8).map(|corner| (corner & 1, corner >> 1 & 1, corner >> 2)) {
        let sign = |bit: i32| 1.0 - 2.0 * f64::from(bit);
        faces.push([axis(0, sign(x)), axis(1, sign(y)), axis(2, sign(z))]);
    }
    for _ in 0..levels {
        let divide = |&[a, b, c]: &[DVec3; 3]| {
            let middle = |p: DVec3, q: DVec3| (p + q).normalize();
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(divide).collect();
    }
    let round = |point: DVec3| {
        let scaled = (point * radius).round().to_array();
        std::array::from_fn(|axis| scaled[axis] as i128 * stretch[axis])
    };
    Scene { triangles: faces.iter().map(|face| face.map(round)).collect() }
}

/// A corner as f32, for comparisons with single triangles.
pub fn as_f32(corner: Integers) -> Vec3 {
    Vec3::from(corner.map(|integer| integer as f32))
}
