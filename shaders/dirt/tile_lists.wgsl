#define_import_path tracebench::dirt_tile_lists

// The search of a tile of the packed forms of DIRT without a tree: all that it holds, or the lists of its depth slices.

#import tracebench::reads::{quad_1, pair_0, word_1}
#import tracebench::dirt_packed_grid::{cell_number, lowest_bits, slices_between}
#import tracebench::lanes::open
#import tracebench::dirt_packed_ray::{grid, leg, is_done, test_references}

#ifdef SLICES
// The lists of those slices of a tile that the ray passes, in its order.
fn search_lists(number: u32, tile: vec2<i32>, mask: vec2<u32>) {
    let header = quad_1(number);
    let held = pair_0(cell_number(grid, number / (grid.tiles * grid.tiles), 0u, vec2<u32>(tile)));
    let lists = countOneBits(held.x) + countOneBits(held.y);
    let approaches = leg.change.z > 0.0;
    var left = held & mask;
    open += 1u;
    loop {
        if (all(left == vec2<u32>(0u)) || is_done()) {
            open -= 1u;
            break;
        }
        let lowest = select(countTrailingZeros(left.y) + 32u, countTrailingZeros(left.x), (left.x != 0u));
        let highest = select(firstLeadingBit(left.x), firstLeadingBit(left.y) + 32u, (left.y != 0u));
        let slice = select(highest, lowest, approaches);
        left &= ~slices_between(slice, slice);
        let before = held & lowest_bits(slice);
        let list = countOneBits(before.x) + countOneBits(before.y);
        var last = header.x + header.y;
        if (list + 1u < lists) {
            last = word_1(header.z + list + 1u);
        }
        test_references(word_1(header.z + list), last);
    }
}
#else
fn search_lists(number: u32, tile: vec2<i32>, mask: vec2<u32>) {
    let header = quad_1(number);
    test_references(header.x, header.x + header.y);
}
#endif
