//! Hashes as text.

use sha2::{Digest, Sha256};

/// Lower-case hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::with_capacity(bytes.len() * 2), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// SHA-256 of a slice of plain data, in memory order (little-endian on every supported machine).
pub fn sha256_of<T: bytemuck::NoUninit>(data: &[T]) -> String {
    hex(&Sha256::digest(bytemuck::cast_slice::<T, u8>(data)))
}
