//! DIRT's tables and figures.

use tracebench_api::TraceTo;

use super::{charts, sections};
use crate::papers::experiment::{Experiment, ExperimentRow, StandIn, Values, at, once, peer, stands_for};
use crate::papers::page::beside::beside;
use crate::papers::vvp16::{ABUFFER, BUILT_ON_DEVICE, abuffer};
use crate::papers::wkp15::quadtree;
use crate::papers::{hhz14, wkp15};

/// Every one, in the order of lists.
pub(super) const EXPERIMENTS: &[Experiment] =
    &[TABLE1, TABLE2, TABLE3, FIGURE7, FIGURE8, FIGURE9, FIGURE10, FIGURE11, FAMILIES, TEXT];

const fn dirt(values: Values) -> ExperimentRow {
    ExperimentRow { tracer: "dirt", values }
}

/// Thickness of VVP16's fragments, which DIRT's authors tuned a scene without telling the values: a width of a pixel where the
/// ray is.
const THICKNESS: (&str, &[&str]) = ("thickness", &["1"]);
const IN_PIXELS: (&str, &[&str]) = ("thickness_in", &["pixels"]);

/// Figure 11: tiles of one pixel, one bucket.
const ONE_BUCKET: &[ExperimentRow] = &[
    dirt(&[("tile_size", &["1"]), ("buckets", &["1"])]),
    abuffer(&[("views", &["seven"]), ("storage", &["dllb"]), ("buckets", &["1"]), IN_PIXELS, THICKNESS]),
];
/// The scenes of Table 1.
const ALL_SCENES: &[StandIn] = &[
    stands_for("cloth", "Cloth"),
    stands_for("room", "Bunny"),
    stands_for("hangar", "Hangar"),
    stands_for("candy", "Candy"),
];
const BVH: ExperimentRow = peer("bvh-gpu");

/// Table 1.
const TABLE1: Experiment = Experiment {
    name: "dirt-table1",
    summary: "rays a second by kind of ray (DIRT, Table 1)",
    published: &["dirt-table1"],
    scenes: ALL_SCENES,
    rays: "visibility,specular,glossy,diffuse",
    settings: &["rays.visibility_target=outside"],
    steps: &once(&[dirt(&[("tile_size", &["1", "2"]), ("buckets", &["24"])])]),
    sections: &[sections::throughput],
    notes: &[
        "Tiles of one pixel are the paper's by section 5 where nothing else is said, tiles of 2x2 those that it \
         recommends; it states no B.",
        "A rate is that of the trace alone, to the hit; whether the paper's has Fetch and Shade in it is not stated.",
    ],
    ..Experiment::DEFAULT
};

/// Table 2.
const TABLE2: Experiment = Experiment {
    name: "dirt-table2",
    summary: "stored references, memory, build and trace with tiles of one pixel, coverage by sample and conservative, beside \
              the fragment A-buffer (DIRT, Table 2)",
    published: &["dirt-table2", "dirt-table2-summary"],
    scenes: &[stands_for("room", "Bunny"), stands_for("hangar", "Hangar"), stands_for("candy", "Candy")],
    rays: "diffuse,specular",
    trace_to: TraceTo::Surface,
    steps: &once(&[
        dirt(&[("tile_size", &["1"]), ("buckets", &["4"]), ("coverage", &["standard", "conservative"])]),
        abuffer(&[("views", &["seven"]), ("storage", &["dllb"]), ("buckets", &["4"])]),
        abuffer(&[("views", &["seven"]), ("storage", &["dllb"]), ("buckets", &["4"]), IN_PIXELS, THICKNESS]),
    ]),
    sections: &[|page| beside(page, ABUFFER), sections::copies],
    notes: &[
        "Traces go to surfaces: VVP16 stores what shading needs with every fragment, DIRT fetches it of hits. With the paper's own \
         buffers DIRT has hit buffer, mask and shading buffer as its Table 3 counts them, a ray from every pixel of the frame and \
         three shading points.",
        "The thickness of VVP16's fragments was tuned a scene in the paper, to values that it does not tell. `--tuned RUN` has the first of \
         its rows at what a tuning found best from another viewpoint of the same scene, told in the label; without it that row has none, \
         as VVP16's section 3.4. The second has a pixel's width, the same in every scene. Claims look at the first.",
        "Coverage by sample loses what lies between samples: its times are those of searches that miss, so look at the \
         agreement beside them.",
        "B = 4 is VVP16's, which the paper does not repeat; which rays were traced it does not state: diffuse ones here. \
         Mirror rays, few where few surfaces are mirrors, show what Fetch takes of them.",
    ],
    ..Experiment::DEFAULT
};

