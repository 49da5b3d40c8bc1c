//! Tests of the harness and of its command line. One program, which is linked once.

mod command_line;
mod judge;
mod stability;
mod truth;
