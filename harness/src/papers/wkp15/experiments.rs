//! WKP15's tables and figures.

use super::quantities::thresholds;
use super::{FIELD, MESH, SAMPLES_A_RAY, charts, dda, quadtree, sections};
use crate::papers::experiment::{
    Experiment, ExperimentRow, StandIn, Step, Values, at, at_scale, of_rays, once, peer, stands_for,
};

/// Every one, in the order of lists.
pub(super) const EXPERIMENTS: &[Experiment] =
    &[TABLE1, TABLE2, TABLE3, TABLE4, TABLE5, FIGURE14, FIGURE15, LIGHT_FIELD, TEXT];

/// What the first of the steps that are about rays says of them.
pub(super) const FIRST: &[(&str, &str)] = &[EARLIEST[0], FOUR_RAYS[0], FEW_CAMERAS[0], NEAR[0], NEAR[1]];

/// The paper's sequences: relatively simple, detailed in a room, detailed with large differences of depth.
const SEQUENCES: &[StandIn] =
    &[stands_for(SIMPLE, "SPONZA"), stands_for("room", "LIVINGROOM"), stands_for(DETAILED, "SANMIGUEL")];
/// What stands for the scene of detailed geometry with large differences of depth.
pub(super) const DETAILED: &str = "foliage";
/// What stands for the relatively simple one.
pub(super) const SIMPLE: &str = "atrium";
const LAYERS: &[&str] = &["1", "2"];
const OF_LAYERS: &[ExperimentRow] = &[quadtree(&[("layers", LAYERS)])];

/// Triangles of the paper's largest scene over those of the one that stands for it here.
const LARGEST: f64 = 15.5;

/// Table 1.
const TABLE1: Experiment = Experiment {
    name: "wkp15-table1",
    summary: "construction of the trees over the number of triangles, drawing the layers apart (WKP15, Table 1)",
    published: &["wkp15-table1", "wkp15-construction", "wkp15-figure3"],
    scenes: &[stands_for("atrium", "SPONZA"), stands_for("room", "LIVINGROOM"), stands_for("candy", "SANMIGUEL")],
    rays: "primary",
    steps: &[at(1.0, OF_LAYERS), at_scale(4.0, OF_LAYERS), at_scale(LARGEST, OF_LAYERS)],
    sections: &[sections::construction],
    notes: &[
        "Each scene is measured at three scales, 1, 4 and 15.5 times its triangles, up to the 6.5 million of the paper's largest: \
         what changes from scale to scale is their number alone.",
        "The construction is the tree's phases; drawing the layers, which the paper leaves out, stands beside it.",
        "The camera's rays are traced so that no time stands without an accuracy.",
    ],
    ..Experiment::DEFAULT
};

/// Steps of the marching peer, which the paper found to be the least that serve, and more than a frame has pixels on a ray's way.
const STEREO_STEPS: Values = &[("layers", LAYERS), ("max_steps", &["200", NO_CAP])];
const TEMPORAL_STEPS: Values = &[("layers", LAYERS), ("max_steps", &["500", NO_CAP])];
const LENS_STEPS: Values = &[("layers", LAYERS), ("max_steps", &["25", NO_CAP])];
pub(super) const NO_CAP: &str = "4096";
/// The other reading of which planes are dilated.
const FLAGGED: ExperimentRow = quadtree(&[("layers", LAYERS), ("dilated", &["flagged"])]);
/// Second layers that are not the back of what the first shows.
const SEPARATED: ExperimentRow = quadtree(&[("layers", &["2"]), ("minimum_separation", &["0.02"])]);
const FRONT_FACES: ExperimentRow = quadtree(&[("layers", &["2"]), ("back_faces", &["culled"])]);
const WITHOUT_COLOURS: &str = "Colours are not looked up: traces go to hits.";
/// The peer with stretched triangles as published, and without them.
const WARPING: ExperimentRow = ExperimentRow { tracer: MESH, values: &[("discontinuity", &["keep", "cut"])] };
const CAPPED: &str = "Read DDA's times with its accuracy. Near is a thousandth of the diagonal here, nearer than the paper's probably is: a ray of another \
     eye or lens crosses more pixels on its way from there than the paper's cap of steps has, and is given up (`step_cap`). A DDA that \
     gives up is no peer, so one without a cap stands beside it. And it hits to a pixel of its way, which along such a ray is many \
     footprints: the paper took that pixel's colour, the judge takes t.";

