//! A part of VVP16's Tables 1 and 2 and Figures 7 to 9, 11 and 12 in one scene.
//!
//! For each the harness measures its rows interleaved, judges them and writes run.json, the table and its verdicts below target/;
//! then criterion samples the same work through the harness's clock. Resolutions are half the run preset's, triangles an eighth,
//! samples three, random rays two a pixel. Left out are the other scenes, second bounces, mirrored and refracted rays, more than four buckets, of the
//! storages in Figure 12 all but the plainest and the paper's own, a thickness, of views and layers all but one view and one layer,
//! and what the text states: `tracebench table NAME` has them. `TRACEBENCH_PRESET` chooses the run preset.

mod common;
#[path = "common/papers.rs"]
mod papers;

fn main() -> Result<(), common::Failure> {
    papers::run(tracebench_harness::papers::paper("vvp16").ok_or("there is no paper 'vvp16'")?)
}
