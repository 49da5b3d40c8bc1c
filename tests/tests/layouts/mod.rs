//! Layouts of the Rust structs that shaders share, as Rust has them.

use std::collections::BTreeMap;
use std::mem::offset_of;

use tracebench_api::{Hit, Ray, Surface};
use tracebench_shaders::{BoundStruct, STRUCTS};

/// Names with offsets in bytes, in order, and the whole size.
pub type Layout = (Vec<(String, u32)>, u32);

fn layout(members: &[(&str, usize)], size: usize) -> Layout {
    (members.iter().map(|(name, offset)| ((*name).to_owned(), *offset as u32)).collect(), size as u32)
}

/// Every layout of a shared struct's name in WGSL: of what shaders bind, and of the contract.
pub fn shared() -> BTreeMap<&'static str, Vec<Layout>> {
    let mut shared: BTreeMap<_, Vec<Layout>> = BTreeMap::new();
    for BoundStruct { name, members, size } in STRUCTS {
        shared.entry(*name).or_default().push(layout(members, *size));
    }
    let contract = [
        (
            "Ray",
            layout(
                &[
                    ("origin", offset_of!(Ray, origin)),
                    ("t_min", offset_of!(Ray, t_min)),
                    ("direction", offset_of!(Ray, direction)),
                    ("t_max", offset_of!(Ray, t_max)),
                ],
                size_of::<Ray>(),
            ),
        ),
        (
            "Hit",
            layout(
                &[
                    ("t", offset_of!(Hit, t)),
                    ("primitive", offset_of!(Hit, primitive)),
                    ("u", offset_of!(Hit, u)),
                    ("v", offset_of!(Hit, v)),
                    ("status", offset_of!(Hit, status)),
                ],
                size_of::<Hit>(),
            ),
        ),
        (
            "Surface",
            layout(
                &[
                    ("position", offset_of!(Surface, position)),
                    ("material", offset_of!(Surface, material)),
                    ("normal", offset_of!(Surface, normal)),
                    ("status", offset_of!(Surface, status)),
                ],
                size_of::<Surface>(),
            ),
        ),
    ];
    for (name, of_contract) in contract {
        assert_eq!(shared[name], [of_contract], "{name}");
    }
    shared
}
