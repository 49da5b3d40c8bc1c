//! Tests of the importer and the catalogue. One program, which is linked once.

mod catalogue;
mod cloth;
mod import_bad;
mod import_deform;
mod import_files;
mod import_geometry;
mod import_large;
mod import_meshes;
mod import_met;
mod import_motion;
mod import_random;
mod layers;
mod motion;
mod room;
mod solids;
mod support;
mod watertight;
