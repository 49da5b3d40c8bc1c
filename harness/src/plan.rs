//! What is to be run: presets, scenes, tracers, rays, resolutions.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde_json::json;
use tracebench_api::{ParameterError, ParameterScope, Parameters, Preset, TraceTo, Value};

use crate::hash::sha256_of_file;
use crate::rays::RaySet;
use crate::registry::Registration;
use crate::results::{Adaptive, MIN_ROUNDS, SampleSchedule};
use crate::viewpoint::Pose;

/// Largest edge of a frame or image, pixels.
pub const LARGEST_EDGE: u32 = 16_384;

/// Largest edge of a cube face, pixels.
pub const LARGEST_FACE: u32 = 8_192;

/// Reads a number within a range, of which words say what it is.
pub(crate) fn within(
    range: RangeInclusive<f64>,
    words: impl Into<String>,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    let words = words.into();
    move |text| text.parse().ok().filter(|number| range.contains(number)).ok_or_else(|| words.clone())
}

/// A run preset sets rays, resolutions, samples and the scale of procedural scenes, nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunPreset {
    /// Name.
    pub name: &'static str,
    /// Width and height of the image from whose pixels rays start.
    pub ray_image: [u32; 2],
    /// Width and height of the frame.
    pub frame: [u32; 2],
    /// Edge of a cube face.
    pub face: u32,
    /// How long times are sampled.
    pub sampling: SampleSchedule,
    /// Scale factor of procedural scenes.
    pub scene_scale: f64,
}

/// How long times are sampled where nothing else is said. An interval of 15 % from end to end tells a slowdown of 15 % apart; how
/// often it does under recorded noise is what the test of the clock says.
pub const SAMPLING: SampleSchedule =
    SampleSchedule { min_rounds: MIN_ROUNDS, adaptive: Some(Adaptive { ratio_precision: 0.15, time_limit_s: 20.0 }) };

/// Every run preset. `paper` is the set-up of DIRT (HPG 2016, section 5): 1024x512, faces of 512.
pub const RUN_PRESETS: [RunPreset; 3] = [
    RunPreset::of("smoke", [[64, 32], [128, 64]], 64, SampleSchedule::rounds(3), 0.05),
    RunPreset::of("quick", [[256, 128], [512, 256]], 256, SAMPLING, 1.0),
    RunPreset::of("paper", [[1024, 512], [1024, 512]], 512, SAMPLING, 1.0),
];

impl RunPreset {
    const fn of(
        name: &'static str,
        [ray_image, frame]: [[u32; 2]; 2],
        face: u32,
        sampling: SampleSchedule,
        scene_scale: f64,
    ) -> Self {
        Self { name, ray_image, frame, face, sampling, scene_scale }
    }

    /// Finds a preset.
    pub fn named(name: &str) -> Option<Self> {
        RUN_PRESETS.into_iter().find(|preset| preset.name == name)
    }

    /// The default: quick on software adapters and without one, paper on hardware.
    pub fn for_adapter(hardware: bool) -> Self {
        if hardware { RUN_PRESETS[2] } else { RUN_PRESETS[1] }
    }
}

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum SceneSource {
    /// A scene of the catalogue.
    Catalogue(String),
    /// A .gltf or .glb file.
    File {
        /// The path as it was given.
        path: PathBuf,
        /// What its scene is called.
        name: String,
    },
}

impl SceneSource {
    /// What the scene is called.
    pub fn name(&self) -> &str {
        match self {
            Self::Catalogue(name) | Self::File { name, .. } => name,
        }
    }
}

/// The name in the catalogue, or the path as it was given.
impl std::fmt::Display for SceneSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Catalogue(name) => f.write_str(name),
            Self::File { path, .. } => path.display().fmt(f),
        }
    }
}

