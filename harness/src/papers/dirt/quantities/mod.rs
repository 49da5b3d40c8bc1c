//! What decides DIRT's claims.

mod accuracy;
mod beside_abuffer;
mod families;
pub(super) mod memory;
pub(super) mod time;

use crate::papers::Quantity;

/// All of them.
pub(super) const QUANTITIES: &[&[Quantity]] =
    &[time::QUANTITIES, memory::QUANTITIES, accuracy::QUANTITIES, beside_abuffer::QUANTITIES, families::QUANTITIES];
