//! The papers' tables and figures as experiments: what is run, as data.

use tracebench_api::{EndPoint, Preset};

use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::rays::MOST_RAYS;
use crate::registry;

/// A paper's table or figure, measured here.
#[derive(Debug, PartialEq)]
pub struct Experiment {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// The paper's short name.
    pub paper: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Published tables that it stands beside, by id.
    pub published: &'static [&'static str],
    /// Scenes of the catalogue where nothing else is said, and what they stand for.
    pub scenes: &'static [StandIn],
    /// Ray sets where nothing else is said, as `--rays` takes them; none for an experiment without traces.
    pub rays: &'static str,
    /// Parameters of ray sets where nothing else is said, as `--set` takes them.
    pub settings: &'static [&'static str],
    /// How far traces go at least.
    pub end: EndPoint,
    /// What is run one after the other.
    pub steps: &'static [Step],
    /// What the page shows of it beside rows and claims.
    pub shown: &'static [Shown],
    /// Deviations and what is to be known.
    pub notes: &'static [&'static str],
}

/// A section of a page, or a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Rays a second, a row a scene and a column a kind, beside the published ones, as ratios to the last kind.
    Throughput,
    /// Bytes by Table 3's formula beside the ledger's.
    Formula,
    /// Build and traces of mixes of rays over resolution; a chart.
    Mixes,
    /// Memory, build, trace and tests over B by tile size; a chart.
    OverBuckets,
    /// Memory over resolution; a chart.
    MemoryOverResolution,
}

/// A scene of the catalogue in place of a paper's.
#[derive(Debug, PartialEq, Eq)]
pub struct StandIn {
    /// The scene of the catalogue.
    pub scene: &'static str,
    /// The paper's scene, as its tables name it.
    pub published: &'static str,
}

/// Contenders side by side at one resolution.
#[derive(Debug, PartialEq)]
pub struct Step {
    /// Factor on the edges of ray image, frame and faces.
    pub resolution: f64,
    /// Who runs.
    pub rows: &'static [Row],
}

/// A tracer with every combination of values of its parameters.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// The tracer.
    pub tracer: &'static str,
    /// Parameters with their values.
    pub values: &'static [(&'static str, &'static [&'static str])],
}

const fn stands_for(scene: &'static str, published: &'static str) -> StandIn {
    StandIn { scene, published }
}

const fn dirt(values: &'static [(&'static str, &'static [&'static str])]) -> Row {
    Row { tracer: "dirt", values }
}

/// DIRT with one tile size, beside hierarchies built on the device and on the host.
const fn beside_bvh(resolution: f64, rows: &'static [Row]) -> Step {
    Step { resolution, rows }
}

const LBVH: Row = Row { tracer: "lbvh-gpu", values: &[] };
const BVH: Row = Row { tracer: "bvh-gpu", values: &[] };
/// Figure 11: tiles of one pixel, one bucket.
const ONE_BUCKET: &[Row] = &[dirt(&[("tile_size", &["1"]), ("buckets", &["1"])])];