/// A viewpoint asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewRequest {
    /// The scene's first camera, else the one that the rule finds.
    Default,
    /// A camera of the scene by name; else the pose that the text is, as [`Pose::parse`] reads it.
    Named(String),
    /// A given pose.
    Given(Pose),
    /// Another one of the same scene than a request means, by the rule of [`crate::viewpoint::other`].
    Other(Box<ViewRequest>),
    /// The camera of this place; where the scene has fewer the default eye, by so many parts of a circle further.
    Nth(usize, usize),
}

/// Resolutions from which a structure takes its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Width and height of the frame, pixels.
    pub frame: [u32; 2],
    /// Edge of a cube face, pixels.
    pub face: u32,
}

/// A tracer asked for.
#[derive(Clone)]
pub struct TracerRequest {
    /// Which.
    pub registration: Registration,
    /// From which preset.
    pub preset: Preset,
    /// With which values.
    pub parameters: Parameters,
    /// Parameters that `--set` changed.
    pub changed: Vec<String>,
    /// Asked for by name: not being able to run it is an error.
    pub required: bool,
    /// A resolution of its own, in place of the viewpoint's; the rays are those of the plan.
    pub resolution: Option<Resolution>,
}

impl TracerRequest {
    /// A tracer with the values of a preset, not required.
    pub fn of(registration: &Registration, preset: Preset) -> Self {
        let parameters = Parameters::preset(&registration.describe().parameters, preset);
        Self { registration: *registration, preset, parameters, changed: Vec::new(), required: false, resolution: None }
    }

    /// The same in every form that it stands in where all tracers do.
    pub fn forms(registration: &Registration, preset: Preset) -> Vec<Self> {
        let plain = Self::of(registration, preset);
        let form = |settings: &Vec<(&str, &str)>| plain.clone().with(settings).ok();
        std::iter::once(plain.clone()).chain(registration.forms.iter().filter_map(form)).collect()
    }

    /// The tracer's name.
    pub fn name(&self) -> &'static str {
        self.registration.describe().name
    }

    /// With other values of some parameters.
    ///
    /// # Errors
    /// As [`Parameters::set`].
    pub fn with(mut self, values: &[(&str, &str)]) -> Result<Self, ParameterError> {
        values.iter().try_for_each(|(parameter, value)| self.set(parameter, value))?;
        Ok(self)
    }

    /// Sets one parameter from text; it counts as changed from then on.
    ///
    /// # Errors
    /// As [`Parameters::set`]; nothing has changed then.
    pub fn set(&mut self, parameter: &str, value: &str) -> Result<(), ParameterError> {
        let mut parameters = self.parameters.clone();
        parameters.set(&self.registration.describe().parameters, parameter, value)?;
        if let Some(other) = self.registration.with_part(parameter, value) {
            // What the part before has by its preset is not the new one's; what was asked for is, or is refused.
            let own = format!("{parameter}.");
            let described = other.describe().parameters;
            let kept = std::mem::replace(&mut parameters, Parameters::preset(&described, self.preset));
            let is_kept = |name: &str| !name.starts_with(&own) || self.changed.iter().any(|changed| changed == name);
            for (name, value) in kept.iter().filter(|(name, _)| is_kept(name)) {
                parameters.set(&described, name, &value.to_string())?;
            }
            self.registration = other;
        }
        self.parameters = parameters;
        if !self.changed.iter().any(|name| name == parameter) {
            self.changed.push(parameter.to_owned());
        }
        Ok(())
    }

    /// The values that shape its structure.
    fn build_parameters(&self) -> Vec<(&str, &Value)> {
        let described = self.registration.describe().parameters;
        let shapes = |name: &str| described.iter().any(|of| of.name == name && of.scope == ParameterScope::Build);
        self.parameters.iter().filter(|(name, _)| shapes(name)).collect()
    }

    /// Whether one structure serves both: they differ in parameters of the trace alone.
    pub fn shares_structure_with(&self, other: &Self) -> bool {
        (self.name(), self.resolution) == (other.name(), other.resolution)
            && self.build_parameters() == other.build_parameters()
    }

    /// The tracer as `--tracer` takes it.
    pub fn argument(&self) -> String {
        let own = self.parameters.iter().filter(|(name, _)| self.changed.iter().any(|changed| changed == name));
        let own: String = own.map(|(name, value)| format!("@{name}={value}")).collect();
        let preset = match self.preset {
            Preset::Published => String::new(),
            Preset::Improved => format!(":{}", self.preset.name()),
        };
        format!("{}{preset}{own}", self.name())
    }

    /// Whether the run fails without a device.
    pub fn must_have_device(&self) -> bool {
        self.required && self.registration.needs_device()
    }
}