/// Table 2.
const TABLE2: Experiment = Experiment {
    name: "wkp15-table2",
    summary: "stereo rays beside DDA of one and two layers and a height field (WKP15, Table 2)",
    published: &["wkp15-table2", "wkp15-beside-peers", "wkp15-deeper-layers", "wkp15-figure1"],
    scenes: SEQUENCES,
    rays: "stereo",
    steps: &once(&[
        quadtree(&[("layers", LAYERS)]),
        FLAGGED,
        SEPARATED,
        FRONT_FACES,
        quadtree(&[("layers", &["1"]), ("gamma_norm", &["0"]), ("gamma_dist", &["0"])]),
        dda(STEREO_STEPS),
        peer(FIELD),
        WARPING,
    ]),
    launch: true,
    sections: &[sections::stereo],
    notes: &[
        CAPPED,
        WITHOUT_COLOURS,
        "A warp is the set stereo, the rays of one eye; a frame is a build and two of them. The distance of the paper's eyes is not \
         stated: `--set rays.stereo_offset=` changes it.",
    ],
    ..Experiment::DEFAULT
};

const EARLIEST: &[(&str, &str)] = &[("temporal_shift_s", "0.0166667")];
const WARPED: &[ExperimentRow] = &[quadtree(&[("layers", LAYERS)]), FLAGGED, dda(TEMPORAL_STEPS), peer(FIELD), WARPING];

/// Table 3.
const TABLE3: Experiment = Experiment {
    name: "wkp15-table3",
    summary: "rays of a camera on its way, 15 Hz to 60 Hz, beside DDA and a height field (WKP15, Table 3)",
    published: &["wkp15-table3", "wkp15-beside-peers"],
    scenes: SEQUENCES,
    rays: "temporal,stereo",
    steps: &[
        of_rays(EARLIEST, WARPED),
        of_rays(&[("temporal_shift_s", "0.0333333")], WARPED),
        of_rays(&[("temporal_shift_s", "0.05")], WARPED),
    ],
    launch: true,
    sections: &[sections::temporal],
    notes: &[
        CAPPED,
        WITHOUT_COLOURS,
        "The three views between two references are those of the camera 1/60, 2/60 and 3/60 s later on its path, of one reference, where \
         the paper has many; how fast its cameras move is not stated. Deviations of a sequence are not measured.",
        "Stereo rays stand beside them with the same steps, for the ratio of both leads.",
    ],
    ..Experiment::DEFAULT
};

/// The last of the three views between two references 1/15 s apart.
const LAST_BETWEEN: &[(&str, &str)] = &[("temporal_shift_s", "0.05")];
const FOUR_RAYS: &[(&str, &str)] = &[("lens_count", "4")];
const EIGHT_RAYS: &[(&str, &str)] = &[("lens_count", "8")];
const OF_BOTH: (&str, &[&str]) = ("layers", LAYERS);

/// Table 4.
const TABLE4: Experiment = Experiment {
    name: "wkp15-table4",
    summary: "rays through a lens, 4 and 8 a pixel, with secondary samples, beside DDA (WKP15, Table 4 and Figure 8)",
    published: &["wkp15-table4", "wkp15-figure8", "wkp15-lens-rates", "wkp15-layers"],
    scenes: &[stands_for("atrium", "SPONZA")],
    rays: "lens,stereo",
    steps: &[
        of_rays(
            FOUR_RAYS,
            &[
                quadtree(&[OF_BOTH, (SAMPLES_A_RAY, &["0", "3", "7"])]),
                FLAGGED,
                SEPARATED,
                FRONT_FACES,
                dda(LENS_STEPS),
            ],
        ),
        of_rays(
            EIGHT_RAYS,
            &[
                quadtree(&[OF_BOTH, (SAMPLES_A_RAY, &["0", "3"])]),
                FLAGGED,
                SEPARATED,
                FRONT_FACES,
                NOT_INPAINTED,
                dda(LENS_STEPS),
            ],
        ),
        Step { resolution: 0.5, ..of_rays(EIGHT_RAYS, OF_LAYERS) },
        Step { resolution: 0.5, ..of_rays(&[("lens_count", "32")], OF_LAYERS) },
    ],
    launch: true,
    sections: &[sections::lens],
    notes: &[
        CAPPED,
        "Stereo rays stand beside them with the same steps, for the ratio of both leads.",
        "Aperture and focus of the paper are not stated; nothing is shaded, so that images are not compared.",
        "The 32 rays a pixel of Figure 8 are traced at half of each edge, beside 8 there.",
        "A ray with all its secondary samples counts once, as in the paper, whose N_sec of Table 4 counts the ray among its samples: 4 is \
         three more. How far they lie from their ray and what weighs them is not stated.",
    ],
    ..Experiment::DEFAULT
};

