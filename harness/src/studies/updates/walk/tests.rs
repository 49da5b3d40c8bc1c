//! Walks of a tracer that the eye's moves leave valid, and of one that they do not.

use tracebench_api::{
    Counter, Hit, HitBuffer, MemoryReport, Parameters, PhaseClock, Preset, Ray, Status, Structure, TraceJob, TraceTo,
    Tracer, TracerDescription, TracerError, Viewpoint,
};
use tracebench_bvh::BvhCpu;

use super::*;
use crate::measure::Journal;
use crate::peers;
use crate::plan::{RunPreset, SceneSource};
use crate::progress::Progress;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registry::{Family, Registration};
use crate::report;
use crate::results::{Judgement, Row, SampleSchedule};
use crate::studies::updates::{Walker, execute, walkers};
use crate::truth::Cache;

/// `bvh-cpu` that finds nothing but what is seen from the eye that it was built for.
struct Onlooker;

struct Looking {
    built: Box<dyn Structure>,
    eye: Vec3,
}

impl Tracer for Onlooker {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        Ok(Box::new(Looking { built: BvhCpu.build(geometry, viewpoint, parameters, clock)?, eye: viewpoint.eye }))
    }
}

impl Looking {
    fn forget(&self, rays: &[Ray], hits: &mut HitBuffer) -> Result<(), TracerError> {
        for (ray, hit) in rays.iter().zip(hits.host_mut(rays.len())?) {
            if Vec3::from(ray.origin) != self.eye {
                *hit = Hit::miss(Status::LeftViews);
            }
        }
        Ok(())
    }
}

impl Structure for Looking {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        if update == Update::Rebuild {
            self.eye = viewpoint.eye;
        }
        self.built.update(update, geometry, viewpoint, parameters, clock)
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        self.built.trace(job, hits, clock)?;
        self.forget(&job.rays.host, hits)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let counters = self.built.trace_counted(job, hits)?;
        self.forget(&job.rays.host, hits)?;
        Ok(counters)
    }

    fn memory(&self) -> MemoryReport {
        self.built.memory()
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.built.validate(geometry)
    }
}

fn onlooker() -> TracerDescription {
    const BOTH: &[Invalidation] = &[Invalidation::Geometry, Invalidation::Viewpoint];
    let no_refit = Some("it has to look again");
    TracerDescription { name: "onlooker", invalidated_by: BOTH, no_refit, ..tracebench_bvh::description() }
}

/// Two frames after the first, through a scene that stands still and one that moves.
fn frame_scene_sha256() -> Record {
    let bvh = Registration::analytic(tracebench_bvh::description, Family::Bvh, |_| Ok(Box::new(BvhCpu)));
    let onlooker = Registration::sampled(onlooker, Family::Image, |_| Ok(Box::new(Onlooker)));
    let smoke = RunPreset::named("smoke").unwrap();
    let plan = Plan {
        scenes: ["room", "cloth"].map(|name| SceneSource::Catalogue(name.to_owned())).to_vec(),
        tracers: [bvh, onlooker].map(|each| TracerRequest::of(&each, Preset::Published)).to_vec(),
        ray_sets: RAY_SETS[..1].to_vec(),
        ray_parameters: default_parameters(),
        preset: RunPreset { ray_image: [16, 8], sampling: SampleSchedule::rounds(2), ..smoke },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: TraceTo::Hit,
        wrong_rays_per_cause: crate::judge::WRONG_RAYS_PER_CAUSE,
        table: Some("view-updates"),
    };
    let none = Err(TracerError::Unavailable("none is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let table = peers::find("view-updates").unwrap();
    execute(table, &plan, 2, &Context::new(&none, &cache, &quiet, &journal)).unwrap()
}

fn agreement(row: &Row) -> f64 {
    let Judgement::Closest(closest) = &row.traces[0].judgement else { panic!("they are closest hits") };
    closest.agreement.tight.unwrap()
}

fn rows<'a>(record: &'a Record, scene: &str, tracer: &str, update_mode: &str) -> Vec<&'a Row> {
    let is = |row: &&Row| {
        row.scene.name == scene
            && row.tracer.name == tracer
            && row.update_mode.as_ref().is_some_and(|of| of.name == update_mode)
    };
    record.rows.iter().filter(is).collect()
}

