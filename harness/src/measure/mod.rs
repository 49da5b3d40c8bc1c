//! The one place that measures: loads scenes, chooses poses, makes configurations, times them in interleaved sets, checks controls, keeps records.
//!
//! What is asked comes as places with configurations, from a plain run or a study; what was found goes back as rows. A place is a
//! scene from one viewpoint. Its configurations are raced in resident batches: only the structures of one resident batch are there at a
//! time. An interleaved set, the builds of a resident batch or the traces of a ray set in it, is what is kept as soon as it ends.

pub mod controls;
mod doubled_work;
mod frames;
mod interleaved_set;
mod journal;
mod kernels;
pub(crate) mod records;
mod resident_batch;
mod rounds;
mod run;
mod scene;
pub mod session;
mod sound;
mod tracer_config;
mod tracing;
mod trial;
mod workload;

use tracebench_api::TracerError;
use tracebench_scenes::SceneError;

pub(crate) use doubled_work::{DoubledWork, invalid_reason};
pub(crate) use frames::{Followed, FrameWork, MovingFrames, Traced, follow, trace_sample};
pub use journal::{Journal, JournalError};
pub use resident_batch::MAX_RESIDENT;
pub(crate) use resident_batch::measure;
pub use run::{Context, execute_all};
pub(crate) use run::{add, add_or_skip, begin, empty, filled, measure_plan, measure_scene, nothing};
pub(crate) use scene::{SceneTruth, mirrors};
pub use scene::{choose_pose, load, load_at, load_scene, prepare};
use session::SessionError;
pub use tracer_config::{BuildSample, TracerCache, TracerConfig};
pub(crate) use trial::{Trial, against_itself, fresh_and_repeated};
pub use workload::PreparedWorkload;
pub(crate) use workload::{MeasureOptions, Measured, Observations, Refusal, Workload, told};

use crate::exchange::ExchangeError;
use crate::viewpoint::PoseError;

/// Why a run could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A scene could not be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene has no such camera; why the name given is no pose, and the names that exist.
    #[error("--view: scene {0} has no viewpoint '{1}'; there are: {3}. Nor is it a pose: {2}")]
    UnknownView(String, String, PoseError, String),
    /// The scene cannot be seen from elsewhere than its own viewpoint.
    #[error("scene {0} has no other viewpoint than '{1}': nothing is seen from anywhere that the rule finds")]
    NoOtherView(String, String),
    /// A tracer that was asked for by name cannot do it.
    #[error("{0}: {1}")]
    Tracer(String, TracerError),
    /// The device cannot hold scene or rays, or failed.
    #[error(transparent)]
    Device(#[from] TracerError),
    /// Truth or judge failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// What has ended cannot be kept or gone on with.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A control failed.
    #[error("the record is invalid: {0}")]
    Control(String),
    /// Rays could not be written as files.
    #[error("rays cannot be written: {0}")]
    Exchange(#[from] ExchangeError),
    /// A picture of answers could not be made.
    #[error("a picture of answers cannot be made: {0}")]
    Picture(String),
    /// No tracer was left to run.
    #[error("no tracer could run: {0}")]
    Nothing(String),
}

impl RunError {
    /// Whether the arguments are to blame rather than files, devices or memory.
    pub fn is_argument(&self) -> bool {
        match self {
            Self::Scene(error) => error.is_argument(),
            Self::UnknownView(..) => true,
            _ => false,
        }
    }
}

#[cfg(test)]
mod doubled_tests;
#[cfg(test)]
mod replay_tests;
#[cfg(test)]
mod resident_batch_tests;
#[cfg(test)]
mod tests;
