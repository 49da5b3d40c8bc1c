//! Names on the command line: lists, presets, suggestions for what is not known.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::Path;

use itertools::Itertools as _;
use serde_json::json;
use tracebench_api::{ParameterError, Parameters, Preset};

use super::renames::{self, Kind};
use super::{CliError, refuse};
use crate::cases::{CASES, Case};
use crate::exchange;
use crate::papers::Experiment;
use crate::peers;
use crate::plan::{SceneSource, TracerRequest};
use crate::rays::{self, HOSTILE, RAY_SETS, RaySet};
use crate::registry::{self, TRACERS};
use crate::tables::Table;

/// Says that a name is not known, with the nearest that is.
pub(super) fn unknown(kind: &str, name: &str, known: &[&str]) -> CliError {
    let of = |was: Kind| match was {
        Kind::Table => kind == "table",
        Kind::Tracer => kind == "tracer",
        _ => was == Kind::Parameter && kind.starts_with("parameter"),
    };
    // A parameter's name may stand behind its tracer's.
    if let Some(is) = renames::renamed(of, name.rsplit('.').next().unwrap_or(name)) {
        return CliError::Argument(format!("{kind}: {is}"));
    }
    let near = known.iter().filter(|known| is_near(name, known));
    let nearest = near.max_by(|a, b| strsim::jaro_winkler(name, a).total_cmp(&strsim::jaro_winkler(name, b)));
    let hint = nearest.map_or_else(|| ".".to_owned(), |nearest| format!("; did you mean '{nearest}'?"));
    CliError::Argument(format!("there is no {kind} '{name}'{hint} There are: {}", known.join(", ")))
}

/// What has a name among all of its kind.
fn find<T>(kind: &str, name: &str, all: impl Iterator<Item = T>, of: fn(&T) -> &'static str) -> Result<T, CliError> {
    let mut all: Vec<T> = all.collect();
    match all.iter().position(|each| of(each) == name) {
        Some(place) => Ok(all.swap_remove(place)),
        None => Err(unknown(kind, name, &all.iter().map(of).collect::<Vec<_>>())),
    }
}

/// Whether a name may be another one, mistyped or cut short: a third of its letters may be wrong, one of few.
fn is_near(name: &str, known: &str) -> bool {
    let letters = name.chars().count();
    strsim::damerau_levenshtein(name, known) <= (letters / 3).max(1) || (letters >= 3 && known.starts_with(name))
}

/// The parts of a comma-separated list, each once, in order.
fn parts<'a>(list: &'a str, option: &str) -> Result<Vec<&'a str>, CliError> {
    let parts: Vec<&str> = list.split(',').map(str::trim).unique().collect();
    if parts.contains(&"") {
        return refuse(format!("{option} '{list}' has an empty name"));
    }
    Ok(parts)
}

/// Scenes: catalogue names, or paths to .gltf and .glb files; `all` is the whole catalogue. What is the path of something is one
/// path, whatever is in it. Scenes of the same name get longer ones.
pub(super) fn scenes(list: &OsStr) -> Result<Vec<SceneSource>, CliError> {
    let text = match list.to_str() {
        Some(text) if text == "all" || is_listed(text) || !Path::new(list).exists() => text,
        _ => return Ok(vec![scene(list)?]),
    };
    let named = parts(text, "--scene")?.into_iter().flat_map(|part| match part {
        "all" => tracebench_scenes::catalogue().iter().map(|entry| entry.name).collect(),
        name => vec![name],
    });
    let sources: Vec<SceneSource> = named.map(|name| scene(name.as_ref())).collect::<Result<_, _>>()?;
    let mut found: Vec<SceneSource> = sources.into_iter().unique().collect();
    tell_apart(&mut found);
    Ok(found)
}

