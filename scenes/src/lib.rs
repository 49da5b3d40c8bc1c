//! Scenes for tracebench: triangles, a few material factors and named cameras, and nothing else that rays need not.
//!
//! A [`Scene`] comes from one of two places:
//!
//! - the catalogue of procedural scenes ([`catalogue()`], [`procedural()`]), which are the same bit for bit on every
//!   machine and grow with a scale factor;
//! - a glTF 2.0 file ([`import()`], [`import_bytes`]), from which positions, indices, what moves
//!   them and material factors are kept.
//!
//! Space is right-handed, y up, in metres for the procedural scenes and in the file's own units for imported ones.
//! Geometry is opaque and two-sided for every tracer; winding still tells the outside (counter-clockwise seen from
//! outside). No function of this crate panics on its input: what is wrong is a [`SceneError`].

mod catalogue;
mod error;
mod hash;
mod import;
mod procedural;
mod scene;

pub use catalogue::{CatalogueEntry, SCALE_MAX, SCALE_MIN, catalogue, procedural};
pub use error::SceneError;
pub use hash::content_sha256;
pub use import::{MAX_COORDINATE, MIN_DIAGONAL, SHARED_VERTICES, import, import_bytes, is_far, name_of};
pub use scene::{Animation, Camera, CameraKey, CameraPath, ImportNotes, Material, Mesh, Origin, Scene};
