//! The cost by the surface area heuristic that hierarchies report, against what random lines find.

use std::sync::Arc;

use tracebench_api::glam::DVec3;
use tracebench_api::{
    Domain, Geometry, Gpu, HitBuffer, ParameterScope, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency,
    Structure, TraceJob, TraceTo, TracerError,
};
use tracebench_harness::registry::TRACERS;
use tracebench_tests::{Numbers, available, gpu, ray, viewpoint};

/// Lines that meet the root.
const LINES: usize = 20_000;

/// Needles of no area, which nothing hits but whose boxes are like those of triangles: searches over them are never
/// shortened by a hit, as the heuristic assumes.
fn needles(numbers: &mut Numbers, gpu: &Gpu) -> Geometry {
    let mut positions = Vec::new();
    for _ in 0..3000 {
        let from = numbers.point() * DVec3::new(6.0, 2.0, 3.0);
        let along = numbers.direction() * (0.02 + 0.6 * numbers.unit().powi(3));
        positions.extend([from, from + along, from + along].map(|corner| corner.as_vec3().to_array()));
    }
    let triangles = (0..positions.len() as u32 / 3).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    Geometry::new(positions, triangles, Some(gpu)).unwrap()
}

/// Lines evenly spread over all that meet the bounds: through the bounding sphere's discs, in any direction.
fn lines(geometry: &Geometry, numbers: &mut Numbers) -> Vec<Ray> {
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    let (centre, radius) = ((low + high) / 2.0, (high - low).length() / 2.0);
    let mut found = Vec::new();
    while found.len() < LINES {
        let direction = numbers.direction();
        let right = direction.any_orthonormal_vector();
        let (x, y) = (numbers.signed(), numbers.signed());
        if x * x + y * y > 1.0 {
            continue;
        }
        let origin = centre + (right * x + direction.cross(right) * y) * radius - direction * (2.0 * radius);
        let (a, b) = ((low - origin) / direction, (high - origin) / direction);
        if a.min(b).max_element() <= a.max(b).min_element() {
            found.push(ray(origin, direction));
        }
    }
    found
}

/// A tracer over the needles, with a value of one of its parameters.
struct Subject {
    name: String,
    structure: Box<dyn Structure>,
    parameters: Parameters,
    residency: Residency,
    /// The cost that it reports.
    reported: f64,
}

/// Every tracer of the registry that reports a cost, with every named value that shapes its structure.
fn subjects(geometry: &Geometry, gpu: &Arc<Gpu>) -> Vec<Subject> {
    let view = viewpoint([0.0, 0.0, 9.0].into(), [0.0; 3].into(), 0.01, 20.0, [8, 8]);
    let mut subjects = Vec::new();
    for registration in TRACERS {
        let description = registration.describe();
        let Some(tracer) = available(description.name, registration.create(&Ok(Arc::clone(gpu))), gpu) else {
            continue;
        };
        let published = Parameters::preset(&description.parameters, Preset::Published);
        let mut variants = vec![(description.name.to_owned(), published.clone())];
        for each in description.parameters.iter().filter(|each| each.scope == ParameterScope::Build) {
            let Domain::Choice(values) = each.domain else { continue };
            for value in values {
                let mut parameters = published.clone();
                parameters.set(&description.parameters, each.name, value).unwrap();
                variants.push((format!("{} {}={value}", description.name, each.name), parameters));
            }
        }
        for (name, parameters) in variants {
            let mut clock = PhaseClock::new(Some(gpu));
            let structure = match tracer.build(geometry, &view, &parameters, &mut clock) {
                // What binds more at once than the device's limits allow.
                Err(TracerError::Unavailable(_)) if parameters != published => continue,
                built => built.unwrap(),
            };
            clock.finish().unwrap();
            let statistics = structure.validate(geometry).unwrap();
            let Some((_, reported)) = statistics.iter().find(|(name, _)| *name == "sah_cost") else { continue };
            for wanted in ["nodes", "depth", "references"] {
                assert!(statistics.iter().any(|(name, value)| *name == wanted && *value >= 1.0), "{name}: {wanted}");
            }
            let (reported, residency) = (*reported, description.residency);
            subjects.push(Subject { name, structure, parameters, residency, reported });
        }
    }
    subjects
}

impl Subject {
    /// The mean of visits and tests over lines.
    fn counted(&self, lines: &RayBuffer, gpu: &Gpu) -> f64 {
        let mut hits = HitBuffer::new(lines.host.len(), self.residency, Some(gpu)).unwrap();
        let job = TraceJob { rays: lines, trace_to: TraceTo::Hit, parameters: &self.parameters };
        let counters = self.structure.trace_counted(job, &mut hits).unwrap();
        assert!(hits.read(Some(gpu)).unwrap().iter().all(|hit| !hit.is_hit()), "{}: a needle was hit", self.name);
        let counted = counters.iter().filter(|counter| ["nodes_visited", "triangle_tests"].contains(&counter.name));
        counted.map(|counter| counter.total as f64).sum::<f64>() / lines.host.len() as f64
    }
}

/// Proves that the reported cost is the number of node visits and triangle tests that random lines through the root take,
/// by the counters of the searches themselves, for wide and binary nodes, with split triangles and without. Stored boxes
/// are rounded outward, so the root is a little larger than the bounds that the lines are aimed at. Negative control: lines
/// that all pass near the middle, which are not evenly spread, take more.
#[test]
fn costs_are_what_random_lines_take() {
    let gpu = gpu();
    let mut numbers = Numbers::new(90);
    let geometry = needles(&mut numbers, &gpu);
    let spread = RayBuffer::new(Arc::new(lines(&geometry, &mut numbers)), Query::Closest, Some(&gpu));
    let middle = (0..LINES).map(|_| {
        let direction = numbers.direction();
        ray(numbers.point() * 0.2 - direction * 12.0, direction)
    });
    let middle = RayBuffer::new(Arc::new(middle.collect()), Query::Closest, Some(&gpu));
    let subjects = subjects(&geometry, &gpu);
    assert!(subjects.len() >= 8, "{} subjects", subjects.len());
    for subject in subjects {
        let (name, reported) = (&subject.name, subject.reported);
        let counted = subject.counted(&spread, &gpu);
        assert!((counted / reported - 1.0).abs() < 0.04, "{name}: {reported} reported, {counted} counted");
        let uneven = subject.counted(&middle, &gpu);
        assert!((uneven / reported - 1.0).abs() > 0.2, "{name}: {reported} reported, {uneven} counted");
    }
}
