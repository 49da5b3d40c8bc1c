//! A part of DIRT's Tables 1 to 3 and Figures 8 to 11 in one scene.
//!
//! For each the harness measures its rows interleaved, judges them and writes run.json, the table and its verdicts below target/;
//! then criterion samples the same work through the harness's clock. Resolutions are half the run preset's, triangles an
//! eighth, samples three. Left out are the other scenes, specular, glossy and primary rays, bvh-gpu, resolutions of a figure but
//! one, and of Table 3 and Figure 10 most tile sizes and B: `tracebench table NAME` has them. `TRACEBENCH_PRESET` chooses the run
//! preset.

mod common;
#[path = "common/papers.rs"]
mod papers;

fn main() -> Result<(), common::Failure> {
    papers::run(tracebench_harness::papers::paper("dirt").ok_or("there is no paper 'dirt'")?)
}
