//! How long a paper's table would take, told by rows that were measured.

use itertools::Itertools as _;
use serde_json::{Value, json};

use crate::plan::{Plan, SceneSource, TracerRequest};
use crate::results::{MEMORY_ACCESS, RAYS_PER_LANE, Record, Row, host_ms};

/// Seconds of an hour.
const HOUR: f64 = 3600.0;
const MINUTE: f64 = 60.0;

/// The time that builds and traces of plans take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Duration {
    /// Rows of the plans.
    pub rows: usize,
    /// Rows of which a like one was measured; the others are taken to take as long as these on the mean.
    pub known: usize,
    /// Rounds, with the one to warm up.
    pub rounds: usize,
    /// Seconds of all builds of the known rows.
    pub builds_s: f64,
    /// Seconds of all traces of the known rows.
    pub traces_s: f64,
}

impl Duration {
    /// By the rows of a run of the same scene, tracer and parameters, at the scale and the resolution nearest to the wanted ones; of rows
    /// that differ in launch settings alone those of the wanted ones where there are such, as a run takes the machine's. Builds are taken
    /// to grow with the pixels of a face, traces with the rays; several rays a pixel count as such.
    pub fn of(plans: &[Plan], record: &Record) -> Self {
        let mut sum = Self {
            rounds: plans.first().map_or(0, |plan| plan.preset.sampling.min_rounds as usize + 1),
            ..Self::default()
        };
        for plan in plans {
            for (source, request) in plan.scenes.iter().cartesian_product(&plan.tracers) {
                sum.rows += 1;
                if let Some([build_s, trace_s]) = of_row(plan, source, request, record) {
                    sum.known += 1;
                    sum.builds_s += build_s * sum.rounds as f64;
                    sum.traces_s += trace_s * sum.rounds as f64;
                }
            }
        }
        sum
    }

    /// In words.
    pub fn describe(&self, table: &str) -> String {
        if self.known == 0 {
            return format!("{table}: the record has none of the {} rows; measure some of them first", self.rows);
        }
        let factor = self.rows as f64 / self.known as f64;
        let time = |seconds: f64| match seconds < HOUR {
            true => format!("{:.0} min", (seconds / MINUTE).ceil()),
            false => format!("{:.1} h", seconds / HOUR),
        };
        format!(
            "{table}: about {} for {} rounds, the first to warm up, of {} rows (builds {}, traces {}), by {} rows that were measured; controls, ground truth \
             and judging come on top",
            time(factor * (self.builds_s + self.traces_s)),
            self.rounds,
            self.rows,
            time(factor * self.builds_s),
            time(factor * self.traces_s),
            self.known,
        )
    }
}

fn pixels(size: [u32; 2]) -> f64 {
    size.map(f64::from).iter().product()
}

/// Seconds of a build and of a trace of every set.
fn of_row(plan: &Plan, source: &SceneSource, request: &TracerRequest, record: &Record) -> Option<[f64; 2]> {
    let SceneSource::Catalogue(scene) = source else { return None };
    let wanted = json!(request.parameters);
    let is_of_launch = |name: &str| [MEMORY_ACCESS, RAYS_PER_LANE].contains(&name);
    // A parameter that came after the record is not in it.
    let as_wanted = |(name, value): (&String, &Value)| is_of_launch(name) || wanted[name] == *value;
    let alike = |row: &&Row| {
        row.scene.name == *scene && row.tracer.name == request.name() && row.tracer.parameters.iter().all(as_wanted)
    };
    let (rays, face) = (pixels(plan.preset.ray_image), pixels([plan.preset.face; 2]));
    let far = |row: &Row| (pixels(row.viewpoint.ray_image) / rays).ln().abs();
    let other_launch =
        |row: &Row| row.tracer.parameters.iter().any(|(name, value)| is_of_launch(name) && wanted[name] != *value);
    let other_scale = |row: &Row| (row.scene.scale.unwrap_or(1.0) / plan.preset.scene_scale).ln().abs();
    // Numbers of at least 0 are in the order of their bits.
    let distance = |row: &&Row| (other_scale(row).to_bits(), other_launch(row), far(row).to_bits());
    let row = record.rows.iter().filter(alike).min_by_key(distance)?;
    // Every round builds first, and then once more. The one build of what is about traces alone is left out: its records do not time it.
    let builds = || Some(host_ms(row.build.first())? + host_ms(row.build.steady())?);
    let build = if plan.builds_timed { builds()? * face / pixels([row.viewpoint.face; 2]) } else { 0.0 };
    let mut said = record.ray_parameters.clone();
    said.extend(row.viewpoint.ray_parameters.clone());
    let (own, theirs) = (json!(plan.ray_parameters), json!(said));
    let mut traces = 0.0;
    for set in &plan.ray_sets {
        let trace = row.traces.iter().find(|trace| trace.rays == set.name)?;
        // Rays a pixel of sets that have several.
        let several = |values: &Value| {
            let counts = set.parameters.iter().filter(|name| name.ends_with("_count"));
            counts.map(|name| values[name].as_f64().unwrap_or(1.0)).product::<f64>()
        };
        let more = rays / pixels(row.viewpoint.ray_image) * several(&own) / several(&theirs);
        traces += host_ms(&trace.times)? * more;
    }
    Some([build / 1e3, traces / 1e3])
}