/// A whole run.
#[derive(Clone)]
pub struct Plan {
    /// The scenes.
    pub scenes: Vec<SceneSource>,
    /// The tracers.
    pub tracers: Vec<TracerRequest>,
    /// The ray sets.
    pub ray_sets: Vec<RaySet>,
    /// What is said about them: values of [`crate::rays::ray_parameters`].
    pub ray_parameters: Parameters,
    /// Preset with every override applied.
    pub preset: RunPreset,
    /// The viewpoint.
    pub view: ViewRequest,
    /// Animation time, seconds.
    pub time_s: f64,
    /// Seed of the ray sets.
    pub seed: u64,
    /// How far traces go.
    pub trace_to: TraceTo,
    /// Whether builds are timed where traces are: else everything is built once.
    pub builds_timed: bool,
    /// How many wrong rays of each cause a row keeps.
    pub wrong_rays_per_cause: usize,
    /// Name of the table that the run is made for, if it is made for one.
    pub table: Option<&'static str>,
}

impl Plan {
    /// Everything that it says, as data, with the hashes of files: plans of the same words mean the same work. What a .gltf names beside
    /// itself is not read here.
    pub fn describe(&self) -> serde_json::Value {
        let file = |source: &SceneSource| match source {
            SceneSource::Catalogue(_) => None,
            SceneSource::File { path, .. } => sha256_of_file(path),
        };
        let tracer = |request: &TracerRequest| {
            let resolution = request.resolution.map(|of| (of.frame, of.face));
            json!({ "name": request.name(), "preset": request.preset.name(), "parameters": request.parameters,
                    "changed": request.changed, "required": request.required, "resolution": resolution })
        };
        let RunPreset { name, ray_image, frame, face, sampling, scene_scale } = self.preset;
        json!({
            "scenes": self.scenes.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "files_sha256": self.scenes.iter().map(file).collect::<Vec<_>>(),
            "tracers": self.tracers.iter().map(tracer).collect::<Vec<_>>(),
            "rays": self.ray_sets.iter().map(RaySet::describe).collect::<Vec<_>>(),
            "ray_parameters": self.ray_parameters,
            "preset": name, "ray_image": ray_image, "frame": frame, "face": face, "sampling": sampling,
            "scene_scale": scene_scale, "view": format!("{:?}", self.view), "time_s": self.time_s, "seed": self.seed,
            "trace_to": self.trace_to, "builds_timed": self.builds_timed,
            "wrong_rays_per_cause": self.wrong_rays_per_cause, "table": self.table,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The presets are what the documentation says, given here as plain numbers.
    #[test]
    fn presets_are_the_documented_ones() {
        let found = RUN_PRESETS.map(|preset| {
            let SampleSchedule { min_rounds, adaptive } = preset.sampling;
            let adaptive = adaptive.map(|adaptive| (adaptive.ratio_precision, adaptive.time_limit_s));
            (preset.name, preset.ray_image, preset.frame, preset.face, (min_rounds, adaptive), preset.scene_scale)
        });
        let on = (12, Some((0.15, 20.0)));
        assert_eq!(
            found,
            [
                ("smoke", [64, 32], [128, 64], 64, (3, None), 0.05),
                ("quick", [256, 128], [512, 256], 256, on, 1.0),
                ("paper", [1024, 512], [1024, 512], 512, on, 1.0),
            ]
        );
        assert_eq!(RunPreset::for_adapter(false).name, "quick");
        assert_eq!(RunPreset::for_adapter(true).name, "paper");
    }
}