/// Every experiment.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "dirt-table1",
        paper: "dirt",
        summary: "rays a second by kind of ray (DIRT, Table 1)",
        published: &["dirt-table1"],
        scenes: &[
            stands_for("cloth", "Cloth"),
            stands_for("room", "Bunny"),
            stands_for("hangar", "Hangar"),
            stands_for("candy", "Candy"),
        ],
        rays: "visibility,specular,glossy,diffuse",
        settings: &["rays.visibility_target=outside"],
        end: EndPoint::Hit,
        steps: &[Step { resolution: 1.0, rows: &[dirt(&[("tile_size", &["1", "2"]), ("buckets", &["24"])])] }],
        shown: &[Shown::Throughput],
        notes: &[
            "Tiles of one pixel are the paper's by section 5 where nothing else is said, tiles of 2x2 those that it \
             recommends; it states no B.",
            "A rate is that of the trace alone, to the hit; whether the paper's has Fetch and Shade in it is not stated.",
        ],
    },
    Experiment {
        name: "dirt-table2",
        paper: "dirt",
        summary: "stored references, memory, build and trace with tiles of one pixel, coverage by sample and conservative \
                  (DIRT, Table 2)",
        published: &["dirt-table2", "dirt-table2-summary"],
        scenes: &[stands_for("room", "Bunny"), stands_for("hangar", "Hangar"), stands_for("candy", "Candy")],
        rays: "diffuse",
        settings: &[],
        end: EndPoint::Hit,
        steps: &[Step {
            resolution: 1.0,
            rows: &[dirt(&[("tile_size", &["1"]), ("buckets", &["4"]), ("coverage", &["standard", "conservative"])])],
        }],
        shown: &[],
        notes: &[
            "DIRT's side alone: VVP16 is not measured here.",
            "Coverage by sample loses what lies between samples: its times are those of searches that miss, so look at the \
             agreement beside them.",
            "B = 4 is VVP16's, which the paper does not repeat; which rays were traced it does not state: diffuse ones here.",
        ],
    },
    Experiment {
        name: "dirt-table3",
        paper: "dirt",
        summary: "bytes by the formula beside those of the ledger, over tile size and B (DIRT, Table 3)",
        published: &["dirt-table3", "dirt-node-sizes", "dirt-mipmaps"],
        scenes: &[
            stands_for("cloth", "Cloth"),
            stands_for("room", "Bunny"),
            stands_for("hangar", "Hangar"),
            stands_for("candy", "Candy"),
        ],
        rays: "",
        settings: &[],
        end: EndPoint::Hit,
        steps: &[Step {
            resolution: 1.0,
            rows: &[dirt(&[("tile_size", &["1", "2", "4"]), ("buckets", &["4", "24"])])],
        }],
        shown: &[Shown::Formula],
        notes: &[
            "The formula has the device's own counts in it: c n_p are the references stored, tiles those of six faces.",
            "Hit buffer, shading buffer and mask are not part of a structure and not measured here.",
        ],
    },
    Experiment {
        name: "dirt-figure8",
        paper: "dirt",
        summary: "build and trace over resolution with tiles growing along, beside BVHs rebuilt every frame (DIRT, Figure 8)",
        published: &["dirt-figure8"],
        scenes: &[stands_for("atrium", "Sponza")],
        rays: "primary,visibility,diffuse",
        settings: &["rays.visibility_target=outside"],
        end: EndPoint::Hit,
        steps: &[
            beside_bvh(0.25, &[dirt(&[("tile_size", &["1"])]), LBVH, BVH]),
            beside_bvh(0.5, &[dirt(&[("tile_size", &["2"])]), LBVH, BVH]),
            beside_bvh(1.0, &[dirt(&[("tile_size", &["4"])]), LBVH, BVH]),
            beside_bvh(2.0, &[dirt(&[("tile_size", &["8"])]), LBVH, BVH]),
        ],
        shown: &[Shown::Mixes],
        notes: &[
            "lbvh-gpu, built on the device, stands for HLBVH and TRBVH; bvh-gpu is built on the host and uploaded.",
            "Mixes are sums of medians: primary and visibility; primary and diffuse; primary, diffuse and twice visibility. \
             The second shadow ray starts at the secondary hit in the paper, here it is counted as another of the first.",
            "DIRT's primary rays are traced here, not rasterized. The paper's resolutions are lost with the figure.",
        ],
    },
    Experiment {
        name: "dirt-figure9",
        paper: "dirt",
        summary: "one view beside six (DIRT, Figure 9)",
        published: &["dirt-figure9"],
        scenes: &[stands_for("room", "Bunny"), stands_for("candy", "Candy")],
        rays: "primary,specular,diffuse",
        settings: &[],
        end: EndPoint::Hit,
        steps: &[Step { resolution: 1.0, rows: &[dirt(&[("views", &["six", "frame"])])] }],
        shown: &[],
        notes: &["There are no shadow maps here. The second scene of the paper's figure is not named."],
    },
    Experiment {
        name: "dirt-figure10",
        paper: "dirt",
        summary: "references, memory, build, trace and tests over B by tile size (DIRT, Figure 10)",
        published: &["dirt-figure10", "dirt-downscaling", "dirt-bucket-steps", "dirt-build-slope"],
        scenes: &[stands_for("cloth", "Cloth"), stands_for("room", "Bunny"), stands_for("candy", "Candy")],
        rays: "diffuse",
        settings: &[],
        end: EndPoint::Hit,
        steps: &[Step {
            resolution: 1.0,
            rows: &[dirt(&[("tile_size", &["1", "2", "4"]), ("buckets", &["8", "16", "24", "32", "40"])])],
        }],
        shown: &[Shown::OverBuckets],
        notes: &[
            "Which three scenes the paper's figure has is lost with it, as are its values of B. Fetch and Shade are not \
             measured here.",
            "Memory is that of the structure by its own ledger.",
        ],
    },
    Experiment {
        name: "dirt-figure11",
        paper: "dirt",
        summary: "memory over resolution with tiles of one pixel and one bucket (DIRT, Figure 11)",
        published: &["dirt-figure11"],
        scenes: &[
            stands_for("cloth", "Cloth"),
            stands_for("room", "Bunny"),
            stands_for("hangar", "Hangar"),
            stands_for("candy", "Candy"),
        ],
        rays: "primary",
        settings: &[],
        end: EndPoint::Surface,
        steps: &[
            Step { resolution: 0.25, rows: ONE_BUCKET },
            Step { resolution: 0.5, rows: ONE_BUCKET },
            Step { resolution: 1.0, rows: ONE_BUCKET },
            Step { resolution: 2.0, rows: ONE_BUCKET },
        ],
        shown: &[Shown::MemoryOverResolution],
        notes: &[
            "DIRT's side alone: VVP16 is not measured here. Which scenes the paper's figure has is lost with it.",
            "Memory is that of the structure and of the hit buffer, the mask and the shading buffer that a trace to surfaces takes, by \
             the ledger. Of the paper's three shading points one is allocated.",
        ],
    },
    Experiment {
        name: "dirt-text",
        paper: "dirt",
        summary: "what the text states beside its tables: coverage, acceptance, the early stop, tiles, path length (DIRT, \
                  sections 4 and 5)",
        published: &[],
        scenes: &[
            stands_for("cloth", "Cloth"),
            stands_for("room", "Bunny"),
            stands_for("hangar", "Hangar"),
            stands_for("candy", "Candy"),
        ],
        rays: "primary,specular,diffuse,bounce2",
        settings: &[],
        end: EndPoint::Hit,
        steps: &[
            Step {
                resolution: 1.0,
                rows: &[
                    dirt(&[("tile_size", &["1", "2", "4", "8"])]),
                    dirt(&[("tile_size", &["1"]), ("coverage", &["standard"])]),
                    dirt(&[("tile_size", &["2"]), ("searched", &["all"]), ("accept", &["tile", "distance"])]),
                    Row { tracer: "screen-dda", values: &[] },
                ],
            },
            Step { resolution: 0.5, rows: &[dirt(&[("tile_size", &["1", "4"])])] },
        ],
        shown: &[],
        notes: &["Rows that search all buckets or accept by distance are a proof's aid, not the method."],
    },
];

