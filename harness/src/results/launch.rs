//! How searches on the device read and are launched: what a probe of the adapter said, what a row had, and two methods at equal
//! launch settings and at each one's best.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::{Row, TracerRecord};

/// The parameter that says what a search reads from.
pub const MEMORY_ACCESS: &str = "memory_access";
/// The parameter that says how many rays a lane answers.
pub const RAYS_PER_LANE: &str = "rays_per_lane";

/// How a search reads and is launched.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LaunchSettings {
    /// `buffer` or `texture`.
    pub memory_access: String,
    /// Rays that a lane answers one after the other.
    pub rays_per_lane: u64,
}

impl std::fmt::Display for LaunchSettings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rays = if self.rays_per_lane == 1 { "ray" } else { "rays" };
        write!(f, "{}, {} {rays} a lane", self.memory_access, self.rays_per_lane)
    }
}

impl LaunchSettings {
    /// As arguments and the environment have them.
    pub fn describe(&self) -> String {
        format!("{},{}", self.memory_access, self.rays_per_lane)
    }

    /// The parameters that have them, with their values.
    pub fn values(&self) -> [(&'static str, String); 2] {
        [(MEMORY_ACCESS, self.memory_access.clone()), (RAYS_PER_LANE, self.rays_per_lane.to_string())]
    }

    /// These launch settings.
    pub fn new(memory_access: &str, rays_per_lane: u64) -> Self {
        Self { memory_access: memory_access.to_owned(), rays_per_lane }
    }
}

/// Times of the same work done each way, milliseconds, round by round.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProbeRecord {
    /// Reads at unrelated places, from a buffer.
    pub gather_buffer_ms: Vec<f64>,
    /// The same from a texture.
    pub gather_texture_ms: Vec<f64>,
    /// Loops of different length, a ray a lane.
    pub one_ray_per_lane_ms: Vec<f64>,
    /// The same with many rays a lane.
    pub many_rays_per_lane_ms: Vec<f64>,
    /// So many.
    pub many_rays: u64,
}

/// How many times as fast textures or many rays a lane must be in the probe to be taken: else it is buffers and a ray a lane,
/// which take less memory and suit wide devices.
pub const MARGIN: f64 = 1.1;

impl ProbeRecord {
    /// How many times as fast the texture was read as the buffer, of the least time of each: whatever else runs on the machine can only
    /// make a time longer, and does so for a few of many rounds.
    pub fn texture_gain(&self) -> f64 {
        gain(&self.gather_buffer_ms, &self.gather_texture_ms)
    }

    /// How many times as fast many rays a lane were as one.
    pub fn many_rays_gain(&self) -> f64 {
        gain(&self.one_ray_per_lane_ms, &self.many_rays_per_lane_ms)
    }

    /// The launch settings that the rule takes.
    pub fn launch(&self) -> LaunchSettings {
        let memory_access = if self.texture_gain() >= MARGIN { "texture" } else { "buffer" };
        LaunchSettings::new(memory_access, if self.many_rays_gain() >= MARGIN { self.many_rays } else { 1 })
    }
}

fn gain(plain: &[f64], other: &[f64]) -> f64 {
    let least = |times: &[f64]| times.iter().copied().fold(f64::INFINITY, f64::min);
    let found = least(plain) / least(other);
    if found.is_finite() { found } else { 1.0 }
}

records! {
    /// The launch settings of every tracer for which none are set, and how they were found.
    pub struct LaunchRecord {
        /// The launch settings.
        #[serde(flatten)]
        pub launch: LaunchSettings,
        /// What they were told by; none where they were given.
        pub probe: Option<ProbeRecord> = default,
    }
}

impl TracerRecord {
    /// Its launch settings; none of a tracer that has no such choice.
    pub fn launch(&self) -> Option<LaunchSettings> {
        let memory_access = self.parameters.get(MEMORY_ACCESS)?.as_str()?;
        Some(LaunchSettings::new(memory_access, self.parameters.get(RAYS_PER_LANE)?.as_u64()?))
    }
}

/// Whether rows are the same tracer's in the same place and differ in launch settings alone, or in nothing.
pub fn differ_in_launch(one: &Row, other: &Row) -> bool {
    let rest = |row: &Row| {
        let of_launch = |name: &String| [MEMORY_ACCESS, RAYS_PER_LANE].contains(&name.as_str());
        let rest = row.tracer.parameters.iter().filter(|(name, _)| !of_launch(name));
        rest.map(|(name, value)| (name.clone(), value.clone())).collect::<Vec<_>>()
    };
    one.tracer.name == other.tracer.name && one.viewpoint == other.viewpoint && rest(one) == rest(other)
}

