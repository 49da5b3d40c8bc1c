//! The registration of `bvh-cpu`: an analytic method in f32 that sees every triangle and no view.

use super::expectation::fails;
use super::{Expectation, Family, Improved, OF_HIERARCHIES, Registration, Rule};

const EDGES: Expectation = fails(
    Rule::HitMiss,
    "the f32 triangle test is not watertight: of rays onto an edge that two triangles share some pass between \
             them",
    "Woop, Benthin and Wald 2013, on why edge tests must be watertight",
);

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[&[("needles", EDGES)]],
    improved: Some(Improved { otherwise: Some(Expectation::Exact), expectations: &[] }),
    excluded_from_fronts: &["rebuild_every"],
    touches: OF_HIERARCHIES,
    ..Registration::analytic(tracebench_bvh::description, Family::Bvh, |_| Ok(Box::new(tracebench_bvh::BvhCpu)))
};