/// Finds an experiment by name.
pub fn find(name: &str) -> Option<&'static Experiment> {
    EXPERIMENTS.iter().find(|experiment| experiment.name == name)
}

/// Why an experiment cannot be run as asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rays} rays at {factor} times the resolution, {MOST_RAYS} are the most: turn down --size or --preset")]
pub struct TooManyRays {
    rays: u64,
    factor: String,
}

impl Experiment {
    /// The tracers of each step; a value in the published preset counts as named all the same, so that labels tell it.
    pub fn requests(&self) -> Vec<Vec<TracerRequest>> {
        self.steps.iter().map(|step| step.rows.iter().flat_map(Row::requests).collect()).collect()
    }

    /// What is to be run: the base plan at the resolution of every step, with its tracers.
    ///
    /// # Errors
    /// If a step has more rays than one set may have.
    pub fn plans(&self, base: &Plan, steps: &[Vec<TracerRequest>]) -> Result<Vec<Plan>, TooManyRays> {
        let plan = |(step, tracers): (&Step, &Vec<TracerRequest>)| {
            let preset = step.scaled(base.preset);
            let rays = preset.ray_image.map(u64::from).iter().product();
            if rays > MOST_RAYS {
                return Err(TooManyRays { rays, factor: step.resolution.to_string() });
            }
            let end = if base.end == EndPoint::Surface { base.end } else { self.end };
            Ok(Plan { preset, end, tracers: tracers.clone(), table: Some(self.name), ..base.clone() })
        };
        self.steps.iter().zip(steps).map(plan).collect()
    }

    /// The paper's scene that a scene stands for.
    pub fn stands_for(&self, scene: &str) -> Option<&'static str> {
        self.scenes.iter().find(|each| each.scene == scene).map(|each| each.published)
    }

    /// Whether a tracer of this name belongs into the table.
    pub fn holds(&self, tracer: &str) -> bool {
        self.steps.iter().flat_map(|step| step.rows).any(|row| row.tracer == tracer)
    }
}

impl Step {
    fn scaled(&self, preset: RunPreset) -> RunPreset {
        let edge = |pixels: u32| ((f64::from(pixels) * self.resolution).round() as u32).max(1);
        RunPreset {
            ray_image: preset.ray_image.map(edge),
            frame: preset.frame.map(edge),
            face: edge(preset.face),
            ..preset
        }
    }
}

impl Row {
    fn requests(&self) -> Vec<TracerRequest> {
        let Some(registration) = registry::find(self.tracer) else { return Vec::new() };
        let mut requests = vec![TracerRequest::of(registration, Preset::Published)];
        for (parameter, values) in self.values {
            let with = |request: &TracerRequest, value: &str| {
                let mut request = request.clone();
                // A test holds every value against its parameter's range.
                request.set(parameter, value).is_ok().then_some(request)
            };
            requests =
                requests.iter().flat_map(|request| values.iter().filter_map(|each| with(request, each))).collect();
        }
        requests
    }
}