/// Ratios of two methods at equal launch settings, one a combination that both have, and last at each one's best. `one` and `other` are
/// rows of each method that differ in their launch settings alone; a row without launch settings stands beside every one of the other.
/// `time_ms` is how long a row took, of a build or of a trace (rows without a time are left out), `ratio` is what is made of two rows.
pub fn at_launch_settings<'r, R>(
    one: &[&'r Row],
    other: &[&'r Row],
    time_ms: impl Fn(&Row) -> Option<f64>,
    ratio: impl Fn(&'r Row, &'r Row) -> Option<R>,
) -> Vec<R> {
    type Timed<'r> = (Option<LaunchSettings>, f64, &'r Row);
    let timed = |rows: &[&'r Row]| -> Vec<Timed<'r>> {
        rows.iter().filter_map(|row| Some((row.tracer.launch(), time_ms(row)?, *row))).collect()
    };
    let both = [timed(one), timed(other)];
    let all: BTreeSet<&LaunchSettings> = both.iter().flatten().filter_map(|(launch, ..)| launch.as_ref()).collect();
    let at = |wanted: &LaunchSettings| {
        let is = |(launch, ..): &&Timed<'_>| launch.as_ref().is_none_or(|launch| launch == wanted);
        both.each_ref().map(|rows| rows.iter().find(is))
    };
    let best = both.each_ref().map(|rows| rows.iter().min_by(|a, b| a.1.total_cmp(&b.1)));
    let pairs = all.into_iter().map(at).chain([best]);
    pairs.filter_map(|[one, other]| ratio(one?.2, other?.2)).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use tracebench_api::{ClockKind, Query};

    use super::*;
    use crate::report::fixture::{self, Quality};

    fn probe(texture_gain: &[f64], many_gain: &[f64]) -> ProbeRecord {
        // Rounds on a machine that is busy with something else now and then.
        let busy = [1.0, 3.0, 1.0, 1.2, 5.0, 1.0, 1.0, 2.0, 1.0];
        let by = |gains: &[f64]| busy.iter().zip(gains.iter().cycle()).map(|(busy, gain)| 2.0 * busy / gain).collect();
        let plain: Vec<f64> = busy.iter().map(|busy| 2.0 * busy).collect();
        ProbeRecord {
            gather_buffer_ms: plain.clone(),
            gather_texture_ms: by(texture_gain),
            one_ray_per_lane_ms: plain,
            many_rays_per_lane_ms: by(many_gain),
            many_rays: 32,
        }
    }

    /// Proves that each of the launch settings depends on its own kernels, that a tie, one within the margin and a probe without
    /// times fall to buffers and a ray a lane, and that rounds in which something else ran do not decide.
    #[test]
    fn the_rule_goes_by_the_probe() {
        for (texture, many, memory_access, rays) in [
            (1.5, 1.4, "texture", 32),
            (1.5, 0.4, "texture", 1),
            (0.7, 1.4, "buffer", 32),
            (0.7, 0.4, "buffer", 1),
            (1.0, 1.0, "buffer", 1),
            (1.09, 1.09, "buffer", 1),
        ] {
            assert_eq!(
                probe(&[texture], &[many]).launch(),
                LaunchSettings::new(memory_access, rays),
                "{texture} {many}"
            );
        }
        // Of nine rounds six were disturbed, those of the texture alone.
        let disturbed = [1.5, 0.1, 0.2, 0.1, 0.3, 0.1, 1.5, 0.1, 1.5];
        assert_eq!(probe(&disturbed, &[1.0]).launch().memory_access, "texture");
        assert_eq!(ProbeRecord::default().launch(), LaunchSettings::new("buffer", 1));
    }

    /// Rows of a tracer at launch settings, with the speed at each.
    fn rows(name: &str, speeds: &[(&str, u64, f64)]) -> Vec<Row> {
        let row = |&(memory_access, rays, speed): &(&str, u64, f64)| {
            let quality = Quality { missed: 0.0, blur: 0.0, speed, clock: ClockKind::DeviceTimestamps };
            let mut row = fixture::run(&[(name, quality)], &[("diffuse", Query::Closest)]).rows.remove(0);
            if !memory_access.is_empty() {
                row.tracer.parameters.insert(MEMORY_ACCESS.to_owned(), json!(memory_access));
                row.tracer.parameters.insert(RAYS_PER_LANE.to_owned(), json!(rays));
            }
            row
        };
        speeds.iter().map(row).collect()
    }

    /// Whether the first is faster, at every combination and at each one's best.
    fn faster(one: &[Row], other: &[Row]) -> (usize, Option<bool>) {
        let [one, other] = [one, other].map(|rows| rows.iter().collect::<Vec<_>>());
        let time_ms = |row: &Row| Some(row.traces.first()?.times.median_ms);
        let ratios = at_launch_settings(&one, &other, time_ms, |one, other| Some(time_ms(other)? / time_ms(one)?));
        let is = |faster: bool| !ratios.is_empty() && ratios.iter().all(|ratio| (*ratio > 1.0) == faster);
        (ratios.len(), is(true).then_some(true).or(is(false).then_some(false)))
    }

    /// Proves that a verdict is given where it is the same at every combination and at each one's best, and none where one combination
    /// differs, where the best differ though equal launch settings agree (the negative controls), and where nothing was timed; a method
    /// without launch settings stands beside every combination of the other.
    #[test]
    fn verdicts_stand_at_equal_and_best_launch_settings() {
        let one = rows("one", &[("buffer", 1, 2.0), ("texture", 1, 4.0)]);
        assert_eq!(faster(&one, &rows("other", &[("buffer", 1, 1.0), ("texture", 1, 3.0)])), (3, Some(true)));
        assert_eq!(faster(&rows("other", &[("buffer", 1, 1.0), ("texture", 1, 3.0)]), &one), (3, Some(false)));
        assert_eq!(faster(&one, &rows("other", &[("buffer", 1, 3.0), ("texture", 1, 3.5)])), (3, None));
        // The other has launch settings that the one does not have, and is best by them.
        let further = rows("other", &[("buffer", 1, 1.0), ("texture", 1, 3.0), ("texture", 32, 9.0)]);
        assert_eq!(faster(&one, &further), (3, None));
        let host = |speed| rows("host", &[("", 0, speed)]);
        assert_eq!(faster(&one, &host(1.0)), (3, Some(true)));
        assert_eq!(faster(&one, &host(3.0)), (3, None));
        assert_eq!(faster(&host(1.0), &host(2.0)), (1, Some(false)));
        assert_eq!(faster(&one, &[]), (0, None));
    }
}
