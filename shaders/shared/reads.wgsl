#define_import_path tracebench::reads

// Arrays of a structure that a search reads at unrelated places in every lane: in buffers or, with TEXTURES, copied to
// storage textures row by row. Which is faster is the driver's: Mesa's software driver makes a branch a lane of every load from a
// buffer, and asks a level of detail a lane of sampled textures, from which searches took a quarter longer.
//
// An array has records of four words (quads), of two (pairs) or of one (words), each a texel, and is read by a record's number.
// A shader uses as many of these arrays as it needs: four, where it is to run under WebGPU's default limits. Host code binds them
// by tracers/kit/src/reads.rs.

// Records of a row are two to the power of it; in bytes all rows are as long: 2^ROW_BITS of the host's.
const QUAD_ROW_BITS: u32 = 11u;
const PAIR_ROW_BITS: u32 = 12u;
const WORD_ROW_BITS: u32 = 13u;

#ifdef TEXTURES
@group(1) @binding(0) var quads_0: texture_storage_2d<rgba32uint, read>;
@group(1) @binding(1) var quads_1: texture_storage_2d<rgba32uint, read>;
@group(1) @binding(2) var pairs_0: texture_storage_2d<rg32uint, read>;
@group(1) @binding(3) var pairs_1: texture_storage_2d<rg32uint, read>;
@group(1) @binding(4) var words_0: texture_storage_2d<r32uint, read>;
@group(1) @binding(5) var words_1: texture_storage_2d<r32uint, read>;
@group(1) @binding(6) var words_2: texture_storage_2d<r32uint, read>;
@group(1) @binding(7) var words_3: texture_storage_2d<r32uint, read>;

// Where a record is, of two to the power of `bits` a row.
fn place(index: u32, bits: u32) -> vec2<u32> {
    return vec2<u32>(index & ((1u << bits) - 1u), index >> bits);
}

fn quad_0(index: u32) -> vec4<u32> {
    return textureLoad(quads_0, place(index, QUAD_ROW_BITS));
}

fn quad_1(index: u32) -> vec4<u32> {
    return textureLoad(quads_1, place(index, QUAD_ROW_BITS));
}

fn pair_0(index: u32) -> vec2<u32> {
    return textureLoad(pairs_0, place(index, PAIR_ROW_BITS)).xy;
}

fn pair_1(index: u32) -> vec2<u32> {
    return textureLoad(pairs_1, place(index, PAIR_ROW_BITS)).xy;
}

fn word_0(index: u32) -> u32 {
    return textureLoad(words_0, place(index, WORD_ROW_BITS)).x;
}

fn word_1(index: u32) -> u32 {
    return textureLoad(words_1, place(index, WORD_ROW_BITS)).x;
}

fn word_2(index: u32) -> u32 {
    return textureLoad(words_2, place(index, WORD_ROW_BITS)).x;
}

fn word_3(index: u32) -> u32 {
    return textureLoad(words_3, place(index, WORD_ROW_BITS)).x;
}
#else
@group(1) @binding(0) var<storage, read> quads_0: array<vec4<u32>>;
@group(1) @binding(1) var<storage, read> quads_1: array<vec4<u32>>;
@group(1) @binding(2) var<storage, read> pairs_0: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> pairs_1: array<vec2<u32>>;
@group(1) @binding(4) var<storage, read> words_0: array<u32>;
@group(1) @binding(5) var<storage, read> words_1: array<u32>;
@group(1) @binding(6) var<storage, read> words_2: array<u32>;
@group(1) @binding(7) var<storage, read> words_3: array<u32>;

fn quad_0(index: u32) -> vec4<u32> {
    return quads_0[index];
}

fn quad_1(index: u32) -> vec4<u32> {
    return quads_1[index];
}

fn pair_0(index: u32) -> vec2<u32> {
    return pairs_0[index];
}

fn pair_1(index: u32) -> vec2<u32> {
    return pairs_1[index];
}

fn word_0(index: u32) -> u32 {
    return words_0[index];
}

fn word_1(index: u32) -> u32 {
    return words_1[index];
}

fn word_2(index: u32) -> u32 {
    return words_2[index];
}

fn word_3(index: u32) -> u32 {
    return words_3[index];
}
#endif
