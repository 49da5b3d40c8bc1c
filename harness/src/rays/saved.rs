//! Rays that were read: a ray set like any other, as long as the program runs.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use tracebench_api::{Query, Ray};

use super::{GeneratedRays, Kind, RayError, RaySet};
use crate::truth::Truth;

/// Rays with what they belong to.
#[derive(Clone, Debug)]
pub struct KnownRays {
    /// The rays.
    pub rays: Arc<Vec<Ray>>,
    /// Their hash.
    pub sha256: String,
    /// The eye whose pixels `footprint` is of; none of rays that have none.
    pub eye: Option<DVec3>,
    /// Hash of the scene that they are for.
    pub scene_sha256: String,
}

/// What was read, with where.
static KEPT: Mutex<Vec<(PathBuf, RaySet, KnownRays)>> = Mutex::new(Vec::new());

impl RaySet {
    /// The rays of a folder as a set; they are read when it is first named.
    ///
    /// # Errors
    /// What reading says.
    pub fn of_folder<E>(
        folder: &Path,
        read: impl FnOnce() -> Result<(String, Query, KnownRays), E>,
    ) -> Result<Self, E> {
        let known =
            |kept: &[(PathBuf, Self, KnownRays)]| kept.iter().find(|(path, ..)| path == folder).map(|(_, set, _)| *set);
        let lock = || KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(set) = known(&lock()) {
            return Ok(set);
        }
        let (name, query, rays) = read()?;
        let mut kept = lock();
        // Names of sets are as old as the program; there are as many as folders on the command line.
        let set =
            Self { kind: Kind::Saved(kept.len()), summary: "read from a folder", ..Self::given(name.leak(), query) };
        kept.push((folder.to_owned(), set, rays));
        Ok(set)
    }

    /// The rays, of a set that was read.
    pub fn saved(&self) -> Option<KnownRays> {
        let Kind::Saved(place) = self.kind else { return None };
        KEPT.lock().unwrap_or_else(PoisonError::into_inner).get(place).map(|(.., rays)| rays.clone())
    }

    /// What it is, for plans: of rays that were read with their hash, since names are not unique.
    pub fn describe(&self) -> String {
        let of = |saved: KnownRays| format!("{} {} {:?}", self.name, saved.sha256, saved.eye);
        self.saved().map_or_else(|| self.name.to_owned(), of)
    }
}

impl KnownRays {
    /// The rays in their own order, if they are for this scene.
    pub(super) fn of_scene(self, truth: &Truth) -> Result<GeneratedRays, RayError> {
        if self.scene_sha256 != truth.scene_sha256() {
            return Err(RayError::OtherScene(format!(
                "--rays: the rays that were read are for the scene of hash {}, and this one has hash {}: name their scene.glb by --scene",
                self.scene_sha256,
                truth.scene_sha256()
            )));
        }
        Ok(GeneratedRays { rays: self.rays, pixels: Arc::default() })
    }
}