/// Gives files whose scenes would have the name of another one as much of the ends of their paths as distinguishes them.
fn tell_apart(sources: &mut [SceneSource]) {
    let names: Vec<String> = sources.iter().map(|source| source.name().to_owned()).collect();
    let shared = |index: usize| names.iter().filter(|name| **name == names[index]).count() > 1;
    let ends = |depth: usize| {
        let end = |(index, source): (usize, &SceneSource)| match source {
            SceneSource::File { path, .. } if shared(index) => {
                let parts: Vec<_> = path.iter().map(OsStr::to_string_lossy).collect();
                parts[parts.len().saturating_sub(depth)..].join("/")
            }
            _ => names[index].clone(),
        };
        sources.iter().enumerate().map(end).collect::<Vec<String>>()
    };
    let longest = sources.iter().map(|source| Path::new(&source.to_string()).iter().count()).max().unwrap_or(0);
    let different = |names: &Vec<String>| names.iter().all_unique();
    // Of paths that differ in nothing but in what is no text all keep their names.
    let Some(ends) = (1..=longest).map(ends).find(different) else { return };
    for (source, end) in sources.iter_mut().zip(ends) {
        if let SceneSource::File { name, .. } = source {
            *name = end;
        }
    }
}

/// Whether a name is one of the catalogue.
fn is_listed(name: &str) -> bool {
    tracebench_scenes::catalogue().iter().any(|entry| entry.name == name)
}

pub(super) fn scene(name: &OsStr) -> Result<SceneSource, CliError> {
    let path = Path::new(name);
    let text = name.to_string_lossy();
    if is_listed(&text) {
        return Ok(SceneSource::Catalogue(text.into_owned()));
    }
    let is_model =
        path.extension().is_some_and(|end| end.eq_ignore_ascii_case("glb") || end.eq_ignore_ascii_case("gltf"));
    if is_model || text.contains(std::path::MAIN_SEPARATOR) || path.exists() {
        return Ok(SceneSource::File { path: path.to_owned(), name: tracebench_scenes::name_of(path) });
    }
    let known: Vec<&str> = tracebench_scenes::catalogue().iter().map(|entry| entry.name).collect();
    Err(unknown("scene (nor a path to a .gltf or .glb file)", &text, &known))
}

/// Ray sets: names, folders of rays as `file:DIR`, or all that are listed.
pub(super) fn ray_sets(list: &str) -> Result<Vec<RaySet>, CliError> {
    let parts = parts(list, "--rays")?;
    if parts.contains(&"all") {
        return Ok(RAY_SETS.to_vec());
    }
    let read = |name: &str| match name.strip_prefix("file:") {
        Some(folder) => Ok(exchange::ray_set(Path::new(folder))?),
        None => find("ray set", name, RAY_SETS.iter().chain([&HOSTILE]).copied(), |set| set.name),
    };
    parts.into_iter().map(read).collect()
}

/// Cases: names, or all.
pub(super) fn cases(list: &str) -> Result<Vec<&'static Case>, CliError> {
    let parts = parts(list, "--case")?;
    if parts.contains(&"all") {
        return Ok(CASES.iter().collect());
    }
    parts.into_iter().map(|name| find("case", name, CASES.iter(), |case| case.name)).collect()
}

/// Tracers: `NAME[:PRESET][@PARAMETER=VALUE...]`,... or `all[:PRESET]`, with `--set` values on top.
pub(super) fn tracers(list: &str, settings: &[String]) -> Result<Vec<TracerRequest>, CliError> {
    let mut requests: Vec<TracerRequest> = Vec::new();
    for part in parts(list, "--tracer")? {
        let mut pieces = part.split('@');
        let head = pieces.next().unwrap_or_default();
        let own: Vec<&str> = parts_first(pieces).collect();
        let (name, preset) = match head.split_once(':') {
            None => (head, Preset::Published),
            Some((name, text)) => (name, find("preset", text, Preset::ALL.into_iter(), |preset| preset.name())?),
        };
        let required = name != "all";
        if !required && !own.is_empty() {
            return refuse(format!("--tracer '{part}': parameters are those of one tracer; name it in place of all"));
        }
        let all = TRACERS.iter().flat_map(|each| TracerRequest::forms(each, preset));
        let chosen = if required { vec![TracerRequest::of(named(name)?, preset)] } else { all.collect() };
        for mut request in chosen {
            request.required = required;
            for setting in &own {
                let (parameter, value) = setting.split_once('=').ok_or_else(|| {
                    CliError::Argument(format!("--tracer '{part}' must read NAME[:PRESET][@PARAMETER=VALUE...]"))
                })?;
                set(&mut request, parameter, value)?;
            }
            // Of all, a preset that differs in nothing from one that is there is that one.
            let same = |other: &&mut TracerRequest| {
                let of_preset = other.preset == preset || !required;
                other.name() == request.name() && of_preset && other.parameters == request.parameters
            };
            match requests.iter_mut().find(same) {
                Some(already) => already.required |= required,
                None => requests.push(request),
            }
        }
    }
    let idle = apply_all(settings, &mut requests)?;
    idle.map_or(Ok(requests), Err)
}

