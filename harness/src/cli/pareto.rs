//! `pareto`.

use std::ffi::OsString;

use clap::Args;
use serde_json::json;

use super::arguments::{Selection, WorkArguments, within};
use super::work::{Clock, Work};
use super::{CliError, names};
use crate::progress::Progress;
use crate::report;
use crate::studies::pareto::{DEFAULT_POINTS, Extent, MAX_POINTS, Pareto, RAYS_PER_PIXEL};

#[derive(Args)]
pub(super) struct ParetoArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, all, or all:improved. The presets of one tracer share its points.
    #[arg(long, default_value = "all,all:improved")]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "diffuse,ao")]
    rays: String,
    /// The most points of a tracer, over its parameters and resolutions; fewer are the first of more.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_POINTS as u32, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u32).range(1..=MAX_POINTS as i64))]
    points: u32,
    /// Rays a pixel of which the time of a frame is told, with the build; several with commas.
    #[arg(long, value_name = "K,K", value_delimiter = ',', default_values_t = RAYS_PER_PIXEL,
          value_parser = within(0.001..=1e6, "a number of rays from 0.001 to 1000000"))]
    rays_per_pixel: Vec<f64>,
    #[command(flatten)]
    work: WorkArguments,
}

/// More frames than these have no room on a page.
const MAX_FRAMES: usize = 3;

impl ParetoArguments {
    fn selection(&self) -> Result<Selection, CliError> {
        let tracers = names::tracers(&self.tracer, &self.work.common.settings);
        Ok(Selection { between_samples: true, ..Selection::of(&self.scene, tracers, &self.rays)? })
    }

    fn extent(&self) -> Result<Extent, CliError> {
        let mut rays_per_pixel = self.rays_per_pixel.clone();
        rays_per_pixel.sort_by(f64::total_cmp);
        rays_per_pixel.dedup();
        if rays_per_pixel.len() > MAX_FRAMES {
            return Err(CliError::Argument(format!("--rays-per-pixel: {MAX_FRAMES} numbers are the most")));
        }
        Ok(Extent { max_points: self.points as usize, rays_per_pixel })
    }
}

pub(super) fn pareto(arguments: &ParetoArguments, progress: &Progress) -> Result<(), CliError> {
    // Arguments are checked before any device or file is touched.
    let extent = arguments.extent()?;
    let refused = |error: crate::studies::sweep::SweepError| CliError::Argument(error.to_string());
    Pareto::new(&arguments.work.plan(arguments.selection()?, || false)?, &extent).map_err(refused)?;
    let work = Work::prepare(&arguments.work, || arguments.selection(), Clock::Timed, progress)?;
    // By the launch settings and the preset that it has here.
    let pareto = Pareto::new(&work.plan, &extent).map_err(refused).inspect_err(|_| work.bench.out.abandon())?;
    progress.say(&format!("{} points", pareto.size()));
    let words = json!({ "max_points": extent.max_points, "rays_per_pixel": extent.rays_per_pixel });
    work.study("pareto", words, report::PARETO_PAGE, progress, |context| pareto.execute(context)).map(drop)
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        pareto: ParetoArguments,
    }

    fn parse(arguments: &[&str]) -> Result<(Extent, usize), String> {
        let line = Line::try_parse_from([&["pareto"], arguments].concat()).map_err(|error| error.to_string())?;
        let extent = line.pareto.extent().map_err(|error| error.to_string())?;
        let plan = line.pareto.selection().and_then(|selection| line.pareto.work.plan(selection, || false));
        let pareto = Pareto::new(&plan.map_err(|error| error.to_string())?, &extent);
        Ok((extent, pareto.map_err(|error| error.to_string())?.size()))
    }

    /// Proves that every tracer is there where none is named, that no tracer has more points than are asked for, and that what makes no
    /// sense is refused with what does.
    #[test]
    fn arguments_make_fronts() {
        let (extent, all) = parse(&[]).unwrap();
        assert_eq!(extent, Extent::default());
        let (_, few) = parse(&["--points", "1"]).unwrap();
        assert_eq!(few, crate::registry::TRACERS.len());
        assert!(few < all && all <= few * DEFAULT_POINTS);
        let (extent, dirt) = parse(&["--tracer", "dirt", "--points", "5", "--rays-per-pixel", "8,2,8"]).unwrap();
        assert_eq!((extent.rays_per_pixel, dirt), (vec![2.0, 8.0], 5));
        for (arguments, part) in [
            (&["--points", "0"][..], "1..=256"),
            (&["--points", "-1"], "1..=256"),
            (&["--rays-per-pixel", "0"], "0.001"),
            (&["--rays-per-pixel", "1,2,3,4"], "3 numbers"),
            (&["--tracer", "dirtt"], "'dirt'"),
            (&["--scene", "rooom"], "'room'"),
        ] {
            let error = parse(arguments).unwrap_err();
            assert!(error.contains(part), "{arguments:?}: {error}");
        }
    }
}
