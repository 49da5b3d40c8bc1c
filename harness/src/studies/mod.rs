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

use crate::files::OutputFolder;
use crate::hash::sha256_of;
use crate::measure::{JournalError, RunError};
use crate::results::PICTURES_FOLDER;

/// Writes a picture beside the record, and gives its name.
fn keep_picture(png: &[u8], results: &OutputFolder) -> Result<String, RunError> {
    let name = format!("{}.png", &sha256_of(png)[..32]);
    results.write(&format!("{PICTURES_FOLDER}/{name}"), png).map_err(JournalError::from)?;
    Ok(name)
}
