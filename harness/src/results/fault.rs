//! What no measurement can have come to, whoever wrote it into a record: every rule is a field, whether it holds, and what it must be. What
//! numbers, lists and texts may be, wherever they stand, is looked at by the names of their fields while the document is read, so that
//! nothing of it is kept.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Write as _};

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use tracebench_api::Query;

use super::{
    Accuracy, AxisRecord, ByRule, InterleavedSetRecord, Judgement, Percentiles, PoseRecord, RULES_VERSION, Record, Row,
    Rule, Times, TraceRecord, TrueCounts, WaveRow,
};
use crate::statistics::median;

/// Configurations whose score is known beforehand: a record has rows of all of them, whatever it says.
pub const CONTROL_NAMES: [&str; 4] = ["oracle", "always-miss", "always-hit", "corrupted"];

/// What figures may be off by that are made of others, a share.
const ROUNDING: f64 = 1e-9;

/// That something is sound; else which field is not as it must be.
type Sound = Result<(), String>;

impl Record {
    /// Reads a record from a whole JSON document. What can be none of a run is told with the path of its field and what it must be.
    ///
    /// # Errors
    /// Which field that is.
    pub fn read(json: &[u8]) -> Result<Self, String> {
        let (reader, mut path) = (|| serde_json::Deserializer::from_slice(json), String::new());
        Checked { path: &mut path, field: Field::default() }.deserialize(&mut reader()).map_err(without_place)?;
        let record: Self = serde_path_to_error::deserialize(&mut reader()).map_err(|error| {
            let path = error.path().to_string();
            format!("`{path}`: {}", without_place(error.into_inner()))
        })?;
        record.check()?;
        Ok(record)
    }

    /// Whether it can be of a run; else which field is not as it must be.
    fn check(&self) -> Sound {
        let version = self.provenance.rules_version;
        must("", "rules_version", version <= RULES_VERSION, "that of this program or less: take a newer program")?;
        let asked = |name: &&str| self.control_names.iter().any(|one| one == name);
        must("", "control_names", version == 0 || CONTROL_NAMES.iter().all(asked), "all controls")?;
        // Of a shard another one may have all rows; where cases were asked, a tracer may have been there for none.
        let may_be_empty = self.provenance.shard.is_some() || self.cases.is_some() || self.frames.is_some();
        must("", "rows", may_be_empty || !self.rows.is_empty(), "filled: it has no rows")?;
        for (list, rows) in [("rows", &self.rows), ("controls", &self.controls), ("anchors", &self.anchors)] {
            each(list, rows, |at, row| self.row(at, row))?;
        }
        each("interleaved_sets", &self.interleaved_sets, interleaved_set_is_sound)?;
        let axes = self.sweep.iter().flat_map(|sweep| &sweep.axes);
        let has_own = |axis: &AxisRecord| axis.values.contains(&axis.own);
        each("sweep.axes", axes, |at, axis| must(at, "values", has_own(axis), "a list with `own` in it"))?;
        for case in self.cases.iter().flat_map(|record| &record.cases) {
            let filled = !case.difficulty_parameter.values.is_empty();
            must("cases.cases", "difficulty_parameter.values", filled, "filled")?;
        }
        if let Some(found) = &self.explanation {
            let steps = found.remedies.len() + 1;
            each("explanation.scenes", &found.scenes, |at, scene| {
                each(&format!("{at}.sets"), &scene.sets, |at, set| {
                    let rule = "a number for the tracer as it was asked for and one for each of `remedies`";
                    must(at, "wrong_by_remedy", set.wrong_by_remedy.len() == steps, rule)
                })
            })?;
        }
        if let Some(frames) = &self.frames {
            each("frames.scenes", &frames.scenes, |at, scene| {
                let count = scene.viewpoints.len();
                let all = count == scene.scene_sha256.len() && count <= frames.frames as usize;
                must(at, "viewpoints", all, "one a frame")
            })?;
            each("frames.rows", &frames.rows, |at, row| {
                let scene = frames.scenes.get(row.scene as usize);
                must(at, "scene", scene.is_some(), "the place of one of `frames.scenes`")?;
                let set = row.interleaved_set.is_none_or(|set| (set as usize) < self.interleaved_sets.len());
                must(at, "interleaved_set", set, "the place of one of `interleaved_sets`")?;
                let few = scene.is_some_and(|scene| row.frames.len() <= scene.viewpoints.len());
                must(at, "frames", few, "no more than the scene has")?;
                let mut waves = row.frames.iter().flat_map(|frame| frame.works.values()).flat_map(|work| &work.waves);
                let sound =
                    |wave: &WaveRow| wave.judged <= wave.rays && wave.right.iter().all(|right| *right <= wave.judged);
                let rule = "no more right than judged, and no more judged than there are";
                must(at, "frames.works.waves", waves.all(sound), rule)
            })?;
        }
        each("attack.searches", self.attack.iter().flat_map(|attack| &attack.searches), |at, search| {
            must(at, "found", !search.found.is_empty(), "filled")?;
            let sound = |pose: &PoseRecord| pose.wrong <= pose.judged;
            must(at, "wrong", search.found.iter().chain([&search.random]).all(sound), "no more than `judged`")
        })?;
        if let Some(pareto) = &self.pareto {
            each("pareto.scenes", &pareto.scenes, |at, scene| {
                let points = scene.pictures.iter().flat_map(|set| &set.points);
                let known = points.map(|pictures| pictures.point).all(|point| point < pareto.points.len());
                must(at, "pictures", known, "of `points` that there are")
            })?;
        }
        Ok(())
    }

