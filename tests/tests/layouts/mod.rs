//! Layouts of the Rust structs that shaders share, as the crates tell them.

use std::collections::BTreeMap;

use tracebench_api::SharedLayout;
use tracebench_harness::registry::TRACERS;

/// Names with offsets in bytes, in order, and the whole size.
pub type Layout = (Vec<(String, u32)>, u32);

/// Every shared struct by its name in WGSL, of the contract, of kit and of every tracer.
pub fn shared() -> BTreeMap<&'static str, Layout> {
    let of_tracers = TRACERS.iter().flat_map(|registration| (registration.describe)().layouts);
    let mut shared = BTreeMap::new();
    for SharedLayout { name, members, size } in
        tracebench_api::layouts().into_iter().chain(tracebench_kit::layouts()).chain(of_tracers)
    {
        let members = members.into_iter().map(|(member, offset)| (member.to_owned(), offset as u32)).collect();
        let layout: Layout = (members, size as u32);
        let known = shared.entry(name).or_insert_with(|| layout.clone());
        assert_eq!(*known, layout, "two structs are called {name}");
    }
    shared
}
