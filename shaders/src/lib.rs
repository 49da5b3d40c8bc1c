//! The WGSL of tracebench. Files are composed from modules (`#import tracebench::view`), validated when this crate is
//! built, and offered here as plain WGSL, a constant a variant.

/// One validated shader variant.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// The variant's name.
    pub name: &'static str,
    /// Its WGSL, with imports resolved.
    pub source: &'static str,
}

include!(concat!(env!("OUT_DIR"), "/table.rs"));
