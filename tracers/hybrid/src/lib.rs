//! `hybrid`: two tracers one after the other, as engines trace in screen space first and ask something else for the rest.
//!
//! AMD's sample *Hybrid Reflections* (GPUOpen) and mixed tracing of Unity's HDRP take the hit of a march over the depth buffer where
//! there is one, and trace the scene itself for the other rays. Here the two are any tracers on the device. Which answers of the first are
//! kept is told by what it says of them, their status (`trust`), and by where a hit lies in the frame (`border_pixels`). The other rays are
//! brought together in compute, in their order, and searched by the second; its answers take the place of the first's. Nothing is read
//! back: how many rays there are only the device knows, and searches are dispatched by that.
//!
//! Deviation from the sources, which may blend what both found: here an answer is that of one tracer, to the bit.

mod description;
mod handover;
mod structure;

pub use description::{Part, description};
pub use structure::Hybrid;
