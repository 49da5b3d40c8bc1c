//! Studies: what is asked beyond a plain run, as requests in and rows out. Each says what is to be measured; measuring is
//! [`crate::measure`]'s.

pub mod attack;
pub mod clock;
pub mod explain;
pub mod frames;
pub mod judge;
pub mod need;
pub mod pareto;
pub mod stability;
pub mod sweep;
pub mod tune;
