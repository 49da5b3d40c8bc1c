//! Hashes as text.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use sha2::{Digest, Sha256};

/// Lower-case hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    data_encoding::HEXLOWER.encode(bytes)
}

/// SHA-256 of a regular file; `None` of anything else, and of what cannot be read.
pub fn sha256_of_file(path: &Path) -> Option<String> {
    // Opening a pipe would wait for who writes to it.
    let is_file = path.metadata().is_ok_and(|found| found.is_file());
    let mut file = is_file.then(|| File::open(path).ok()).flatten()?;
    let (mut hasher, mut part) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut part).ok()? {
            0 => return Some(hex(&hasher.finalize())),
            read => hasher.update(&part[..read]),
        }
    }
}

/// SHA-256 of a slice of plain data, in memory order (little-endian on every supported machine).
pub fn sha256_of<T: bytemuck::NoUninit>(data: &[T]) -> String {
    hex(&Sha256::digest(bytemuck::cast_slice::<T, u8>(data)))
}