/// Proves that every frame has its own rays, the same for all ways; that what is reused where nothing invalidates it answers as what
/// is rebuilt, while what the eye's move invalidates is marked and answers as before (the negative control); that a scene which
/// moves makes stale what the eye does not.
#[test]
fn frames_are_walked_through() {
    let record = frame_scene_sha256();
    let updates = record.updates.as_ref().unwrap();
    assert_eq!((updates.frames, updates.passes, updates.scenes.len()), (2, 2, 2));
    for (scene, moves) in [("room", false), ("cloth", true)] {
        let followed = updates.scenes.iter().find(|each| each.scene == scene).unwrap();
        assert_eq!(followed.frame_scene_sha256.len(), 3);
        assert_eq!(followed.frame_scene_sha256[0] != followed.frame_scene_sha256[1], moves);
        let [reuse, refit, rebuild] =
            ["reuse", "refit", "rebuild"].map(|update_mode| rows(&record, scene, "bvh-cpu", update_mode));
        assert_eq!([reuse.len(), refit.len(), rebuild.len()], [2; 3], "{scene}");
        let fresh = rows(&record, scene, "bvh-cpu", "fresh build");
        let mut rays = vec![&fresh[0].traces[0].rays_sha256];
        for frame in 0..2 {
            let of = |row: &Row| row.traces[0].rays_sha256.clone();
            assert_eq!([of(refit[frame]), of(rebuild[frame])], [of(reuse[frame]), of(reuse[frame])]);
            rays.push(&reuse[frame].traces[0].rays_sha256);
            let hits = |row: &Row| row.traces[0].hits_sha256.clone();
            assert_eq!(hits(refit[frame]), hits(rebuild[frame]), "{scene}");
            assert_eq!(hits(reuse[frame]) == hits(rebuild[frame]), !moves, "{scene}");
            let stale: &[&str] = if moves { &["geometry"] } else { &[] };
            assert_eq!(reuse[frame].update_mode.as_ref().unwrap().stale_by, stale);
            let samples = [reuse[frame], refit[frame], rebuild[frame]].map(|row| row.build.times.samples_ms.len());
            assert_eq!(samples, [0, 2, 2]);
            let whole = |row: &Row| [&row.build.first, &row.build.steady].map(|whole| whole.is_some());
            assert_eq!(
                [reuse[frame], refit[frame], rebuild[frame]].map(whole),
                [[false; 2], [false, true], [false, true]]
            );
            assert!(agreement(rebuild[frame]) > 0.99);
            let [reused, rebuilt] =
                ["reuse", "rebuild"].map(|update_mode| rows(&record, scene, "onlooker", update_mode)[frame]);
            assert!(reused.update_mode.as_ref().unwrap().stale_by.contains(&"viewpoint".to_owned()));
            assert!(rebuilt.update_mode.as_ref().unwrap().stale_by.is_empty());
            assert!(agreement(reused) < 0.5 && agreement(rebuilt) > 0.99, "{scene} {}", agreement(reused));
        }
        rays.sort_unstable();
        rays.dedup();
        assert_eq!(rays.len(), 3, "{scene}: the same rays at two frames");
        assert!(rows(&record, scene, "onlooker", "refit").is_empty());
    }
    let said: Vec<_> = record.skipped.iter().map(|each| (each.tracer.as_deref(), each.reason.as_str())).collect();
    // Once a scene, not once a frame.
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said.iter().all(|(tracer, reason)| *tracer == Some("onlooker (refit)") && reason.contains("look again")));
}