    fn row(&self, at: &str, row: &Row) -> Sound {
        self.times(&format!("{at}.build"), &row.build.times)?;
        for (name, times) in [("first", &row.build.first), ("steady", &row.build.steady)] {
            times.as_ref().map_or(Ok(()), |times| self.times(&format!("{at}.build.{name}"), times))?;
        }
        let bytes: u64 = row.memory.structure.iter().map(|part| part.allocated_bytes).fold(0, u64::saturating_add);
        must(at, "memory.structure_bytes", row.memory.structure_bytes == bytes, "the sum of its parts")?;
        each(&format!("{at}.traces"), &row.traces, |at, trace| {
            self.times(at, &trace.times)?;
            trace_is_sound(at, trace)
        })
    }

    fn times(&self, at: &str, times: &Times) -> Sound {
        let Times { samples_ms, submit_to_done_samples_ms, interval_ms: [low, high], .. } = times;
        let samples = samples_ms.len();
        let of_samples = |found: f64, samples: &[f64]| samples.is_empty() || near(found, median(samples));
        must(at, "median_ms", of_samples(times.median_ms, samples_ms), "the median of `samples_ms`")?;
        let inside = (low - ROUNDING..=high + ROUNDING).contains(&times.median_ms);
        must(at, "interval_ms", samples == 0 || inside, "an interval with `median_ms` in it")?;
        let by_host = times.submit_to_done_median_ms.is_none_or(|found| of_samples(found, submit_to_done_samples_ms));
        must(at, "submit_to_done_median_ms", by_host, "the median of `submit_to_done_samples_ms`")?;
        let as_many = [0, samples].contains(&submit_to_done_samples_ms.len());
        must(at, "submit_to_done_samples_ms", as_many, "as many as `samples_ms`")?;
        // Records of before interleaved sets were told of have none.
        let set = times.interleaved_set.map(|set| self.interleaved_sets.get(set as usize));
        must(at, "interleaved_set", set != Some(None), "the place of one of `interleaved_sets`")?;
        let ticks = set.flatten().and_then(|set| set.clock_ticks.as_ref());
        let told = times.invalid.is_some() || ticks.is_none_or(|ticks| ticks.too_coarse(times).is_none());
        must(at, "invalid", told, "said: its times are below 20 ticks of their clock")?;
        let rounds = set.flatten().map_or(0, |set| set.orders.len());
        must(at, "samples_ms", rounds == 0 || samples <= rounds, "no more than its interleaved set has rounds")?;
        must(at, "grown_samples", times.grown_samples <= samples as u64, "no more than `samples_ms`")?;
        each(&format!("{at}.phases"), &times.phases, |at, phase| {
            must(at, "samples_ms", phase.samples_ms.len() <= samples, "no more than the whole has")?;
            must(at, "median_ms", of_samples(phase.median_ms, &phase.samples_ms), "their median")
        })
    }
}

