//! Damages glTF files where it hurts: in the JSON's tree, in the numbers of the buffer, and in the container.

use serde_json::{Value, json};
use tracebench_tests::fuzz::{Random, Vocabulary};

use super::glb;

/// A file with one buffer, taken apart.
#[derive(Clone)]
pub struct Parts {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Numbers at which something ends: of bytes, of counts, of f32 and of the limits of the import.
const NUMBERS: &[f64] = &[
    0.0,
    1.0,
    -1.0,
    2.0,
    3.0,
    4.0,
    5.0,
    6.0,
    7.0,
    8.0,
    12.0,
    16.0,
    64.0,
    127.0,
    252.0,
    255.0,
    256.0,
    1e3,
    65_535.0,
    65_536.0,
    1e6,
    1e7,
    5e7,
    5.1e7,
    2_147_483_648.0,
    4_294_967_295.0,
    4_294_967_296.0,
    9_007_199_254_740_992.0,
    1.8e19,
    0.5,
    -0.5,
    1e-7,
    1e-45,
    1e-300,
    1e15,
    1.1e15,
    3.4e38,
    1e39,
    1e300,
    -1e300,
];

const WORDS: &[&str] = &[
    "",
    "SCALAR",
    "VEC2",
    "VEC3",
    "VEC4",
    "MAT4",
    "LINEAR",
    "STEP",
    "CUBICSPLINE",
    "translation",
    "rotation",
    "scale",
    "weights",
    "pointer",
    "perspective",
    "orthographic",
    "2.0",
    "1.0",
    "data:;base64,AAAAAAAAAAAAAAAA",
    "data:,x",
    "data:;base64,@",
    "file:///dev/zero",
    "file:///",
    "../%2e%2e",
    "http://x/y",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "MASK",
];

/// Keys with values that make sense somewhere: they are put where they may make none.
const KEYS: &[(&str, &str)] = &[
    ("POSITION", "0"),
    ("JOINTS_0", "1"),
    ("WEIGHTS_0", "2"),
    ("JOINTS_1", "1"),
    ("WEIGHTS_1", "2"),
    ("mode", "5"),
    ("mode", "6"),
    ("indices", "1"),
    ("targets", "[{\"POSITION\":0}]"),
    ("weights", "[0.5,-1]"),
    ("skin", "0"),
    ("mesh", "0"),
    ("camera", "0"),
    ("children", "[1]"),
    ("children", "[0]"),
    ("children", "[2,3]"),
    ("matrix", "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]"),
    ("matrix", "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]"),
    ("rotation", "[0,0,0,0]"),
    ("scale", "[-1,1,0]"),
    ("translation", "[1e15,0,0]"),
    ("joints", "[0,1]"),
    ("joints", "[0,0,0]"),
    ("inverseBindMatrices", "3"),
    ("byteStride", "16"),
    ("byteOffset", "4"),
    ("normalized", "true"),
    ("count", "3"),
    ("componentType", "5121"),
    ("componentType", "5123"),
    ("componentType", "5125"),
    ("componentType", "5126"),
    ("componentType", "5120"),
    ("node", "0"),
    ("sampler", "0"),
    ("extensions", "{\"KHR_draco_mesh_compression\":{}}"),
    ("extensionsRequired", "[\"KHR_mesh_quantization\"]"),
    ("sparse", "{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}"),
    ("uri", "\"data:;base64,AAAA\""),
    ("name", "7"),
    ("scene", "1"),
    ("bufferView", "1"),
    ("buffer", "1"),
    ("material", "0"),
    ("pbrMetallicRoughness", "{\"metallicFactor\":2}"),
    ("yfov", "4"),
];

const GLTF: Vocabulary =
    Vocabulary { numbers: NUMBERS, words: WORDS, keys: KEYS, repeats: &[1, 1, 1, 1, 2, 2, 20, 20, 300, 3000] };

/// f32 numbers that are none, or at the end of the range.
const FLOATS: &[f32] = &[
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    -0.0,
    0.0,
    1.0,
    -1.0,
    0.5,
    1e15,
    1.1e15,
    1e20,
    1e-20,
    2.0,
];

/// A damaged file made of `parts`, with pieces of `donor`; most damage leaves enough whole to be read on.
pub fn mutate(random: &mut Random, parts: &Parts, donor: &Parts) -> Vec<u8> {
    let mut parts = parts.clone();
    let rounds = if random.once_in(8) { 3 + random.below(9) } else { 1 + random.below(2) };
    for _ in 0..rounds {
        match random.below(10) {
            0..=4 => GLTF.mutate(random, &mut parts.json, &donor.json),
            5..=8 => mutate_bin(random, &mut parts.bin),
            _ => resize_bin(random, &mut parts),
        }
    }
    let mut text = parts.json.to_string().into_bytes();
    if random.once_in(12) {
        GLTF.duplicate_key(random, &mut text);
    }
    let mut bytes = if random.once_in(6) { text } else { glb(&text, &parts.bin) };
    if random.once_in(8) {
        mutate_container(random, &mut bytes);
    }
    bytes
}

fn mutate_bin(random: &mut Random, bin: &mut [u8]) {
    if bin.is_empty() {
        return;
    }
    let at = random.below(bin.len());
    // Accessors are aligned to four bytes, so aligned words are whole numbers of them.
    let word = at / 4 * 4;
    match random.below(6) {
        0 => bin[at] ^= 1 << random.below(8),
        1 => bin[at] = random.bits() as u8,
        2 | 3 => {
            let float = random.pick(FLOATS).to_le_bytes();
            bin[word..].iter_mut().zip(float).for_each(|(byte, new)| *byte = new);
        }
        4 => {
            let end = (at + 1 + random.below(64)).min(bin.len());
            let byte = *random.pick(&[0u8, 0, 0xff, 0x7f, 1]);
            bin[at..end].fill(byte);
        }
        _ => {
            let from = random.below(bin.len()) / 4 * 4;
            let length = (4 + random.below(48)).min(bin.len() - from.max(word));
            bin.copy_within(from..from + length, word);
        }
    }
}

/// The buffer becomes shorter or longer, and the document may or may not know.
fn resize_bin(random: &mut Random, parts: &mut Parts) {
    let length = match random.below(3) {
        0 => random.below(parts.bin.len() + 1),
        1 => parts.bin.len().saturating_sub(1 + random.below(16)),
        _ => parts.bin.len() + random.below(200),
    };
    parts.bin.resize(length, 0);
    if random.once_in(2)
        && let Some(stated) = parts.json.pointer_mut("/buffers/0/byteLength")
    {
        *stated = json!(length);
    }
}

/// Damages headers and lengths, cuts off, or flips any byte.
fn mutate_container(random: &mut Random, bytes: &mut Vec<u8>) {
    let json_length = bytes.get(12..16).map_or(0, |word| u32::from_le_bytes(word.try_into().unwrap()) as usize);
    let second = 20usize.saturating_add(json_length);
    match random.below(6) {
        0 => bytes.truncate(random.below(bytes.len() + 1)),
        1 => bytes.extend(std::iter::repeat_n(random.bits() as u8, random.below(40))),
        2 | 3 => {
            // A word of the header or of a chunk's header.
            let start = *random.pick(&[0, 4, 8, 12, 16, second, second.saturating_add(4)]);
            let new = match random.below(3) {
                0 => (*random.pick(NUMBERS) as u32).to_le_bytes(),
                1 => (bytes.len() as u32).wrapping_add(random.below(9) as u32).wrapping_sub(4).to_le_bytes(),
                _ => (random.bits() as u32).to_le_bytes(),
            };
            bytes.iter_mut().skip(start).zip(new).for_each(|(byte, new)| *byte = new);
        }
        4 => {
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len());
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = random.bits() as u8;
                }
            }
        }
        // The file's length follows a cut, so that the damage gets past the first check.
        _ => {
            bytes.truncate(random.below(bytes.len() + 1).max(12));
            let length = (bytes.len() as u32).to_le_bytes();
            bytes.iter_mut().skip(8).zip(length).for_each(|(byte, new)| *byte = new);
        }
    }
}
