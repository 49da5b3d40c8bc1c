//! Every tracer in the registry through one body each: what the contract promises, what structures hold, and what drivers and
//! means may not change. One program, so that cores are busy while one of them waits for a long test.

mod chosen_rays;
mod conformance;
mod device_memory;
mod drawn_in_compute;
mod drivers;
mod ends;
mod hostile;
mod hybrid;
mod launch;
mod scales;
mod shared_edges;
mod shared_structures;
mod slivers;
mod surfaces;
mod updates;
