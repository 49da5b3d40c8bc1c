//! The registration of `ploc-gpu`, which has the searches of `bvh-gpu` over hierarchies built on the device.

use super::table::{improved, published, switches};
use super::{Expectation, Family, Improved, OF_HIERARCHIES, Registration, Table};

pub(crate) const REGISTRATION: Registration = Registration {
    improved: Some(Improved { otherwise: Some(Expectation::Exact), expectations: &[] }),
    ablation: Some(&ABLATION),
    formerly: Some("lbvh-gpu"),
    touches: OF_HIERARCHIES,
    ..Registration::analytic(tracebench_bvh::ploc_description, Family::Bvh, |gpu| {
        Ok(Box::new(tracebench_bvh::PlocGpu::new(gpu?)?))
    })
};

/// Fewer neighbours early, late and throughout, and none, of both kinds of nodes.
const ABLATION: Table = switches(
    "ploc-gpu-ablation",
    "how far PLOC++ looks for neighbours, as published and improved, and the radix tree of LBVH: builds, traces, bytes, accuracy, counters",
    "primary,diffuse",
    &[
        published(&[]),
        improved(&[("early_search_radius", "4")]),
        improved(&[]),
        improved(&[("early_search_radius", "1")]),
        improved(&[("search_radius", "4")]),
        improved(&[("search_radius", "2")]),
        improved(&[("search_radius", "16")]),
        published(&[("node", "bvh2")]),
        improved(&[("node", "bvh2")]),
        published(&[("tree", "lbvh")]),
        published(&[("tree", "lbvh"), ("node", "bvh2")]),
    ],
);
