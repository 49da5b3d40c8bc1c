//! Rays that were chosen on the device: how many they are only the device knows.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{
    Gpu, Hit, HitBuffer, Parameters, PhaseClock, Query, Ray, RayBuffer, Residency, Structure, TraceJob, TraceTo,
};
use tracebench_harness::registry::TRACERS;
use tracebench_harness::results::RAYS_PER_LANE;

use super::hostile::{Subject, small_scenes, subjects};

/// A ray that ends before it begins, from where another goes.
fn dead(ray: &Ray) -> Ray {
    Ray { t_min: 1.0, t_max: 0.0, ..*ray }
}

/// Workgroups of so many rays, for every number of rays a lane; few, so that they fill one row.
fn workgroups(gpu: &Gpu, count: usize) -> Buffer {
    let words: Vec<u32> = (1..=256).flat_map(|per_lane| [count.div_ceil(64 * per_lane) as u32, 1, 1]).collect();
    gpu.buffer_with("workgroups", bytemuck::cast_slice(&words), BufferUsages::INDIRECT, "nothing").unwrap()
}

/// The first rays, and dead ones behind them.
fn chosen(gpu: &Gpu, rays: &RayBuffer, count: usize, told: bool) -> RayBuffer {
    let records: Vec<Ray> =
        rays.host.iter().enumerate().map(|(index, ray)| if index < count { *ray } else { dead(ray) }).collect();
    let buffer = gpu.buffer_with("chosen", bytemuck::cast_slice(&records), BufferUsages::STORAGE, "nothing").unwrap();
    rays.chosen(buffer, told.then(|| workgroups(gpu, count)))
}

/// Hits and surfaces as bytes, a ray after the other.
fn traced(
    subject: &Subject,
    structure: &dyn Structure,
    rays: &RayBuffer,
    parameters: &Parameters,
    trace_to: TraceTo,
) -> Vec<(Hit, Vec<u8>)> {
    let gpu = &*subject.gpu;
    let mut hits = HitBuffer::tracing_to(trace_to, rays.host.len(), Residency::Device, Some(gpu)).unwrap();
    hits.poison(Some(gpu)).unwrap();
    let mut clock = PhaseClock::new(Some(gpu));
    structure.trace(TraceJob { rays, trace_to, parameters }, &mut hits, &mut clock).unwrap();
    clock.finish().unwrap();
    let surfaces = hits.read_surfaces(Some(gpu)).unwrap();
    let bytes = |index: usize, hit: &Hit| {
        let surface = surfaces.get(index).map_or(&[][..], |surface| bytemuck::bytes_of(surface));
        [bytemuck::bytes_of(hit), surface].concat()
    };
    hits.read(Some(gpu)).unwrap().iter().enumerate().map(|(index, hit)| (*hit, bytes(index, hit))).collect()
}

/// Rays that are answered otherwise than where all are asked, and dead ones that hit.
fn wrong(all: &[(Hit, Vec<u8>)], answers: &[(Hit, Vec<u8>)], count: usize) -> usize {
    let differ = (0..count).filter(|index| all[*index].1 != answers[*index].1).count();
    differ + answers[count..].iter().filter(|(hit, _)| hit.is_hit()).count()
}

/// Proves of every tracer on the device that rays which end before they begin hit nothing, whatever lies round them, and that the rays
/// before them are answered as among all, to the bit: by as many workgroups as the device is told, and by all.
#[test]
fn only_chosen_rays_are_answered() {
    let scenes = small_scenes();
    let scenes: Vec<_> = scenes.iter().filter(|scene| ["room", "needles"].contains(&scene.name)).collect();
    let (mut hit, mut compared) = (0, 0);
    for subject in subjects().iter().filter(|subject| subject.residency == Residency::Device) {
        let registration = TRACERS.iter().find(|each| each.describe().name == subject.name).unwrap();
        let described = registration.describe();
        let trace_to = described.ends.last().copied().unwrap();
        let (gpu, context) = (&*subject.gpu, format!("{} {:?}", subject.name, subject.preset));
        for scene in &scenes {
            let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
            for (query, per_lane) in [(Query::Closest, "1"), (Query::Any, "3"), (Query::Closest, "256")] {
                let mut parameters = subject.parameters.clone();
                let has_lanes = parameters.set(&described.parameters, RAYS_PER_LANE, per_lane).is_ok();
                if per_lane == "256" && !has_lanes {
                    continue;
                }
                let rays = subject.rays(&scene.rays, query);
                let all = traced(subject, &*structure, &rays, &parameters, trace_to);
                hit += all.iter().filter(|(hit, _)| hit.is_hit()).count();
                for (count, told) in
                    [(0, true), (1, true), (64, true), (65, true), (rays.host.len(), true), (100, false)]
                {
                    let some = chosen(gpu, &rays, count, told);
                    let mut answers = traced(subject, &*structure, &some, &parameters, trace_to);
                    assert_eq!(
                        wrong(&all, &answers, count),
                        0,
                        "{context}, {}: {count} {query:?} {per_lane}",
                        scene.name
                    );
                    compared += 1;
                    // Negative controls: a bit that differs, and a dead ray that hits.
                    if (1..100).contains(&count) {
                        answers[0].1[0] ^= 1;
                        answers[count].0 = Hit { status: 1, ..answers[count].0 };
                        assert_eq!(wrong(&all, &answers, count), 2);
                    }
                }
            }
        }
    }
    assert!(hit > 1000 && compared > 100, "{hit} {compared}");
}
