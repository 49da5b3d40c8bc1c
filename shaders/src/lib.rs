//! The WGSL of tracebench. Files are composed from modules (`#import tracebench::view`), validated when this crate is
//! built, and offered here as plain WGSL.
//!
//! A folder has a module of its name, in which a shader is looked up by its flags. Which there are, `variants.txt` of the
//! folder says; another one does not compile:
//!
//! ```
//! use tracebench_shaders::{Shader, dirt};
//! let shader = Shader::from(dirt::Fill::Primitives { conservative: true, split: true });
//! assert_eq!(shader.name, "dirt/fill PRIMITIVES SPLIT");
//! ```
//! ```compile_fail
//! // Depth bounds have no lists that could be split.
//! let shader = tracebench_shaders::dirt::Fill::Plain { conservative: true, split: false };
//! ```

#[cfg(test)]
#[path = "../build/list.rs"]
mod list;

use std::collections::BTreeSet;

/// One validated shader variant.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// The variant's name: folder, file and what is switched on.
    pub name: &'static str,
    /// The file it is made of, below the folder of all shaders.
    pub file: &'static str,
    /// Its WGSL, with imports resolved.
    pub source: &'static str,
    /// Its entry points.
    pub entries: &'static [EntryPoint],
    /// What pipelines are told: its `override`s, as its WGSL calls them.
    pub switches: &'static [(&'static str, f64)],
}

/// What tells a shader from every other.
pub type ShaderKey = (&'static str, u32);

impl Shader {
    /// Its key: its name, with a bit for each of its switches.
    #[must_use]
    pub fn key(&self) -> ShaderKey {
        (self.name, self.switches.iter().fold(0, |bits, (_, on)| 2 * bits + u32::from(*on > 0.0)))
    }

    /// The value of one of its `u32` constants, by the name that its module gives it: for tests that hold sizes of the host and of the
    /// device together. Composed, a name has its module's behind it.
    #[must_use]
    pub fn constant(&self, name: &str) -> Option<u32> {
        let of = |line: &str| {
            let (found, value) = line.strip_prefix("const ")?.split_once(": u32 = ")?;
            let plain = found.split("X_naga_oil").next()?;
            (plain == name).then(|| value.trim_end_matches("u;").parse().ok())?
        };
        self.source.lines().find_map(of)
    }
}

/// The values that a `u32` constant has in the variants of a file that know it; for the same tests.
#[must_use]
pub fn constants(file: &str, name: &str) -> BTreeSet<u32> {
    ALL.iter().filter(|shader| shader.file == file).filter_map(|shader| shader.constant(name)).collect()
}

/// An entry point of a shader, and what it needs of a device.
#[derive(Clone, Copy, Debug)]
pub struct EntryPoint {
    /// Its name.
    pub name: &'static str,
    /// Storage buffers that it binds.
    pub storage_buffers: u32,
    /// Storage textures that it binds.
    pub storage_textures: u32,
    /// Invocations of a workgroup; 0 of a stage that has none.
    pub invocations: u32,
}

/// A struct that shaders bind. Its folder's module has it as a type of the same members, which host code fills and reads.
#[derive(Clone, Copy, Debug)]
pub struct BoundStruct {
    /// Its name.
    pub name: &'static str,
    /// Its members in order, with their offsets in bytes.
    pub members: &'static [(&'static str, usize)],
    /// Its bytes.
    pub size: usize,
}

/// The variants of one file: those that are composed and, of each, those that pipelines choose.
pub trait Variant: Copy + Ord + Into<Shader> + 'static {
    /// Every one.
    const ALL: &'static [Self];
}

include!(concat!(env!("OUT_DIR"), "/table.rs"));