/// The only tracer of a list; `else_refused` says that there may be no more.
pub(super) fn one_tracer(list: &str, settings: &[String], else_refused: &str) -> Result<TracerRequest, CliError> {
    tracers(list, settings)?.into_iter().exactly_one().or_else(|_| refuse(else_refused))
}

/// The tracers of a table with `--set` values on top; none is required, since nobody has named it.
pub(super) fn peers(table: &peers::Table, settings: &[String]) -> Result<Vec<TracerRequest>, CliError> {
    let mut requests = table.configs();
    apply_all(settings, &mut requests)?;
    // A value that is set may be one that the table has a row of its own for.
    let different = requests.into_iter().unique_by(|of| (of.name(), json!(of.parameters).to_string()));
    Ok(different.collect())
}

/// The tracers of an experiment's steps with `--set` values on top; values that a row is about stay.
pub(super) fn steps(experiment: &Experiment, settings: &[String]) -> Result<Vec<Vec<TracerRequest>>, CliError> {
    let mut steps = experiment.requests();
    steps.iter_mut().try_for_each(|step| apply_all(settings, step).map(drop))?;
    Ok(steps)
}

/// Of an experiment's steps the rows alone that every `--only T.P=V,V` leaves: those of other tracers, and of T those that have one
/// of the values.
pub(super) fn only(steps: &mut [Vec<TracerRequest>], wanted: &[String]) -> Result<(), CliError> {
    for each in wanted {
        let (tracer, parameter, values) = split(each)?;
        if let Some(is) = renames::renamed(|kind| kind == Kind::Parameter, parameter) {
            return refuse(format!("--only {each}: {is}"));
        }
        let of = |request: &TracerRequest| Some(request.parameters.value(parameter)?.to_string());
        let own = steps.iter().flatten().filter(|request| request.name() == tracer);
        let known: BTreeSet<String> = own.filter_map(of).collect();
        if let Some(value) = values.split(',').find(|value| !known.contains(*value)) {
            let known = if known.is_empty() { "no row has that".to_owned() } else { known.iter().join(", ") };
            return refuse(format!("--only {each}: no row has {value}; there are: {known}"));
        }
        let stays = |request: &TracerRequest| {
            let own = of(request).unwrap_or_default();
            request.name() != tracer || values.split(',').any(|value| value == own)
        };
        steps.iter_mut().for_each(|step| step.retain(stays));
    }
    Ok(())
}

/// A table by name.
pub(super) fn table(name: &str) -> Result<Table, CliError> {
    find("table", name, Table::all(), |table| table.name())
}

/// What `--set` says about ray sets.
pub(super) fn ray_values(settings: &[String]) -> Result<Parameters, CliError> {
    let known = rays::ray_parameters();
    let mut parameters = rays::default_parameters();
    for setting in settings {
        let (of, parameter, value) = split(setting)?;
        if of == RAYS {
            let set = parameters.set(&known, parameter, value);
            let set = set.and_then(|()| rays::check_ray_parameters(&parameters));
            set.map_err(|error| refused(RAYS, error))?;
        }
    }
    Ok(parameters)
}