#[cfg(test)]
mod tests {
    use tracebench_api::{Query, TraceTo};

    use super::*;
    use crate::papers::fixture::{config, run_of, set_build, set_time};
    use crate::plan::{RUN_PRESETS, RunPreset, ViewRequest};
    use crate::rays::{RAY_SETS, default_parameters};
    use crate::registry;
    use crate::results::SampleSchedule;

    /// A measured row is taken to the wanted rays, faces and rounds; rows that were not measured count as the others do, and a run
    /// without any tells nothing.
    #[test]
    fn measured_rows_tell_the_time() {
        let request = TracerRequest::of(registry::find("dirt").unwrap(), tracebench_api::Preset::Published);
        let parameters = json!(request.parameters);
        let mut row = config("dirt", "room", parameters, &[], &[("pixel-random", Query::Closest)]);
        (row.viewpoint.ray_image, row.viewpoint.face) = ([100, 50], 64);
        set_build(&mut row, 100.0);
        set_time(&mut row, "pixel-random", 1000.0);
        let mut record = run_of(vec![row]);
        record.ray_parameters.insert("pixel_random_count".to_owned(), json!(5));
        let mut ray_parameters = default_parameters();
        ray_parameters.set(&crate::rays::ray_parameters(), "pixel_random_count", "20").unwrap();
        let plan = Plan {
            scenes: ["room", "candy"].map(|name| SceneSource::Catalogue(name.to_owned())).to_vec(),
            tracers: vec![request],
            ray_sets: RAY_SETS.iter().filter(|set| set.name == "pixel-random").copied().collect(),
            ray_parameters,
            preset: RunPreset {
                ray_image: [200, 50],
                face: 128,
                sampling: SampleSchedule::rounds(12),
                ..RUN_PRESETS[1]
            },
            view: ViewRequest::Default,
            time_s: 0.0,
            seed: 1,
            trace_to: TraceTo::Hit,
            builds_timed: true,
            wrong_rays_per_cause: crate::judge::WRONG_RAYS_PER_CAUSE,
            table: None,
        };
        let found = Duration::of(std::slice::from_ref(&plan), &record);
        assert_eq!((found.rows, found.known, found.rounds), (2, 1, 13));
        // Of a round a first build and a steady one.
        assert!(
            (found.builds_s - 13.0 * (0.4 + 0.4)).abs() < 1e-9 && (found.traces_s - 13.0 * 8.0).abs() < 1e-9,
            "{found:?}"
        );
        assert!(
            found.describe("t").contains("about 4 min for 13 rounds, the first to warm up, of 2 rows"),
            "{}",
            found.describe("t")
        );
        // Where builds are not timed a record without their times tells as much.
        let (alone, mut untimed) = (Plan { builds_timed: false, ..plan.clone() }, record.clone());
        for times in untimed.rows.iter_mut().flat_map(|row| row.build.all_mut()) {
            (times.clock, times.submit_to_done_median_ms) = (tracebench_api::ClockKind::Host, None);
            times.samples_ms.clear();
        }
        let of_untimed = |plan: &Plan| Duration::of(std::slice::from_ref(plan), &untimed);
        assert_eq!((of_untimed(&plan).known, of_untimed(&alone)), (0, Duration { builds_s: 0.0, ..found }));
        // What the machine's launch settings make of a row's parameters tells no row apart.
        record.rows[0].tracer.parameters.insert(MEMORY_ACCESS.to_owned(), json!("texture"));
        record.rows[0].tracer.parameters.insert(RAYS_PER_LANE.to_owned(), json!(32));
        assert_eq!(Duration::of(std::slice::from_ref(&plan), &record), found);
        record.rows[0].tracer.parameters.remove("max_steps").unwrap();
        assert_eq!(Duration::of(std::slice::from_ref(&plan), &record).known, 1);
        record.rows[0].tracer.parameters.insert("tile_size".to_owned(), json!(8));
        assert_eq!(Duration::of(std::slice::from_ref(&plan), &record).known, 0);
        record.rows[0].tracer.parameters.insert("tile_size".to_owned(), json!(1));
        record.rows[0].scene.name = "barn".to_owned();
        assert!(Duration::of(&[plan], &record).describe("t").contains("none of the 2 rows"));
    }
}
