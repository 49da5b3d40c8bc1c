//! What `reproduce` measures, in order of weight.

use itertools::Itertools as _;
use tracebench_api::Domain;

use super::Step;
use crate::papers::{Experiment, PAPERS};
use crate::registry::{Family, Registration, TRACERS};

/// The scene of what comes first.
const SCENE: &str = "room";
/// Rounds of what comes first on hardware: as few as verdicts rest on.
const ENOUGH_ROUNDS: &str = "12";
/// The scenes of what comes first on hardware.
const HARDWARE_SCENES: &str = "room,foliage";
/// Ray sets of fronts and needs.
const RAYS: &str = "diffuse,ao";
/// Rounds of times where more waits behind; too few for verdicts.
const FEW_ROUNDS: &str = "3";

/// Every step. What comes first answers most; where all is wanted whole, nothing is measured in part before, and within a budget on
/// hardware (`on_hardware`) what only hardware can tell comes before all.
pub(super) fn steps(whole: bool, on_hardware: bool) -> Vec<Step> {
    let tables = || experiments().map(|experiment| experiment.name);
    let mut steps = Vec::new();
    let mut step = |name: &str, words: &str| steps.push(Step::new(name, words));
    if !whole && on_hardware {
        let scenes = format!("--scene {HARDWARE_SCENES} --samples {ENOUGH_ROUNDS}");
        let tracers = builders(|_| true);
        let run = format!("run --rays primary,diffuse --tracer all,all:improved,{tracers} {scenes}");
        step("builds-and-frames", &run);
        step("front", &format!("pareto --rays {RAYS} --points 2 {scenes}"));
    } else if !whole {
        step("front", &format!("pareto --scene {SCENE} --rays {RAYS} --points 2 --samples {FEW_ROUNDS}"));
    }
    if !whole {
        tables().for_each(|name| step(&format!("{name}-few-rows"), &format!("table {name} --few-rows")));
        step("need", &format!("need --scene {SCENE} --rays {RAYS} --samples {FEW_ROUNDS}"));
    }
    step("fronts", &format!("pareto --scene {SCENE} --rays {RAYS}"));
    step("stability", "stability");
    if whole {
        step("needs", &format!("need --scene {SCENE} --rays {RAYS}"));
    }
    let tracers = builders(|family| family == Family::Bvh);
    step("scenes", &format!("run --scene all --tracer all,all:improved,{tracers} --rays all"));
    tables().for_each(|name| step(name, &format!("table {name}")));
    step("fronts-of-all-scenes", &format!("pareto --scene all --rays {RAYS}"));
    steps
}

/// Other ways to build: image-space structures in compute in the place of the rasterizer, hierarchies by their quickest builder.
fn builders(is_of: impl Fn(Family) -> bool) -> String {
    let of = |registration: &Registration| {
        let description = registration.describe();
        let build = description.parameters.into_iter().find(|parameter| ["build", "tree"].contains(&parameter.name))?;
        let Domain::Choice(values) = build.domain else { return None };
        let value = if registration.family == Family::Bvh { values.first() } else { values.last() };
        Some(format!("{}@{}={}", description.name, build.name, value?))
    };
    TRACERS.iter().filter(|registration| is_of(registration.family)).filter_map(of).join(",")
}

/// The tables and figures that stand beside published ones: of every paper the first, then of every paper the second, and so on.
fn experiments() -> impl Iterator<Item = &'static Experiment> {
    let of = |number: usize| {
        PAPERS.iter().filter_map(move |paper| {
            paper.experiments.iter().filter(|experiment| !experiment.published.is_empty()).nth(number)
        })
    };
    let most = PAPERS.iter().map(|paper| paper.experiments.len()).max().unwrap_or(0);
    (0..most).flat_map(of)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Proves that every table and figure beside published ones is there once in part and once whole, that every paper has had one before
    /// any has its second, and that where all is wanted whole nothing is measured in part.
    #[test]
    fn every_table_has_its_turn() {
        let known = PAPERS.iter().flat_map(|paper| paper.experiments.iter());
        let known: BTreeSet<&str> =
            known.filter(|experiment| !experiment.published.is_empty()).map(|experiment| experiment.name).collect();
        let tables = |steps: &[Step], part: bool| -> Vec<String> {
            let is_table = |step: &&Step| {
                step.arguments[0] == "table" && step.arguments.contains(&"--few-rows".to_owned()) == part
            };
            steps.iter().filter(is_table).map(|step| step.arguments[1].clone()).collect()
        };
        for (whole, part) in [(false, true), (false, false), (true, false)] {
            let found = tables(&steps(whole, false), part);
            assert_eq!(tables(&steps(whole, true), part), found);
            assert_eq!(found.len(), known.len());
            assert_eq!(found.iter().map(String::as_str).collect::<BTreeSet<_>>(), known);
            let first: BTreeSet<_> = found[..PAPERS.len()].iter().map(|name| name.split('-').next()).collect();
            assert_eq!(first.len(), PAPERS.len());
        }
        assert!(tables(&steps(true, true), true).is_empty());
    }

    /// Proves that folders are named once, and that the first step is the front.
    #[test]
    fn folders_are_told_apart() {
        for (whole, on_hardware) in [(false, false), (true, false), (false, true)] {
            let steps = steps(whole, on_hardware);
            let names: BTreeSet<&String> = steps.iter().map(|step| &step.name).collect();
            assert_eq!(names.len(), steps.len());
            assert_eq!(steps[0].arguments[0], if on_hardware { "run" } else { "pareto" });
        }
    }

    /// Proves that what hardware alone can tell has every rasterized structure built in compute as well, and quick hierarchies.
    #[test]
    fn builds_are_by_raster_and_in_compute() {
        let all = builders(|_| true);
        let hierarchies = ["bvh-cpu@build=fastest", "bvh-gpu@build=fastest", "ploc-gpu@tree=lbvh"];
        for wanted in hierarchies.iter().chain(&["dirt@build=compute", "quadtree@build=compute"]) {
            assert!(all.split(',').any(|found| found == *wanted), "{wanted}: {all}");
        }
        assert_eq!(builders(|family| family == Family::Bvh), hierarchies.join(","));
        assert!(crate::cli::names::tracers(&all, &[]).is_ok(), "{all}");
    }
}
