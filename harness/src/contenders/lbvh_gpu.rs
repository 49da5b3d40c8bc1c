//! The room of `lbvh-gpu`, which has the searches of `bvh-gpu` over hierarchies built on the device.

use super::ablation::{improved, published};
use super::{Ablation, Expectation, Family, Improved, OF_HIERARCHIES, Registration};

pub(crate) const ROOM: Registration = Registration {
    improved: Some(Improved { otherwise: Some(Expectation::Exact), expectations: &[] }),
    ablation: Some(&ABLATION),
    touches: OF_HIERARCHIES,
    ..Registration::analytic(tracebench_bvh::lbvh_description, Family::Bvh, |gpu| {
        Ok(Box::new(tracebench_bvh::LbvhGpu::new(gpu?)?))
    })
};

/// Fewer neighbours early, late and throughout, of both kinds of nodes.
const ABLATION: Ablation = Ablation {
    name: "lbvh-gpu-ablation",
    summary: "how far PLOC++ looks for neighbours, as published and improved: builds, traces, bytes, accuracy, counters",
    rays: "primary,diffuse",
    rows: &[
        published(&[]),
        improved(&[("early_search_radius", "4")]),
        improved(&[]),
        improved(&[("early_search_radius", "1")]),
        improved(&[("search_radius", "4")]),
        improved(&[("search_radius", "2")]),
        improved(&[("search_radius", "16")]),
        published(&[("node", "bvh2")]),
        improved(&[("node", "bvh2")]),
    ],
};