/// The name under which parameters of ray sets are set.
const RAYS: &str = "rays";

/// The parts of `tracer.parameter=value`.
fn split(setting: &str) -> Result<(&str, &str, &str), CliError> {
    match setting.split_once('=').and_then(|(path, value)| Some((path.split_once('.')?, value))) {
        Some(((of, parameter), value)) => Ok((of, parameter, value)),
        None => refuse(format!("--set '{setting}' must read tracer.parameter=value or rays.parameter=value")),
    }
}

fn refused(of: &str, error: ParameterError) -> CliError {
    match error {
        ParameterError::Unknown { name, known } => {
            unknown(&format!("parameter of {of}"), &name, &known.split(", ").collect::<Vec<_>>())
        }
        error => CliError::Argument(format!("--set {of}: {error}")),
    }
}

fn named(name: &str) -> Result<&'static registry::Registration, CliError> {
    let mut known: Vec<&str> = TRACERS.iter().map(|registration| registration.describe().name).collect();
    known.push("all");
    registry::find(name).ok_or_else(|| unknown("tracer", name, &known))
}

/// Sets one parameter of a tracer.
fn set(request: &mut TracerRequest, parameter: &str, value: &str) -> Result<(), CliError> {
    let name = request.registration.describe().name;
    request.set(parameter, value).map_err(|error| refused(name, error))
}

/// Settings in their order, but those of a tracer's part behind the one that says which part it is, which has fewer dots.
fn parts_first<S: AsRef<str>>(settings: impl IntoIterator<Item = S>) -> impl Iterator<Item = S> {
    settings
        .into_iter()
        .sorted_by_key(|setting| setting.as_ref().split('=').next().unwrap_or_default().matches('.').count())
}

