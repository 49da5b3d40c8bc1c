//! VVP16's tables and figures.

use tracebench_api::TraceTo;

use super::{ABUFFER, BUILT_ON_DEVICE, abuffer, charts, sections};
use crate::papers::experiment::{Experiment, ExperimentRow, StandIn, Step, at, at_time, once, peer, stands_for};
use crate::papers::page::beside::beside;
use crate::papers::wkp15::quadtree;

/// Every one, in the order of lists.
pub(super) const EXPERIMENTS: &[Experiment] = &[TABLE1, TABLE2, FIGURE10, FIGURE11, FIGURE12, VIEWS];

/// The scenes of Table 1, by fragments and layers of seven views.
const OF_TABLE_1: &[StandIn] = &[
    stands_for("room", "Bunny"),
    stands_for("candy", "Dead Nature"),
    stands_for("solids", "Pool"),
    stands_for("smithy", "Smithy"),
];
const OFF: &[&str] = &["off"];
const STORAGES: &[&str] = &["s-buffer", "ll", "dll", "llb", "dllb"];

/// Table 1.
const TABLE1: Experiment = Experiment {
    name: "vvp16-table1",
    summary: "memory, fragments, layers, build, and traces of one and two bounces with and without skipping (VVP16, Table 1)",
    published: &["vvp16-table1", "vvp16-buckets"],
    scenes: OF_TABLE_1,
    rays: "diffuse,bounce2,ao",
    trace_to: TraceTo::Surface,
    steps: &once(&[
        abuffer(&[]),
        abuffer(&[("skip_bounds", OFF), ("skip_buckets", OFF)]),
        abuffer(&[("buckets", &["8", "12"])]),
    ]),
    sections: &[sections::bounces],
    notes: &[
        "One bounce is the set diffuse, a ray a pixel; two bounces are diffuse and bounce2 together, paths that leave the scene \
         start no second ray. The paper's times have direct lighting in them, these have not: camera rays are not traced.",
        "Empty-space efficiency, which the paper does not define, is the share of the pixels or steps looked at of which no \
         fragment was tested. Layers are told a ray, and a pixel of which at least one fragment was tested.",
        "A fragment has 16 bytes of data here whatever is traced; the paper's AO keeps normals alone. ao is an any-hit set of a \
         tenth of the scene's diagonal, where the paper has 3 m.",
    ],
    ..Experiment::DEFAULT
};

/// Table 2.
const TABLE2: Experiment = Experiment {
    name: "vvp16-table2",
    summary: "bytes by the formula beside those of the ledger, for five storages (VVP16, Table 2)",
    published: &["vvp16-table2"],
    scenes: OF_TABLE_1,
    steps: &once(&[
        abuffer(&[("storage", &["s-buffer", "ll", "dll"])]),
        abuffer(&[("storage", &["llb", "dllb"]), ("buckets", &["4", "1", "8"])]),
    ]),
    sections: &[sections::formula],
    notes: &[
        "The formula has the device's own counts in it, and 16 bytes of data a fragment: its normal and its material.",
    ],
    ..Experiment::DEFAULT
};

const MOVING: &[ExperimentRow] = &[abuffer(&[])];