fn interleaved_set_is_sound(at: &str, set: &InterleavedSetRecord) -> Sound {
    let (rounds, participants) = (set.orders.len(), set.participants.len());
    let is_order = |order: &Vec<u32>| {
        let mut sorted = order.clone();
        sorted.sort_unstable();
        sorted.into_iter().eq(0..participants as u32)
    };
    must(at, "orders", set.orders.iter().all(is_order), "lists with each of `participants` once")?;
    let few = "of no more samples than rounds";
    must(at, "kernels", set.kernels.iter().all(|kernel| kernel.samples_ms.len() <= rounds), few)?;
    must(at, "doubled_work", set.doubled_work.iter().all(|work| work.samples_ms.len() <= rounds), few)
}

fn trace_is_sound(at: &str, trace: &TraceRecord) -> Sound {
    let TraceRecord { count, times, mrays_per_s, judgement, .. } = trace;
    must(at, "count", *count > 0, "1 or more")?;
    let speed = *count as f64 / times.median_ms / 1e3;
    let timed = !times.samples_ms.is_empty() && *mrays_per_s > 0.0;
    must(at, "mrays_per_s", !timed || near(*mrays_per_s, speed), "`count` over `median_ms`")?;
    let kept = trace.per_trace.iter().map(|part| part.allocated_bytes).fold(0, u64::saturating_add);
    let is_sum = trace.per_trace.is_empty() || trace.per_trace_bytes == kept;
    must(at, "per_trace_bytes", is_sum, "the sum of `per_trace`")?;
    let same = trace.same_as_first.is_none_or(|rays| rays <= *count);
    must(at, "same_as_first", same, "no more rays than `count`")?;
    let statuses = trace.statuses.values().copied().fold(0, u64::saturating_add);
    must(at, "statuses", trace.statuses.is_empty() || statuses == *count, "of as many rays as `count`")?;
    let by_status = judgement.by_status();
    let judged = by_status.values().map(|of| of.rays).fold(0, u64::saturating_add);
    let right = by_status.values().all(|of| of.right.values().all(|right| *right <= of.rays));
    must(at, "judgement.by_status", judged <= *count && right, "of no more rays than there are")?;
    let at = &*format!("{at}.judgement");
    let is_any = trace.query == Query::Any;
    match judgement {
        Judgement::Closest(judged) => {
            let accuracies = judgement.accuracies(*count);
            let field = |rule: Rule| format!("agreement.{}", rule.name());
            for (rule, of) in Rule::ALL.into_iter().zip(&accuracies) {
                must(at, &field(rule), holds(of.interval, of.share), "in its interval")?;
            }
            let curve = judged.curve.iter().all(|[_, share]| (0.0..=1.0).contains(share))
                && judged.curve.is_sorted_by(|[_, one], [_, other]| one <= other);
            must(at, "curve", curve, "pairs of a tolerance and a share that does not fall")?;
            let Percentiles { p50, p95, p99 } = judged.position_error;
            let errors: Vec<f64> = [p50, p95, p99].into_iter().flatten().collect();
            must(at, "position_error", errors.is_sorted(), "percentiles that rise")?;
            let of_truth = |truth: &TrueCounts| {
                let ambiguous = truth.ambiguous_hits + truth.ambiguous_misses;
                ambiguous == judged.ambiguous_rays && truth.hits + truth.misses + ambiguous == *count
            };
            let truth = judged.truth.as_ref().is_none_or(of_truth);
            must(at, "truth", truth, "of `count` rays, `ambiguous_rays` of them ambiguous")?;
            let ByRule { tight, footprint } = &judged.classes;
            for (rule, classes) in [(Rule::Tight, tight), (Rule::Footprint, footprint), (Rule::HitMiss, tight)] {
                let Accuracy { share, wrong, .. } = accuracies[rule as usize];
                let off = |share: f64| (1.0 - share - wrong as f64 / classes.all() as f64).abs();
                must(at, &field(rule), share.is_none_or(|share| off(share) <= ROUNDING), "that of its `classes`")?;
            }
            must(at, "classes", !is_any, "`occlusion`: its rays ask for any hit")?;
        }
        Judgement::Any(judged) => {
            let table = &judged.occlusion;
            let share = holds(table.balanced_accuracy_interval, table.balanced_accuracy);
            must(at, "occlusion.balanced_accuracy", share, "in its interval")?;
            must(at, "occlusion", is_any, "`classes`: its rays ask for the closest hit")?;
        }
    }
    must(at, "ambiguous_rays", judgement.ambiguous() <= *count, "no more than `count`")?;
    must(at, "wrong_rays", judgement.wrong_rays().iter().all(|ray| ray.index < *count), "of an `index` below `count`")
}

