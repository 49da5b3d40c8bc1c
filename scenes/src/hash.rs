//! The content hash of a mesh.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use crate::scene::Mesh;

/// Words are handed to the digest in blocks of this many bytes: one call a word would cost more than the digest.
const BLOCK_BYTES: usize = 1 << 16;

/// SHA-256 of `mesh` in lower-case hex; the order of what is hashed is told at [`crate::Scene::sha256`].
pub fn content_sha256(mesh: &Mesh) -> String {
    let mut words = Words { digest: Sha256::new(), block: Vec::with_capacity(BLOCK_BYTES + 8) };
    words.length(mesh.positions.len());
    for value in mesh.positions.iter().flatten() {
        words.word(value.to_bits());
    }
    words.length(mesh.triangles.len());
    for &index in mesh.triangles.iter().flatten() {
        words.word(index);
    }
    words.length(mesh.triangle_materials.len());
    for &material in &mesh.triangle_materials {
        words.word(material);
    }
    words.length(mesh.materials.len());
    for material in &mesh.materials {
        for value in material.base_color {
            words.word(value.to_bits());
        }
        words.word(material.metallic.to_bits());
        words.word(material.roughness.to_bits());
        material.refractive_index.into_iter().for_each(|index| words.word(index.to_bits()));
    }
    words.finish()
}

struct Words {
    digest: Sha256,
    block: Vec<u8>,
}

impl Words {
    fn word(&mut self, word: u32) {
        self.block.extend_from_slice(&word.to_le_bytes());
        if self.block.len() >= BLOCK_BYTES {
            self.flush();
        }
    }

    fn length(&mut self, length: usize) {
        self.block.extend_from_slice(&(length as u64).to_le_bytes());
    }

    fn flush(&mut self) {
        self.digest.update(&self.block);
        self.block.clear();
    }

    fn finish(mut self) -> String {
        self.flush();
        let mut hex = String::with_capacity(64);
        for byte in self.digest.finalize() {
            // Writing to a String cannot fail.
            let _ = write!(hex, "{byte:02x}");
        }
        hex
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
            triangle_objects: Vec::new(),
            objects: Vec::new(),
            materials: vec![Material {
                base_color: [0.5, 0.25, 1.0],
                metallic: 0.0,
                roughness: 1.0,
                refractive_index: None,
            }],
        }
    }

    /// Proves the documented byte order: the digest is that of the bytes written out by hand.
    #[test]
    fn hash_covers_the_documented_bytes() {
        let mut bytes = Vec::new();
        bytes.extend(3u64.to_le_bytes());
        for value in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend(1u64.to_le_bytes());
        for index in [0u32, 1, 2] {
            bytes.extend(index.to_le_bytes());
        }
        bytes.extend(1u64.to_le_bytes());
        bytes.extend(0u32.to_le_bytes());
        bytes.extend(1u64.to_le_bytes());
        for value in [0.5f32, 0.25, 1.0, 0.0, 1.0] {
            bytes.extend(value.to_le_bytes());
        }
        let mut expected = String::new();
        for byte in Sha256::digest(&bytes) {
            write!(expected, "{byte:02x}").unwrap();
        }
        assert_eq!(content_sha256(&triangle()), expected);
    }

    /// Proves that each of the four parts changes the hash.
    #[test]
    fn hash_sees_every_part() {
        let base = content_sha256(&triangle());
        let mut changed = triangle();
        changed.positions[1][0] = 1.000_000_1;
        assert_ne!(content_sha256(&changed), base);
        let mut changed = triangle();
        changed.triangles[0] = [1, 2, 0];
        assert_ne!(content_sha256(&changed), base);
        let mut changed = triangle();
        changed.triangle_materials[0] = 1;
        assert_ne!(content_sha256(&changed), base);
        let mut changed = triangle();
        changed.materials[0].roughness = 0.5;
        assert_ne!(content_sha256(&changed), base);
    }
}
