//! `hybrid`: two tracers one after the other, as engines trace in screen space first and ask something else for the rest.
//!
//! AMD's sample *Hybrid Reflections* (GPUOpen) and mixed tracing of Unity's HDRP take the hit of a march over the depth buffer where
//! there is one, and trace the scene itself for the other rays. Here the two are any tracers on the device. An answer of the first is kept
//! by its status (`trust`), a hit also by where it lies in the frame (`border_pixels`). The other rays are brought together in their order
//! and searched by the second. Nothing is read back: searches are dispatched by what the device alone knows. Deviation from the sources,
//! which may blend what both found: an answer is that of one tracer, to the bit.

mod description;
mod handover;
mod structure;

pub use description::{Part, description};
pub use structure::Hybrid;