/// Applies every `--set` that is about a tracer. Values that stand with a tracer's own name are more particular and stay; gives the first
/// that has nothing to set, since all requests of its tracer have a value of their own there.
fn apply_all(settings: &[String], requests: &mut [TracerRequest]) -> Result<Option<CliError>, CliError> {
    let own: Vec<Vec<String>> = requests.iter().map(|request| request.changed.clone()).collect();
    let mut idle = None;
    for setting in parts_first(settings) {
        let (tracer, parameter, value) = split(setting)?;
        if tracer == RAYS {
            continue;
        }
        named(tracer)?;
        let (mut applied, mut sets) = (false, false);
        for (request, own) in requests.iter_mut().zip(&own).filter(|(request, _)| request.name() == tracer) {
            applied = true;
            if own.iter().any(|name| name == parameter) {
                // It is looked at all the same.
                set(&mut request.clone(), parameter, value)?;
            } else {
                set(request, parameter, value)?;
                sets = true;
            }
        }
        if !applied {
            return refuse(format!("--set {setting}: {tracer} is not in --tracer"));
        }
        if !sets && idle.is_none() {
            let why = format!("every {tracer} in --tracer has its own value of {parameter}");
            idle = Some(CliError::Argument(format!("--set {setting} sets nothing: {why}")));
        }
    }
    Ok(idle)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message<T>(result: Result<T, CliError>) -> String {
        match result {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    /// What is not known is refused with the nearest known name.
    #[test]
    fn unknown_names_get_suggestions() {
        assert!(message(scenes("rooom".as_ref())).contains("'room'"));
        assert!(message(ray_sets("primry")).contains("'primary'"));
        assert!(message(tracers("bvh-cpo", &[])).contains("'bvh-cpu'"));
        assert!(message(tracers("bvh-cpu:improvd", &[])).contains("'improved'"));
        let set = |text: &str| tracers("screen-dda", &[text.to_owned()]);
        assert!(message(set("screen-dda.strid=1")).contains("'stride'"));
        assert!(message(set("screen-dda.stride=0")).contains("1 to 256"));
        assert!(message(set("stride=1")).contains("tracer.parameter=value"));
        assert!(message(set("bvh-cpu.build=fast")).contains("not in --tracer"));
        assert!(message(ray_sets("primary,,ao")).contains("empty name"));
        assert!(message(tracers("quad", &[])).contains("did you mean 'quadtree'?"));
    }

    /// Names that are like none have none suggested, and get the list all the same.
    #[test]
    fn strange_names_get_no_suggestion() {
        for message in [
            message(tracers("quadtree@foo=1", &[])),
            message(ray_sets("foo")),
            message(scenes("kitchen".as_ref())),
            message(tracers("embree", &[])),
        ] {
            assert!(!message.contains("did you mean") && message.contains("'. There are: "), "{message}");
        }
    }

    /// Proves that the parts of a tracer are named with their presets, that their parameters are set and read by the part's name, that another
    /// part brings its own values, and that what cannot be a part, or is no parameter of the one that is there, is refused with what is.
    #[test]
    fn parts_have_their_parameters() {
        let one = |text: &str| tracers(text, &[]).map(|mut requests| requests.remove(0));
        let value = |request: &TracerRequest, name: &str| request.parameters.value(name).map(ToString::to_string);
        let asked = one("hybrid@first=screen-dda:improved@then=ploc-gpu@first.stride=2@then.tree=lbvh").unwrap();
        assert_eq!(asked.changed, ["first", "then", "first.stride", "then.tree"]);
        for (name, expected) in
            [("first", "screen-dda:improved"), ("first.stride", "2"), ("first.march", "cells"), ("then.tree", "lbvh")]
        {
            assert_eq!(value(&asked, name).as_deref(), Some(expected), "{name}");
        }
        // In whatever order they stand.
        let before =
            tracers("hybrid", &["hybrid.first.stride=2", "hybrid.first=screen-dda"].map(str::to_owned)).unwrap();
        for published in [one("hybrid@first.stride=2@first=screen-dda").unwrap(), before[0].clone()] {
            assert_eq!(published.changed, ["first", "first.stride"]);
            assert_eq!(
                (value(&published, "first.stride"), value(&published, "first.march")),
                (Some("2".to_owned()), Some("pixels".to_owned()))
            );
        }
        // What was asked for of the part before is the new one's, or is refused.
        let later = |part: &str| tracers("hybrid@first.stride=2", &[format!("hybrid.first={part}")]);
        assert_eq!(value(&later("screen-dda:improved").unwrap()[0], "first.stride").as_deref(), Some("2"));
        assert!(message(later("quadtree")).contains("parameter of hybrid 'first.stride'"));
        let other = one("hybrid@then.tree=lbvh@first=quadtree:improved").unwrap();
        assert_eq!((value(&other, "first.march"), value(&other, "then.tree")), (None, Some("lbvh".to_owned())));
        assert!(other.registration.describe().parameters.iter().any(|each| each.name == "first.levels"));
        let plain = tracers("hybrid", &["hybrid.first.stride=3".to_owned()]).unwrap();
        assert_eq!(value(&plain[0], "first.stride").as_deref(), Some("3"));
        for part in ["first=bvh-cpu", "then=hybrid", "first=screen-dda:best"] {
            let refused = message(one(&format!("hybrid@{part}")));
            assert!(refused.contains("is not allowed: one of bvh-gpu, "), "{refused}");
        }
        for text in ["hybrid@first=quadtree@first.stride=2", "hybrid@first.stride=2@first=quadtree"] {
            assert!(message(one(text)).contains("parameter of hybrid 'first.stride'"));
        }
        let named = |text: &str| one(&format!("hybrid@first={text}@then={text}:improved")).is_ok();
        let on_device = TRACERS.iter().filter(|each| each.needs_device() && each.parts.is_none());
        assert_eq!(on_device.filter(|each| named(each.name())).count(), TRACERS.len() - 2);
    }

    /// A lens is focused by itself, or no nearer than at the near plane.
    #[test]
    fn lenses_are_focused_where_something_is() {
        let set = |value: &str| ray_values(&[format!("rays.lens_focus={value}")]);
        for value in ["0", "0.001", "1000"] {
            assert!(set(value).is_ok(), "{value}");
        }
        for value in ["1e-30", "0.0009", "-1"] {
            assert!(message(set(value)).contains("lens_focus"), "{value}");
        }
    }

    /// The value of `build`.
    fn build(request: &TracerRequest) -> String {
        request.parameters.value("build").unwrap().to_string()
    }

    /// Paths are paths, `all` is every tracer without being required, names are required, settings come on top.
    #[test]
    fn lists_mean_what_they_say() {
        assert_eq!(scenes("room,a/b.glb".as_ref()).unwrap().len(), 2);
        let whole = tracebench_scenes::catalogue().len();
        assert_eq!(
            (scenes("all".as_ref()).unwrap().len(), scenes("room,all,a.glb".as_ref()).unwrap().len()),
            (whole, whole + 1)
        );
        let all = tracers("all:improved", &[]).unwrap();
        let count = TRACERS.len() + TRACERS.iter().map(|each| each.forms.len()).sum::<usize>();
        assert!(all.len() == count && all.iter().all(|each| !each.required && each.preset == Preset::Improved));
        // Forms that differ in nothing stand once.
        let both = tracers("all,all:improved", &[]).unwrap();
        let same = |one: &TracerRequest| {
            both.iter().filter(|other| other.name() == one.name() && other.parameters == one.parameters).count()
        };
        assert!(both.len() > count && both.len() < 2 * count && both.iter().all(|one| same(one) == 1));
        let set = tracers("bvh-cpu,bvh-cpu:improved", &["bvh-cpu.build=fastest".to_owned()]).unwrap();
        assert!(set.iter().all(|each| each.required && build(each) == "fastest"));
        assert_eq!(tracers("all,bvh-cpu", &[]).unwrap().len(), count);
    }

    /// A tracer may be in a list several times with values of its own, which `--set` does not touch and the label
    /// tells; what is wrong with one is said as of `--set`.
    #[test]
    fn tracers_have_values_of_their_own() {
        let list = "bvh-cpu,bvh-cpu@build=fastest,bvh-cpu:improved@build=fast,bvh-cpu@build=fastest";
        let found = tracers(list, &["bvh-cpu.build=slow".to_owned()]).unwrap();
        let builds: Vec<String> = found.iter().map(build).collect();
        assert_eq!(builds, ["slow", "fastest", "fast"]);
        assert!(found.iter().all(|request| request.required && request.changed == ["build"]));
        for (list, part) in [
            ("bvh-cpu@buid=fast", "'build'"),
            ("bvh-cpu@build=quick", "very_fast"),
            ("bvh-cpu@build", "PARAMETER=VALUE"),
            ("bvh-cpu@", "PARAMETER=VALUE"),
            ("all@build=fast", "one tracer"),
        ] {
            assert!(message(tracers(list, &[])).contains(part), "{list}");
        }
        assert!(message(tracers("bvh-cpu@build=fast", &["bvh-cpu.build=quick".to_owned()])).contains("very_fast"));
        // Where there is none without, nothing is set.
        let idle = message(tracers("bvh-cpu@build=fast,bvh-gpu", &["bvh-cpu.build=slow".to_owned()]));
        assert!(idle.contains("--set bvh-cpu.build=slow") && idle.contains("sets nothing"), "{idle}");
    }

    /// A table has every peer, none of them required, and no row twice, whatever is set.
    #[test]
    fn tables_have_every_peer_once() {
        let Ok(Table::Settings(bvh)) = table("bvh") else { panic!("it is one of peers") };
        let plain = peers(bvh, &[]).unwrap();
        let set = peers(bvh, &[format!("{}.build=fast", bvh.reference())]).unwrap();
        assert_eq!(set.len() + 1, plain.len());
        assert!(plain.iter().chain(&set).all(|request| !request.required));
        assert!(message(table("bvhs")).contains("'bvh'"));
        assert!(message(peers(bvh, &["screen-dda.stride=2".to_owned()])).contains("not in"));
    }
}
