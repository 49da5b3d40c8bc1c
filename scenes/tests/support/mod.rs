//! Builds small glTF files in code.
#![allow(dead_code, missing_docs)]

pub mod layers;
pub mod motion;
pub mod mutate;
pub mod promises;
pub mod watertight;

use serde_json::{Value, json};
use tracebench_scenes::{Scene, SceneError, import_bytes};

/// A document under construction: JSON, and the bytes of its buffer 0.
pub struct Doc {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// A unit square in the plane z = 0 as four vertices.
pub const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

impl Doc {
    /// One scene with one node that holds mesh 0, which is yet to be added.
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [{"byteLength": 0}],
        });
        Self { json, bin: Vec::new() }
    }

    /// A square of two triangles, indexed by 16 bits.
    pub fn square() -> Self {
        let mut doc = Self::new();
        let positions = doc.positions(&SQUARE);
        let indices = doc.indices(&[0, 1, 2, 0, 2, 3], 5123);
        doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": indices}]));
        doc
    }

    pub fn push(&mut self, key: &str, value: Value) -> usize {
        let list = self.json[key].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        while !self.bin.len().is_multiple_of(4) {
            self.bin.push(0);
        }
        let mut view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        self.push("bufferViews", view)
    }

    pub fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let bytes = float_bytes(positions);
        let view = self.view(&bytes, None);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": positions.len()}),
        )
    }

    /// An accessor of f32 with elements of a glTF type.
    pub fn floats(&mut self, shape: &str, values: &[f32]) -> usize {
        let width = match shape {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes, None);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "type": shape, "count": values.len() / width}),
        )
    }

    /// Adds a channel to animation 0: a property of a node over time.
    pub fn channel(&mut self, node: usize, path: &str, interpolation: &str, times: &[f32], values: &[f32]) {
        let shape = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let input = self.floats("SCALAR", times);
        let output = self.floats(shape, values);
        if self.json.get("animations").is_none() {
            self.json["animations"] = json!([{"channels": [], "samplers": []}]);
        }
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().expect("a list");
        samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
        let sampler = samplers.len() - 1;
        let channels = animation["channels"].as_array_mut().expect("a list");
        channels.push(json!({"sampler": sampler, "target": {"node": node, "path": path}}));
    }

    pub fn indices(&mut self, indices: &[u32], component: u32) -> usize {
        let bytes: Vec<u8> = indices
            .iter()
            .flat_map(|index| {
                let size = match component {
                    5121 => 1,
                    5123 => 2,
                    _ => 4,
                };
                index.to_le_bytes()[..size].to_vec()
            })
            .collect();
        let view = self.view(&bytes, None);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": "SCALAR", "count": indices.len()}),
        )
    }

    /// JOINTS_n: four joints a vertex, as u8.
    pub fn joints(&mut self, joints: &[[u8; 4]]) -> usize {
        let view = self.view(&joints.concat(), None);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5121, "type": "VEC4", "count": joints.len()}),
        )
    }

    pub fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({"name": "thing", "primitives": primitives}))
    }

    /// As `.glb`.
    pub fn glb(&self) -> Vec<u8> {
        glb(self.json.to_string().as_bytes(), &self.bin)
    }

    pub fn import(&self) -> Result<Scene, SceneError> {
        import_bytes(&self.glb(), None, "test")
    }

    /// The message of the error that the import must end in; it must not blame the caller's argument.
    pub fn error(&self) -> String {
        let error = self.import().expect_err("this file must be refused");
        assert!(!error.is_argument(), "{error}");
        error.to_string()
    }
}

pub fn float_bytes(positions: &[[f32; 3]]) -> Vec<u8> {
    positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
}

pub fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    while !json.len().is_multiple_of(4) {
        json.push(b' ');
    }
    let mut bin = bin.to_vec();
    while !bin.len().is_multiple_of(4) {
        bin.push(0);
    }
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(&bin);
    out
}

/// The three positions of each triangle.
pub fn triangles(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let corner = |&index: &u32| scene.mesh.positions[index as usize];
    scene
        .mesh
        .triangles
        .iter()
        .map(|triangle| [corner(&triangle[0]), corner(&triangle[1]), corner(&triangle[2])])
        .collect()
}

/// Twice the area along z, positive if the triangle runs counter-clockwise seen from +z.
pub fn facing(triangle: &[[f32; 3]; 3]) -> f32 {
    let [a, b, c] = triangle;
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
