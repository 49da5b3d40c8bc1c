//! The content hash of a mesh.

use sha2::{Digest, Sha256};

use crate::scene::Mesh;

// Numbers are hashed as they lie in memory.
const _: () = assert!(cfg!(target_endian = "little"));

/// SHA-256 of `mesh` in lower-case hex; the order of what is hashed is told at [`crate::Scene::sha256`].
pub fn content_sha256(mesh: &Mesh) -> String {
    let mut digest = Sha256::new();
    let length = |length: usize| (length as u64).to_le_bytes();
    digest.update(length(mesh.positions.len()));
    digest.update(bytemuck::cast_slice::<_, u8>(&mesh.positions));
    digest.update(length(mesh.triangles.len()));
    digest.update(bytemuck::cast_slice::<_, u8>(&mesh.triangles));
    digest.update(length(mesh.triangle_materials.len()));
    digest.update(bytemuck::cast_slice::<_, u8>(&mesh.triangle_materials));
    digest.update(length(mesh.materials.len()));
    for material in &mesh.materials {
        let [red, green, blue] = material.base_color;
        digest.update(bytemuck::bytes_of(&[red, green, blue, material.metallic, material.roughness]));
        digest.update(bytemuck::cast_slice::<f32, u8>(material.refractive_index.as_slice()));
    }
    hex(&digest.finalize())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
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
        assert_eq!(content_sha256(&triangle()), hex(&Sha256::digest(&bytes)));
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