const CUBE: (&str, &[&str]) = ("views", &["six"]);

/// Table 5.
const TABLE5: Experiment = Experiment {
    name: "wkp15-table5",
    summary: "glossy reflections of up to three bounces in a cube of six faces (WKP15, Table 5, Figures 11 to 13)",
    published: &["wkp15-table5", "wkp15-figure11"],
    scenes: &[stands_for("room", "Table 5"), stands_for("solids", "Table 5"), stands_for("atrium", "Table 5")],
    rays: "glossy,glossy2,glossy3,specular",
    steps: &once(&[
        quadtree(&[CUBE, ("layers", LAYERS), (SAMPLES_A_RAY, &["0", "4", "8"])]),
        quadtree(&[("views", &["frame"]), ("layers", LAYERS)]),
    ]),
    sections: &[sections::reflections],
    notes: &[
        "Three bounces are the sets glossy, glossy2 and glossy3 together. A ray a pixel starts: N_p of 3 is thrice the rays. The paper \
         bounces at reflecting surfaces alone, here every surface counts; its reflectance is Blinn-Phong's, here it is GGX.",
        "The trees of the cube are built here at every build; the paper builds them once in Figure 11.",
    ],
    ..Experiment::DEFAULT
};

/// Thresholds as the paper has them.
const USUAL: [(&str, &[&str]); 2] = [("gamma_norm", &["3"]), ("gamma_dist", &["1e-5"])];
const LOSSLESS: Values = &[("gamma_norm", &["0"]), ("gamma_dist", &["0"])];

/// Figure 14.
const FIGURE14: Experiment = Experiment {
    name: "wkp15-figure14",
    summary: "nodes, time and error over either threshold (WKP15, Figure 14)",
    published: &["wkp15-figure14", "wkp15-figure10", "wkp15-compression"],
    scenes: SEQUENCES,
    rays: "stereo",
    steps: &once(&[
        quadtree(&[USUAL[0], ("gamma_dist", &["1e-5", "1e-4", "1e-3", "1e-2", "1e-1"])]),
        quadtree(&[("gamma_norm", &["8", "14", "20", "25"]), USUAL[1]]),
        quadtree(&[("gamma_norm", &thresholds::ANGLES), ("gamma_dist", &[thresholds::NO_DISTANCE])]),
        quadtree(LOSSLESS),
    ]),
    sections: &[sections::thresholds],
    charts: &[charts::thresholds],
    notes: &[
        "At a gamma_dist of 1e-5 gamma_norm decides nothing. Planes of neighbouring pixels whose normals are 3 degrees apart differ at a corner \
         by half a pixel times the tangent of 3 degrees: 5.1e-5 of the cube's edge at 512 pixels, 1.6e-5 at the paper's 1600. So the \
         distance refuses them first. At a gamma_dist of 1, which refuses nothing, gamma_norm decides alone.",
        "The paper's error is PSNR of images, here it is the rays that are wrong under footprint and the error of t: nothing is shaded.",
        "Lossless is a threshold of 0 for both. gamma_dist is of the unit cube, whose depth hangs on near and far of the viewpoint; the paper \
         states neither of its own.",
    ],
    ..Experiment::DEFAULT
};

const GROWS: (&str, &[&str]) = ("gamma_growth", &["0", "16"]);

