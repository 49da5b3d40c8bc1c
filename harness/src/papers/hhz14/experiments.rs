//! HHZ14's tables and figures.

use tracebench_api::TraceTo;

use super::{ABUFFER, DEPTH_IMAGES, SAMPLES, abuffer, octree, sections};
use crate::papers::experiment::{Experiment, ExperimentRow, StandIn, of_rays, once, peer, stands_for};
use crate::papers::page::beside::beside;

/// Every one, in the order of lists.
pub(super) const EXPERIMENTS: &[Experiment] = &[TABLE1, FIGURE6, FIGURE7, FIGURE9, FIGURE11, TEXT, SCENES];

/// The search that the paper takes for the truth, and the one that it finds enough.
const BOTH: (&str, &[&str]) = ("search", &["dda2d", "three-step"]);

/// The images of Table 1, of closed objects that mirror, refract and cast shadows.
const OF_TABLE_1: &[StandIn] = &[stands_for("solids", "Figure 8 top"), stands_for("candy", "Figure 1(b)")];

/// Table 1.
const TABLE1: Experiment = Experiment {
    name: "hhz14-table1",
    summary: "build and traces of mirrored, refracted and shadow rays beside a sparse voxel octree and depth images (HHZ14, Table 1)",
    published: &["hhz14-table1"],
    scenes: OF_TABLE_1,
    rays: "specular,refraction,visibility",
    trace_to: TraceTo::Surface,
    steps: &once(&[
        abuffer(&[("abuffer", &["1024"]), ("grid", &["64"]), BOTH]),
        octree(&[("levels", &["10"]), ("traversal", &["restart", "stack"])]),
        peer(DEPTH_IMAGES[0]),
        peer(DEPTH_IMAGES[1]),
    ]),
    launch: true,
    sections: &[sections::octree],
    notes: &[
        "The paper names neither the models of its images nor how many rays a frame has: ratios alone stand beside its own. Here a frame \
         is the three ray sets once each; their times are added up.",
        "A-buffers are 1024 square, as finely divided as the octree's ten levels, which is what the text sets against one another; the \
         table itself may have the paper's usual 1280.",
        "The octree is built from below on the device; how the paper builds its own is not stated.",
        "Two methods over depth images stand for the solutions by rasterization that section 6 speaks of.",
    ],
    ..Experiment::DEFAULT
};

const SEARCHES: &[&str] = &["dda2d", "three-step", "one-step"];
/// Closed objects with fine parts, as the teapot's spout and the dragon's horns.
const OF_FIGURE_6: &[StandIn] =
    &[stands_for("solids", "Figure 6"), stands_for("room", "Figure 6"), stands_for("candy", "Figure 6")];

/// Figure 6.
const FIGURE6: Experiment = Experiment {
    name: "hhz14-figure6",
    summary: "search in every texel, in three steps and in one (HHZ14, Figure 6)",
    published: &["hhz14-figure6"],
    scenes: OF_FIGURE_6,
    rays: "specular,refraction,visibility,ao",
    steps: &once(&[abuffer(&[("abuffer", &["1024"]), ("grid", &["64"]), ("search", SEARCHES)])]),
    sections: &[|page| beside(page, ABUFFER)],
    notes: &[
        "The figure's frame rates are lost with its pictures. It has 128 rays a fragment of ambient occlusion, here is one.",
    ],
    ..Experiment::DEFAULT
};

const SAMPLED: &[ExperimentRow] = &[abuffer(&[BOTH])];

/// Figure 7.
const FIGURE7: Experiment = Experiment {
    name: "hhz14-figure7",
    summary: "the time of a sample of a pixel's hemisphere, over the number of samples (HHZ14, Figure 7)",
    published: &["hhz14-figure7"],
    scenes: OF_FIGURE_6,
    rays: SAMPLES,
    steps: &[
        of_rays(&[("pixel_random_count", "1")], SAMPLED),
        of_rays(&[("pixel_random_count", "4")], SAMPLED),
        of_rays(&[("pixel_random_count", "16")], SAMPLED),
    ],
    sections: &[sections::a_ray],
    notes: &[
        "The ray set of ambient occlusion has one ray a pixel. So the samples are rays over the whole hemisphere, to their nearest hit, in \
         the same grid and images. `--size 800x600` has the paper's pixels.",
    ],
    ..Experiment::DEFAULT
};

const GRIDS: &[&str] = &["64", "128", "256", "512", "1024"];

/// Figure 9.
const FIGURE9: Experiment = Experiment {
    name: "hhz14-figure9",
    summary: "grid and A-buffers beside voxels alone (HHZ14, Figure 9)",
    published: &["hhz14-figure9", "hhz14-voxels-alone"],
    scenes: OF_FIGURE_6,
    rays: "ao,diffuse",
    steps: &once(&[
        abuffer(&[BOTH]),
        abuffer(&[("abuffer", &["1024"]), BOTH]),
        abuffer(&[("structure", &["voxels-only"]), ("grid", GRIDS)]),
    ]),
    sections: &[|page| beside(page, ABUFFER)],
    notes: &[
        "Voxels alone go to 1024 along an edge here, a bit each; the paper says that 1280 would serve. How many rays a fragment each \
         picture has is lost; here is one.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 11.
const FIGURE11: Experiment = Experiment {
    name: "hhz14-figure11",
    summary: "paths of two bounces in a complex scene, with a grid of 256 beside the usual one (HHZ14, Figure 11)",
    published: &["hhz14-figure11"],
    scenes: &[stands_for("atrium", "Sponza")],
    rays: "diffuse,bounce2",
    steps: &once(&[abuffer(&[("grid", &["256", "64"]), BOTH])]),
    sections: &[|page| beside(page, ABUFFER)],
    notes: &["The paper does not say how many rays its paths have, so that its times stand beside nothing here."],
    ..Experiment::DEFAULT
};

/// What the text states.
const TEXT: Experiment = Experiment {
    name: "hhz14-text",
    summary: "resolutions of A-buffers and grid, open and closed scenes (HHZ14, sections 3, 5 and 6)",
    scenes: &[
        stands_for("solids", "closed objects"),
        stands_for("room", "a closed room"),
        stands_for("cloth", "an open mesh"),
        stands_for("foliage", "open leaves"),
    ],
    rays: "diffuse,specular",
    steps: &once(&[
        abuffer(&[("abuffer", &["1024", "512", "2048"]), ("grid", &["64"]), ("search", SEARCHES)]),
        abuffer(&[("grid", &["0", "32", "128", "256"]), BOTH]),
    ]),
    sections: &[|page| beside(page, ABUFFER)],
    notes: &[
        "A grid of 0 is the one by the paper's rule. The second part has A-buffers of two and a half faces, as published: 1280 square where a face has 512 pixels.",
    ],
    ..Experiment::DEFAULT
};

/// What the text states of large and deep scenes.
const SCENES: Experiment = Experiment {
    name: "hhz14-scenes",
    summary: "bytes and traces over scenes of many and few triangles and layers (HHZ14, sections 5.3 and 6)",
    scenes: &[
        stands_for("room", "a scene"),
        stands_for("solids", "a scene"),
        stands_for("cloth", "a scene"),
        stands_for("hangar", "a scene"),
        stands_for("candy", "a scene"),
        stands_for("atrium", "a scene"),
        stands_for("foliage", "a scene"),
        stands_for("smithy", "a scene"),
    ],
    rays: "diffuse",
    steps: &once(&[abuffer(&[("abuffer", &["1024"]), ("grid", &["64"]), BOTH])]),
    sections: &[|page| beside(page, ABUFFER)],
    ..Experiment::DEFAULT
};
