//! Prints the depth layers of procedural scenes as a table: `layers [SCENE] [--scale S] [--view NAME] [--time S]`.
//!
//! Without a scene it prints the whole catalogue, each scene from every one of its viewpoints.

use std::error::Error;

use layers::{LayerCount, count_layers};
use tracebench_scenes::{catalogue, procedural};

#[path = "../tests/support/layers.rs"]
mod layers;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut wanted, mut scale, mut view, mut time_s) = (None, 1.0, None, 0.0);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--scale" => scale = value()?.parse()?,
            "--view" => view = Some(value()?),
            "--time" => time_s = value()?.parse()?,
            _ => wanted = Some(argument),
        }
    }
    println!("Seven views: 720 x 480 and six faces of 480 x 480. One view: 800 x 800. Averages over all pixels, in");
    println!("brackets over covered ones.\n");
    println!("| scene | viewpoint | fragments, 7 views | avg/max, 7 views | fragments, 1 view | avg/max, 1 view |");
    println!("| --- | --- | ---: | ---: | ---: | ---: |");
    let names = match wanted {
        Some(name) => vec![name],
        None => catalogue().iter().map(|entry| entry.name.to_owned()).collect(),
    };
    for name in names {
        let mut scene = procedural(&name, scale)?;
        scene.set_time(time_s)?;
        for camera in scene.cameras.iter().filter(|camera| view.as_ref().is_none_or(|view| *view == camera.name)) {
            let seven = count_layers(&scene, camera, [720, 480], Some(480)).total();
            let one = count_layers(&scene, camera, [800, 800], None).total();
            println!("| `{name}` | `{}` | {} | {} |", camera.name, cells(&seven), cells(&one));
        }
    }
    Ok(())
}

fn cells(count: &LayerCount) -> String {
    let millions = count.fragments as f64 / 1e6;
    format!("{millions:.2} M | {:.2} ({:.2}) / {}", count.average_of_all(), count.average_of_covered(), count.max)
}