/// Figure 10.
const FIGURE10: Experiment = Experiment {
    name: "vvp16-figure10",
    summary: "build and four samples a pixel of scenes that deform, over their animations (VVP16, Figure 10)",
    published: &["vvp16-figure10"],
    scenes: &[stands_for("foliage", "Fairy Forest"), stands_for("cloth", "Cloth-ball")],
    rays: "diffuse",
    trace_to: TraceTo::Surface,
    steps: &[at_time(0.5, MOVING), at_time(1.5, MOVING), at_time(2.5, MOVING)],
    sections: &[sections::frames],
    notes: &[
        "The paper's figure has four samples a pixel, averaged over the frames; here one is traced, and counts four times, in three frames \
         of each animation. Which of its two effects each picture shows is not told: diffuse rays, one bounce, here.",
        "The paper's times have direct lighting in them, these have not: camera rays are not traced.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 11.
const FIGURE11: Experiment = Experiment {
    name: "vvp16-figure11",
    summary: "build and trace beside every BVH (VVP16, Figure 11)",
    published: &["vvp16-figure11"],
    scenes: &[stands_for("atrium", "Sponza"), stands_for("foliage", "Ruins")],
    rays: "diffuse",
    trace_to: TraceTo::Surface,
    steps: &once(&[
        abuffer(&[("thickness", &["0"])]),
        abuffer(&[("thickness_in", &["pixels"]), ("thickness", &["1"])]),
        BUILT_ON_DEVICE,
        peer("bvh-gpu"),
        peer("bvh-cpu"),
        peer("ray-query"),
    ]),
    launch: true,
    sections: &[|page| beside(page, ABUFFER)],
    notes: &[
        "ploc-gpu, built on the device, stands for TRBVH, by the quicker tree; bvh-gpu, built on the host and traced on the device, for SBVH. Neither \
         is OptiX.",
        "One bounce is the set diffuse. The paper states no thickness; one of 0 is its section 3.4's, the other row's stands in its \
         label.",
    ],
    ..Experiment::DEFAULT
};

/// Figure 12.
const FIGURE12: Experiment = Experiment {
    name: "vvp16-figure12",
    summary: "traces of five storages in one view, plain, decoupled, and decoupled with skipping (VVP16, Figure 12)",
    published: &["vvp16-figure12", "vvp16-figure12-scenes", "vvp16-gains", "vvp16-construction"],
    scenes: &[stands_for("atrium", "Dead Nature"), stands_for("hangar", "Sponza"), stands_for("foliage", "Ruins")],
    rays: "pixel-random",
    trace_to: TraceTo::Surface,
    steps: &once(&[
        abuffer(&[
            ("views", &["frame"]),
            ("storage", STORAGES),
            ("decoupled", &["off", "on"]),
            ("skip_bounds", OFF),
            ("skip_buckets", OFF),
        ]),
        abuffer(&[("views", &["frame"]), ("storage", STORAGES), ("decoupled", &["on"])]),
    ]),
    sections: &[sections::variants],
    charts: &[charts::variants],
    notes: &[
        "The stand-ins are chosen by their layers in one view: 3, 7 and 16 fragments a pixel in the paper.",
        "The paper has 20 random rays a pixel of 800x800 and does not say from where; here they start from what the pixels see. \
         `--set rays.pixel_random_count=N` makes them fewer, `--size 800x800 --frame-size 800x800` has the paper's pixels.",
        "The stored colour of a hit is its normal and material here.",
    ],
    ..Experiment::DEFAULT
};

const BASE: Step = at(
    1.0,
    &[
        abuffer(&[("views", &["seven", "six", "frame"]), ("layers", &["all", "one"])]),
        abuffer(&[("march", &["pixels", "hi-z"])]),
        abuffer(&[("view_steps", &["25", "400"])]),
        abuffer(&[("bounds", &["boxes"])]),
        abuffer(&[("views", &["six"]), ("centre", &["eye"])]),
        abuffer(&[("storage", &["s-buffer"]), ("binary_search_above", &["16", "0", "64", "1048576"])]),
        abuffer(&[("thickness_in", &["pixels"]), ("thickness", &["1"])]),
        quadtree(&[("views", &["six"]), ("layers", &["2"])]),
    ],
);
/// Faces with pixels no larger than the camera's.
const FINE_FACES: Step = Step { faces: 2.0, ..at(1.0, &[abuffer(&[("views", &["seven", "six"])])]) };
const COARSE: Step =
    at(0.5, &[abuffer(&[("march", &["pixels"])]), abuffer(&[("thickness_in", &["pixels"]), ("thickness", &["1"])])]);

/// Figures 7 to 9, and what the text states.
const VIEWS: Experiment = Experiment {
    name: "vvp16-views",
    summary: "views, layers, marches, bounds, centres and binary search (VVP16, Figures 7 to 9, sections 3 and 4)",
    published: &["vvp16-figure7", "vvp16-figure8", "vvp16-figure9", "vvp16-views-cost", "vvp16-search"],
    scenes: &[stands_for("candy", "Dead Nature"), stands_for("solids", "Pool"), stands_for("smithy", "Smithy")],
    rays: "diffuse,specular,refraction,ao",
    steps: &[BASE, FINE_FACES, COARSE],
    sections: &[sections::views_and_layers],
    notes: &[
        "From one viewpoint a scene; `--view` takes others, as Figure 7 has two. The paper's times have direct lighting in them, \
         these have not; Figure 8 has two bounces, here its refracted and mirrored rays are those of the first.",
        "The last row of the first part is WKP15's cube of two layers.",
        "The second part has faces of twice the edge, whose pixels are no larger than the camera's; the third has half of every \
         resolution.",
    ],
    ..Experiment::DEFAULT
};
