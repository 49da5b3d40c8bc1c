//! Hashes as text.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use sha2::{Digest, Sha256};

/// Lower-case hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::with_capacity(bytes.len() * 2), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// SHA-256 of a regular file; `None` of anything else, and of what cannot be read.
pub fn sha256_of_file(path: &Path) -> Option<String> {
    // Opening a pipe would wait for who writes to it.
    let is_file = path.metadata().is_ok_and(|found| found.is_file());
    let mut file = BufReader::new(is_file.then(|| File::open(path).ok()).flatten()?);
    let mut hasher = Sha256::new();
    loop {
        let part = file.fill_buf().ok()?;
        if part.is_empty() {
            return Some(hex(&hasher.finalize()));
        }
        hasher.update(part);
        let read = part.len();
        file.consume(read);
    }
}

/// SHA-256 of a slice of plain data, in memory order (little-endian on every supported machine).
pub fn sha256_of<T: bytemuck::NoUninit>(data: &[T]) -> String {
    hex(&Sha256::digest(bytemuck::cast_slice::<T, u8>(data)))
}