/// Whether an interval holds a share. One that is not there holds every share.
fn holds(interval: Option<[f64; 2]>, share: Option<f64>) -> bool {
    let both = interval.zip(share);
    both.is_none_or(|([low, high], share)| (low - ROUNDING..=high + ROUNDING).contains(&share))
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= ROUNDING * expected.abs()
}

/// A rule of a field: whether it holds, and what the field must be.
fn must(at: &str, field: &str, holds: bool, be: &str) -> Sound {
    let dot = if at.is_empty() { "" } else { "." };
    if holds { Ok(()) } else { Err(format!("`{at}{dot}{field}` must be {be}")) }
}

fn each<T>(at: &str, list: impl IntoIterator<Item = T>, check: impl Fn(&str, T) -> Sound) -> Sound {
    list.into_iter().enumerate().try_for_each(|(index, one)| check(&format!("{at}[{index}]"), one))
}

/// The text without the line and the column, which say nothing of a document on one line.
fn without_place(error: serde_json::Error) -> String {
    let text = error.to_string();
    text.rsplit_once(" at line ").map_or_else(|| text.clone(), |(what, _)| what.to_owned())
}

/// Fields whose numbers may lie below zero. All others, and all below them, count or measure something.
const SIGNED: &str =
    "eye forward up origin direction change deviations structure_statistics difficulty_level time_s times_s ssim";
/// Fields whose numbers are shares, and all below them.
const SHARES: &str = "agreement interval identity within_common_texel within_own_texel balanced_accuracy balanced_accuracy_interval \
                      material normal position interval_coverage featured min_featured most_wrong least_wrong max_lost_share";
/// Lists that are never written empty.
const FILLED: &str =
    "control_names curve axes points wrong_by_remedy times_s viewpoints difficulty_levels rays_per_pixel";
/// Fields with values of any kind: those of parameters.
const FREE: &str = "parameters ray_parameters values seed";
/// The largest whole number that JSON's readers hold exactly, 2^53.
const MAX_WHOLE: u64 = 1 << 53;

/// A value of a document with its path. It is read and not kept.
struct Checked<'p> {
    path: &'p mut String,
    field: Field,
}

/// What the fields say that a value is in.
#[derive(Clone, Copy, Default)]
struct Field {
    signed: bool,
    share: bool,
    filled: bool,
    free: bool,
}

impl Checked<'_> {
    fn is_not<E: Error>(&self, found: impl Display, must: &str) -> E {
        E::custom(format!("`{}` is {found} and must be {must}", self.path))
    }

    fn number<E: Error>(self, number: f64, found: impl Display) -> Result<(), E> {
        match self.field {
            Field { free: true, .. } => Ok(()),
            Field { share: true, .. } if !(0.0..=1.0).contains(&number) => {
                Err(self.is_not(found, "a share, from 0 to 1"))
            }
            Field { signed: false, .. } if number < 0.0 => Err(self.is_not(found, "0 or more")),
            _ if number.abs() > f64::from(f32::MAX) => Err(self.is_not(found, "a number that f32 holds")),
            _ => Ok(()),
        }
    }
}

impl Field {
    fn below(self, name: &str) -> Self {
        let is_of = |names: &str| names.split(' ').any(|each| each == name);
        Self {
            signed: self.signed || is_of(SIGNED),
            share: self.share || is_of(SHARES),
            filled: is_of(FILLED),
            free: self.free || is_of(FREE),
        }
    }
}