/// Figure 15.
const FIGURE15: Experiment = Experiment {
    name: "wkp15-figure15",
    summary: "time and error over both thresholds, fixed and growing with depth (WKP15, Figure 15)",
    published: &["wkp15-figure15", "wkp15-figure10", "wkp15-compression"],
    scenes: SEQUENCES,
    rays: "stereo,temporal,lens",
    steps: &[of_rays(
        LAST_BETWEEN,
        &[
            quadtree(&[USUAL[0], USUAL[1], GROWS]),
            quadtree(&[("gamma_norm", &["8"]), ("gamma_dist", &["1e-4"]), GROWS]),
            quadtree(&[("gamma_norm", &["14"]), ("gamma_dist", &["1e-3"]), GROWS]),
            quadtree(&[("gamma_norm", &["20"]), ("gamma_dist", &["1e-2"]), GROWS]),
            quadtree(&[("gamma_norm", &["25"]), ("gamma_dist", &["1e-1"]), GROWS]),
            quadtree(LOSSLESS),
        ],
    )],
    sections: &[sections::thresholds],
    charts: &[charts::growing],
    notes: &[
        "As in Figure 14 the error is of rays. View synthesis is the sets stereo and temporal, depth of field is lens. The camera of temporal \
         is that of 1/20 s later, the last of the three views between two references 1/15 s apart.",
        "By how much thresholds grow the paper does not state: here to 17 times themselves at the far distance.",
    ],
    ..Experiment::DEFAULT
};

const FEW_CAMERAS: &[(&str, &str)] = &[("light_field_cameras", "4")];
const BESIDE_HIERARCHIES: &[ExperimentRow] =
    &[quadtree(&[("layers", LAYERS)]), peer("ploc-gpu"), peer("bvh-gpu"), peer("ray-query")];

/// Section 5.3.
const LIGHT_FIELD: Experiment = Experiment {
    name: "wkp15-lightfield",
    summary: "images of 16 and of 256 cameras beside hierarchies (WKP15, section 5.3)",
    published: &["wkp15-lightfield"],
    scenes: SEQUENCES,
    rays: "light-field",
    steps: &[of_rays(FEW_CAMERAS, BESIDE_HIERARCHIES), of_rays(&[("light_field_cameras", "16")], BESIDE_HIERARCHIES)],
    launch: true,
    sections: &[sections::light_field],
    notes: &[
        "The cameras divide one image among them, so that the number of rays stays. The paper has a view of each eye and does not state how \
         many images the display takes; here there is one view.",
        "ploc-gpu, bvh-gpu and ray-query stand for OptiX.",
    ],
    ..Experiment::DEFAULT
};

/// How far rays go from the view that the trees are of.
pub(super) const NEAR: &[(&str, &str)] = &[("stereo_offset", "0.032"), ("temporal_shift_s", "0.05")];
const FAR: &[(&str, &str)] = &[("stereo_offset", "0.128"), ("temporal_shift_s", "0.5")];
pub(super) const FARTHEST: &[(&str, &str)] = &[("stereo_offset", "0.512"), ("temporal_shift_s", "1")];
/// One layer whose holes stay holes.
const NOT_INPAINTED: ExperimentRow = quadtree(&[("layers", &["1"]), ("inpainting", &["never"])]);
const DISPLACED: &[ExperimentRow] = &[
    quadtree(&[("layers", &["2", "1"])]),
    quadtree(&[("minimum_separation", &["0.005", "0.02"])]),
    quadtree(&[("back_faces", &["culled"])]),
    NOT_INPAINTED,
    dda(&[("layers", &["1"])]),
    peer(FIELD),
];

/// What the text states beside them.
const TEXT: Experiment = Experiment {
    name: "wkp15-text",
    summary: "what the text states beside its tables: layers, traversal, normals, cracks, displacement (WKP15, sections 2 to 6)",
    published: &["wkp15-traversal", "wkp15-layers"],
    scenes: SEQUENCES,
    rays: "stereo,temporal,lens",
    steps: &[
        of_rays(
            NEAR,
            &[
                quadtree(&[("layers", &["2", "1", "3", "4"])]),
                NOT_INPAINTED,
                quadtree(&[("traversal", &["stack"])]),
                quadtree(&[("normals", &["geometry"])]),
                quadtree(&[("gamma_norm", &["0"]), ("gamma_dist", &["0"]), ("normals", &["depth", "geometry"])]),
                quadtree(&[("dilated", &["none", "flagged"])]),
                quadtree(&[("next_layer", &["misses", "always"])]),
                dda(&[("layers", &["1"])]),
            ],
        ),
        of_rays(FAR, DISPLACED),
        of_rays(FARTHEST, DISPLACED),
    ],
    sections: &[sections::displacement],
    notes: &[
        "The three parts move the eye of stereo and the camera of temporal farther and farther from the view that the trees are of.",
        "Layers behind the first may be the backs of what it shows: rows with a minimum separation and without back faces have others.",
        "DDA has no cap of steps here but its own.",
    ],
    ..Experiment::DEFAULT
};
