#define_import_path tracebench::dirt_list_walk

// The walk of a leg over the tiles of a face of the packed forms of DIRT without trees.

#import tracebench::lanes::open
#import tracebench::dirt_packed_ray::is_done
#import tracebench::dirt_packed_walk::{is_walking, entered, begin_steps, step_on, entered_number}
#import tracebench::dirt_tile_lists::search_lists

fn walk(face: u32) {
    begin_steps(face);
    open += 1u;
    loop {
        if (!is_walking || is_done()) {
            open -= 1u;
            break;
        }
        if (step_on(true)) {
            search_lists(entered_number(), entered.tile, entered.mask);
        }
    }
}