/// Proves that the time of all frames is that of the first build, of the updates that there were, and of the traces, that a frame
/// which could not be measured leaves none, and that the page and the rows show walks, what is stale marked.
#[test]
fn all_frames_are_summed_and_shown() {
    let mut record = frame_scene_sha256();
    let scene = record.updates.as_ref().unwrap().scenes[0].clone();
    let find = |walkers: &[Walker<'_>], tracer: &str, update_mode: &str| -> (f64, Vec<String>) {
        let of = |walker: &&Walker<'_>| {
            walker.update_mode == update_mode && walker.frames[0].unwrap().0.tracer.name == tracer
        };
        let walker = walkers.iter().find(of).unwrap();
        (walker.total().unwrap().ms, walker.stale_by.iter().map(|&change| change.to_owned()).collect())
    };
    let summed = |update_mode: &str, updated: bool| -> f64 {
        let fresh = rows(&record, "room", "bvh-cpu", "fresh build")[0];
        let later = rows(&record, "room", "bvh-cpu", update_mode);
        let update = |row: &Row| if updated { row.build.steady.as_ref().unwrap().median_ms } else { 0.0 };
        let each = later.iter().map(|row| update(row) + row.traces[0].times.median_ms);
        fresh.build.first.as_ref().unwrap().median_ms + fresh.traces[0].times.median_ms + each.sum::<f64>()
    };
    let all = walkers(&record, &scene, "primary");
    assert_eq!(all.len(), 5);
    for (update_mode, updated) in [("reuse", false), ("refit", true), ("rebuild", true)] {
        let (ms, stale) = find(&all, "bvh-cpu", update_mode);
        assert!((ms / summed(update_mode, updated) - 1.0).abs() < 1e-9 && stale.is_empty(), "{update_mode}");
    }
    assert_eq!(find(&all, "onlooker", "reuse").1, ["viewpoint"]);
    let files = report::of_updates(&record).unwrap().contents().unwrap();
    let text = |wanted: &str| {
        let (_, contents) = files.iter().find(|(name, _)| name == wanted).unwrap();
        String::from_utf8(contents.clone()).unwrap()
    };
    let page = text("table_view_updates.md");
    assert!(page.contains("| onlooker | reuse (**stale**: moved viewpoint) |"), "{page}");
    assert!(page.contains("| bvh-cpu | reuse |") && page.contains("| bvh-cpu | reuse (**stale**: moved geometry) |"));
    // Two scenes, five ways, two frames after the first, which ways share.
    let table = text("rows.csv");
    let mut table = csv::Reader::from_reader(table.as_bytes());
    let place = table.headers().unwrap().iter().position(|name| name == "all_frames_ms").unwrap();
    let told: Vec<f64> = table.records().filter_map(|row| row.unwrap()[place].parse().ok()).collect();
    assert_eq!(told.len(), 2 * 5 * 2);
    assert!(told.contains(&find(&all, "bvh-cpu", "refit").0), "{told:?}");
    let lost = record.rows.iter().position(|row| {
        row.scene.name == "room"
            && row
                .update_mode
                .as_ref()
                .is_some_and(|update_mode| update_mode.name == "rebuild" && update_mode.frame_index == Some(1))
    });
    record.rows.remove(lost.unwrap());
    let all = walkers(&record, &scene, "primary");
    let rebuilt = all.iter().find(|walker| walker.update_mode == "rebuild").unwrap();
    assert!(rebuilt.total().is_none() && rebuilt.frames[1].is_none());
}

/// Proves that the camera takes the scene's path from begin to end, and that in a scene without one it goes from its viewpoint to
/// another one.
#[test]
fn cameras_move() {
    let mut scene = tracebench_scenes::procedural("room", 0.05).unwrap();
    let geometry = Geometry::new(scene.mesh.positions.clone(), scene.mesh.triangles.clone(), None).unwrap();
    let path = scene.camera_path.clone().unwrap();
    let along = poses(&scene, &geometry, 4).unwrap();
    let (first, last) = (path.keys[0], path.keys[path.keys.len() - 1]);
    assert_eq!([along[0].eye, along[4].eye], [first.eye, last.eye].map(Vec3::from));
    scene.camera_path = None;
    let across = poses(&scene, &geometry, 4).unwrap();
    let own = Pose::from(&scene.cameras[0]);
    let truth = Truth::new(&geometry, &scene.sha256);
    let other = crate::viewpoint::other(&own, &scene.cameras, &truth).unwrap();
    assert_eq!([across[0].eye, across[4].eye], [own.eye, other.eye]);
    assert!(across[2].eye.distance(own.eye.midpoint(other.eye)) < 1e-6 && across[2].name.contains("0.5"));
}