/// Table 3.
const TABLE3: Experiment = Experiment {
    name: "dirt-table3",
    summary: "bytes by the formula beside those of the ledger, over tile size and B (DIRT, Table 3)",
    published: &["dirt-table3", "dirt-node-sizes", "dirt-mipmaps"],
    scenes: ALL_SCENES,
    steps: &once(&[dirt(&[("tile_size", &["1", "2", "4"]), ("buckets", &["4", "24"])])]),
    sections: &[sections::formula],
    notes: &[
        "The formula has the device's own counts in it: c n_p are the references stored, tiles those of six faces.",
        "Hit buffer, shading buffer and mask are not part of a structure and not measured here.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 7.
const FIGURE7: Experiment = Experiment {
    name: "dirt-figure7",
    summary: "analytic hits beside fragments of four thicknesses (DIRT, Figure 7)",
    published: &["dirt-figure7"],
    scenes: &[stands_for("room", "Bunny")],
    rays: "specular,diffuse,bounce2",
    steps: &once(&[
        dirt(&[("tile_size", &["1"])]),
        abuffer(&[("views", &["seven"]), ("storage", &["dllb"]), IN_PIXELS, ("thickness", &["0", "1", "4", "16"])]),
    ]),
    notes: &[
        "VVP16's thickness is varied in widths of a pixel where the ray is; the paper's three values are not told.",
        "The paper's pictures have two indirect bounces; here these are the sets diffuse and bounce2, and mirrors, where it says that \
         thickness shows most, are the set specular.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 8.
const FIGURE8: Experiment = Experiment {
    name: "dirt-figure8",
    summary: "build and trace over resolution with tiles growing along, beside BVHs rebuilt every frame (DIRT, Figure 8)",
    published: &["dirt-figure8"],
    scenes: &[stands_for("atrium", "Sponza")],
    rays: "primary,visibility,diffuse",
    settings: &["rays.visibility_target=outside"],
    steps: &[
        at(0.25, &[dirt(&[("tile_size", &["1"])]), BUILT_ON_DEVICE, BVH]),
        at(0.5, &[dirt(&[("tile_size", &["2"])]), BUILT_ON_DEVICE, BVH]),
        at(1.0, &[dirt(&[("tile_size", &["4"])]), BUILT_ON_DEVICE, BVH]),
        at(2.0, &[dirt(&[("tile_size", &["8"])]), BUILT_ON_DEVICE, BVH]),
    ],
    launch: true,
    sections: &[sections::mixes],
    charts: &[charts::mixes],
    notes: &[
        "ploc-gpu, built on the device, stands for HLBVH (tree=lbvh) and TRBVH; claims look at the quicker tree. bvh-gpu is built on the \
         host and uploaded.",
        "Mixes are sums of medians: primary and visibility; primary and diffuse; primary, diffuse and twice visibility. \
         The second shadow ray starts at the secondary hit in the paper, here it is counted as another of the first.",
        "DIRT's primary rays are traced here, not rasterized. The paper's resolutions are lost with the figure.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 9.
const FIGURE9: Experiment = Experiment {
    name: "dirt-figure9",
    summary: "one view beside six (DIRT, Figure 9)",
    published: &["dirt-figure9"],
    scenes: &[stands_for("room", "Bunny"), stands_for("candy", "Candy")],
    rays: "primary,specular,diffuse,visibility",
    settings: &["rays.visibility_target=outside"],
    steps: &once(&[dirt(&[("views", &["six", "frame"])]), dirt(&[("views", &["frame"]), ("shadow_map", &["on"])])]),
    notes: &[
        "In the last row a shadow map from the light outside of the scene, drawn by the build, answers the visibility rays; the paper \
         states neither its lights nor its maps' resolution. The second scene of the paper's figure is not named; Candy is the one here.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 10.
const FIGURE10: Experiment = Experiment {
    name: "dirt-figure10",
    summary: "references, memory, build, trace and tests over B by tile size (DIRT, Figure 10)",
    published: &["dirt-figure10", "dirt-downscaling", "dirt-bucket-steps", "dirt-build-slope"],
    scenes: &[stands_for("cloth", "Cloth"), stands_for("room", "Bunny"), stands_for("candy", "Candy")],
    rays: "diffuse",
    trace_to: TraceTo::Surface,
    steps: &once(&[dirt(&[("tile_size", &["1", "2", "4"]), ("buckets", &["8", "16", "24", "32", "40"])])]),
    sections: &[sections::copies],
    charts: &[charts::over_buckets],
    notes: &[
        "Which three scenes the paper's figure has is lost with it, as are its values of B. Traces go to surfaces: Fetch is the phases \
         mask and fetch. There is no Shade, which the paper times apart: nothing is lit here.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 11.
const FIGURE11: Experiment = Experiment {
    name: "dirt-figure11",
    summary: "memory over resolution with tiles of one pixel and one bucket, beside the fragment A-buffer (DIRT, Figure 11)",
    published: &["dirt-figure11"],
    scenes: ALL_SCENES,
    rays: "primary",
    trace_to: TraceTo::Surface,
    steps: &[at(0.25, ONE_BUCKET), at(0.5, ONE_BUCKET), at(1.0, ONE_BUCKET), at(2.0, ONE_BUCKET)],
    charts: &[charts::memory_over_resolution],
    notes: &[
        "VVP16 has the camera's view beside the six faces. Which scenes the paper's figure has is lost with it.",
        "By the ledger a trace to surfaces has one of the paper's three shading points, and as many as there are rays; with the paper's \
         own buffers there are three a pixel of the frame.",
    ],
    ..Experiment::DEFAULT
};

/// Section 2.
const FAMILIES: Experiment = Experiment {
    name: "dirt-families",
    summary: "build, memory and accuracy of a method of every family that came before, beside DIRT (DIRT, section 2)",
    scenes: &[stands_for("room", "Bunny"), stands_for("hangar", "Hangar"), stands_for("candy", "Candy")],
    rays: "diffuse,specular",
    steps: &once(&[
        ExperimentRow { tracer: wkp15::DDA, values: &[("layers", &["1", "2"])] },
        quadtree(&[("layers", &["2"]), ("views", &["frame"])]),
        quadtree(&[("layers", &["1"]), ("views", &["six"])]),
        peer(hhz14::ABUFFER),
        abuffer(&[]),
        dirt(&[("tile_size", &["2"])]),
    ]),
    sections: &[|page| beside(page, wkp15::DDA)],
    notes: &[
        "In the order of the paper: a G-buffer is screen-dda, depth peeling its two layers, a k-buffer the two layers of the quadtree, a cube \
         of G-buffers the quadtree's six faces of one layer, three orthographic A-buffers are voxel-abuffer, the cube of A-buffers is \
         fragment-abuffer. Each is its own paper's method, so that more than the storage differs.",
        "Memory is the structure alone, without what a trace to surfaces fetches.",
    ],
    ..Experiment::DEFAULT
};

/// What the text states beside them.
const TEXT: Experiment = Experiment {
    name: "dirt-text",
    summary: "what the text states beside its tables: coverage, acceptance, the early stop, tiles, path length, direct visibility, no pyramid \
              (DIRT, sections 4 and 5)",
    scenes: ALL_SCENES,
    rays: "primary,specular,diffuse,bounce2",
    steps: &[
        at(
            1.0,
            &[
                dirt(&[("tile_size", &["1", "2", "4", "8"])]),
                dirt(&[("tile_size", &["1"]), ("coverage", &["standard"])]),
                dirt(&[("tile_size", &["2"]), ("searched", &["all"]), ("accept", &["tile", "distance"])]),
                dirt(&[("tile_size", &["2"]), ("direct_visibility", &["on"])]),
                dirt(&[("tile_size", &["2"]), ("march", &["tiles"])]),
            ],
        ),
        at(0.5, &[dirt(&[("tile_size", &["1", "4"])])]),
    ],
    notes: &["Rows that search all buckets or accept by distance are a proof's aid, not the method."],
    ..Experiment::DEFAULT
};