impl<'de> DeserializeSeed<'de> for Checked<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Checked<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        if number > MAX_WHOLE && !self.field.free {
            return Err(self.is_not(number, "a whole number up to 2^53"));
        }
        self.number(number as f64, number)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<(), E> {
        self.number(number as f64, number)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<(), E> {
        self.number(number, format_args!("{number:?}"))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let (length, mut index) = (self.path.len(), 0);
        loop {
            let _ = write!(self.path, "[{index}]");
            let field = Field { filled: false, ..self.field };
            let item = list.next_element_seed(Checked { path: self.path, field })?;
            self.path.truncate(length);
            match (item, index) {
                (None, 0) if self.field.filled => return Err(self.is_not("empty", "filled")),
                (None, _) => return Ok(()),
                _ => index += 1,
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let length = self.path.len();
        let mut names = BTreeSet::new();
        while let Some(name) = map.next_key::<String>()? {
            let dot = if length == 0 { "" } else { "." };
            let _ = write!(self.path, "{dot}{name}");
            let field = self.field.below(&name);
            if !names.insert(name) {
                map.next_value::<IgnoredAny>()?;
                return Err(self.is_not("there twice", "there once"));
            }
            map.next_value_seed(Checked { path: self.path, field })?;
            self.path.truncate(length);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use serde_json::{Value, json};

    use super::*;

    /// A record of a small run.
    fn record(packed: &[u8]) -> Value {
        let mut text = Vec::new();
        liblzma::read::XzDecoder::new(packed).read_to_end(&mut text).unwrap();
        serde_json::from_slice(&text).unwrap()
    }

    fn refusal(record: &Value) -> String {
        Record::read(record.to_string().as_bytes()).map_or_else(|reason| reason, |_| String::new())
    }

    /// Proves that what no run can have come to is refused with the path of its field and what it must be, each change alone of a record
    /// that is read as it is.
    #[test]
    fn impossible_values_are_refused_by_name() {
        let plain = record(include_bytes!("../../fuzz/seeds/run.json.xz"));
        let explained = record(include_bytes!("../../fuzz/seeds/explain.json.xz"));
        let fronts = record(include_bytes!("../../fuzz/seeds/pareto.json.xz"));
        let sweep = record(include_bytes!("../../fuzz/seeds/sweep.json.xz"));
        let tuned = record(include_bytes!("../../fuzz/seeds/tune.json.xz"));
        let moving = record(include_bytes!("../../fuzz/seeds/frames.json.xz"));
        let cases = record(include_bytes!("../../fuzz/seeds/stability.json.xz"));
        for whole in [&plain, &explained, &fronts, &sweep, &tuned, &moving, &cases] {
            assert_eq!(refusal(whole), "");
        }
        let trace = |rest: &str| format!("/rows/0/traces/0{rest}");
        let changes: [(&Value, &str, Value, &str); 39] = [
            (&plain, "/rows", json!([]), "`rows` must be filled: it has no rows"),
            (&plain, "/rules_version", json!(99), "`rules_version` must be that of this program or less"),
            (&plain, "/control_names", json!(["oracle"]), "`control_names` must be all controls"),
            (&plain, "/interleaved_sets", json!([]), "interleaved_set` must be the place of one of `interleaved_sets`"),
            (
                &plain,
                &trace("/judgement/position_error/p50"),
                json!(1e9),
                "position_error` must be percentiles that rise",
            ),
            (
                &plain,
                &trace("/judgement/curve/1/1"),
                json!(0.1),
                "curve` must be pairs of a tolerance and a share that",
            ),
            (&plain, "/control_names", json!([]), "`control_names` is empty and must be filled"),
            (&plain, &trace("/count"), json!(-3), "`rows[0].traces[0].count` is -3 and must be 0 or more"),
            (&plain, &trace("/count"), json!(0), "`rows[0].traces[0].count` must be 1 or more"),
            (&plain, &trace("/count"), json!(1_u64 << 60), "a whole number up to 2^53"),
            (&plain, &trace("/count"), json!("NaN"), "`rows[0].traces[0].count`: invalid type: string"),
            (
                &plain,
                &trace("/median_ms"),
                json!(1e9),
                "`rows[0].traces[0].median_ms` must be the median of `samples_ms`",
            ),
            (&plain, &trace("/median_ms"), json!(1e300), "`rows[0].traces[0].median_ms` is 1e300 and must be"),
            (
                &plain,
                &trace("/samples_ms/0"),
                json!(-1),
                "`rows[0].traces[0].samples_ms[0]` is -1 and must be 0 or more",
            ),
            (&plain, &trace("/interval_ms"), json!([0.0, 0.0]), "`rows[0].traces[0].interval_ms` must be an interval"),
            (&plain, &trace("/interval_coverage"), json!(1.5), "`rows[0].traces[0].interval_coverage` is 1.5"),
            (
                &plain,
                &trace("/mrays_per_s"),
                json!(561_000),
                "`rows[0].traces[0].mrays_per_s` must be `count` over `median_ms`",
            ),
            (
                &plain,
                &trace("/interleaved_set"),
                json!(99),
                "`rows[0].traces[0].interleaved_set` must be the place of one of `interleaved_sets`",
            ),
            (&plain, &trace("/grown_samples"), json!(99), "`rows[0].traces[0].grown_samples` must be no more"),
            (&plain, &trace("/statuses"), json!({ "hit": 1 }), "`rows[0].traces[0].statuses` must be of as many rays"),
            (&plain, &trace("/per_trace_bytes"), json!(1), "`rows[0].traces[0].per_trace_bytes` must be the sum"),
            (&plain, &trace("/query"), json!("any"), "`rows[0].traces[0].judgement.classes` must be `occlusion`"),
            (
                &plain,
                &trace("/judgement/agreement/tight"),
                json!(1.5),
                "`rows[0].traces[0].judgement.agreement.tight` is 1.5",
            ),
            (&plain, &trace("/judgement/agreement/tight"), json!(0.5), "agreement.tight` must be in its interval"),
            (
                &plain,
                &trace("/judgement/classes/footprint/false_hit"),
                json!(7),
                "agreement.footprint` must be that of its `classes`",
            ),
            (
                &plain,
                &trace("/judgement/ambiguous_rays"),
                json!(9999),
                "`rows[0].traces[0].judgement.ambiguous_rays` must be no more",
            ),
            (&plain, &trace("/judgement/ambiguous_rays"), json!("x"), "`rows[0].traces[0].judgement`: invalid type"),
            (&plain, "/rows/0/memory/structure_bytes", json!(1), "`rows[0].memory.structure_bytes` must be the sum"),
            (&plain, "/rows/1/build/submit_to_done_samples_ms", json!([1.0]), "`rows[1].build.submit_to_done_"),
            (
                &plain,
                "/interleaved_sets/1/orders/0",
                json!([0, 0]),
                "`interleaved_sets[1].orders` must be lists with each of `participants` once",
            ),
            (
                &explained,
                "/explanation/scenes/0/sets/0/wrong_by_remedy",
                json!([]),
                "sets[0].wrong_by_remedy` is empty",
            ),
            (
                &explained,
                "/explanation/scenes/0/sets/0/wrong_by_remedy",
                json!([1]),
                "sets[0].wrong_by_remedy` must be a number for",
            ),
            (&fronts, "/pareto/rays_per_pixel/0", json!(-4), "`pareto.rays_per_pixel[0]` is -4 and must be 0 or more"),
            (&fronts, "/pareto/points", json!([]), "`pareto.points` is empty and must be filled"),
            (&sweep, "/sweep/axes", json!([]), "`sweep.axes` is empty and must be filled"),
            (&sweep, "/sweep/axes/0/own", json!("7x"), "`sweep.axes[0].values` must be a list with `own` in it"),
            (
                &tuned,
                "/tuning/scenes/0/viewpoints",
                json!([]),
                "`tuning.scenes[0].viewpoints` is empty and must be filled",
            ),
            (
                &moving,
                "/frames/rows/0/scene",
                json!(9),
                "`frames.rows[0].scene` must be the place of one of `frames.scenes`",
            ),
            (
                &cases,
                "/cases/cases/0/difficulty_parameter/values",
                json!([]),
                "difficulty_parameter.values` must be filled",
            ),
        ];
        for (whole, place, value, said) in changes {
            let mut changed = whole.clone();
            *changed.pointer_mut(place).expect(place) = value.clone();
            let reason = refusal(&changed);
            assert!(reason.contains(said), "{place} {value}: {reason}");
        }
        let mut counted = plain.clone();
        for (rays, right, is_refused) in [(1, 1, false), (1, 2, true), (1 << 20, 1, true)] {
            let of = json!({ "hit": { "rays": rays, "right": { "tight": right } } });
            counted["rows"][0]["traces"][0]["judgement"]["by_status"] = of;
            assert_eq!(
                refusal(&counted).contains("judgement.by_status` must be of no more rays"),
                is_refused,
                "{rays}"
            );
        }
        let doubled_work = plain.to_string().replacen('{', "{\"seed\":1,", 1);
        let reason = Record::read(doubled_work.as_bytes()).unwrap_err();
        assert!(reason.contains("`seed` is there twice"), "{reason}");
    }
}
