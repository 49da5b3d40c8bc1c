#define_import_path tracebench::pyramid

// Pyramids over images: a cell of a level stands for the four below it, as many of them as there are.

// Cells of a level over an image of this size, in each direction half of those below, rounded up.
fn level_size(size: vec2<u32>, level: u32) -> vec2<u32> {
    return (size + ((1u << level) - 1u)) >> vec2<u32>(level);
}

// Where a cell lies in its level, row by row.
fn index_in_level(size: vec2<u32>, level: u32, cell: vec2<u32>) -> u32 {
    return cell.y * level_size(size, level).x + cell.x;
}

// One of the four cells below a cell of the level `level`; one of the last column or row may be given twice.
fn cell_below(size: vec2<u32>, level: u32, cell: vec2<u32>, child: u32) -> vec2<u32> {
    return min(2u * cell + vec2<u32>(child & 1u, child >> 1u), level_size(size, level - 1u) - 1u);
}

// A walk down a pyramid in Morton order, without a stack: the cells of all levels have codes, that of the one at the top is 0.
struct CodedCell {
    level: u32,
    code: u32,
}

// Every second bit of a Morton code.
fn every_second_bit(code: u32) -> u32 {
    var bits = code & 0x55555555u;
    bits = (bits | (bits >> 1u)) & 0x33333333u;
    bits = (bits | (bits >> 2u)) & 0x0f0f0f0fu;
    bits = (bits | (bits >> 4u)) & 0x00ff00ffu;
    return (bits | (bits >> 8u)) & 0x0000ffffu;
}

// The place of a cell in its level, which may lie outside of the image.
fn place_of(cell: CodedCell) -> vec2<u32> {
    return vec2<u32>(every_second_bit(cell.code), every_second_bit(cell.code >> 1u));
}

// The first of the four below a cell that is not at level 0.
fn first_below(cell: CodedCell) -> CodedCell {
    return CodedCell(cell.level - 1u, cell.code << 2u);
}

// The cell after all those below a cell: the next of the four, from the last of four on the one after their parent. At the top
// level `top` the walk has ended.
fn next_after(cell: CodedCell, top: u32) -> CodedCell {
    let code = cell.code + 1u;
    // Up from the last of four.
    let up = min(countTrailingZeros(code) >> 1u, top - cell.level);
    return CodedCell(cell.level + up, code >> (2u * up));
}
