//! Scenes and places as users have them: names that look like something else, things that are not there at the time, views of nothing.

use super::*;

/// The document of a triangle with cameras of these names, all at (0, 0, 5) and looking along -z, the n-th moved by n along x.
fn seen_by(cameras: &[&str]) -> Vec<u8> {
    let bin: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let mut document = gltf(3, bin.len(), None);
    for (index, name) in cameras.iter().enumerate() {
        let list = |document: &mut Value, key: &str, value: Value| match document[key].as_array_mut() {
            Some(values) => values.push(value),
            None => document[key] = json!([value]),
        };
        list(&mut document, "cameras", json!({"name": name, "type": "perspective", "perspective": {"yfov": 0.7}}));
        list(&mut document, "nodes", json!({"camera": index, "translation": [index, 0, 5]}));
        document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index + 1));
    }
    packed(&document, &bin)
}

/// What is said of a view of nothing.
const NOTHING: &str = "no ray hits anything";

const PRIMARY: [&str; 4] = ["--tracer", "bvh-cpu", "--rays", "primary"];

/// Proves that a camera is found by its name whatever that looks like, before a pose is read, and that a pose still is one.
#[test]
fn cameras_come_before_poses() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), seen_by(&["front", "char:shotCam", "0,0,9:0,0,0", "a,b"])).unwrap();
    for (view, name, x) in [
        ("char:shotCam", "char:shotCam", 1.0),
        ("0,0,9:0,0,0", "0,0,9:0,0,0", 2.0),
        ("a,b", "a,b", 3.0),
        ("-4,0,9:0,0,0", "given", -4.0),
    ] {
        let run = bench.run(&[&["--scene", "one.glb", "--view", view][..], &PRIMARY].concat(), "out");
        let viewpoint = &run["rows"][0]["viewpoint"];
        assert_eq!((viewpoint["name"].as_str(), viewpoint["eye"][0].as_f64()), (Some(name), Some(x)), "{view}");
    }
    let out = bench.text("none");
    for view in ["char:other", "1,2", "1,2,3:x,y,z"] {
        let call = [&SMOKE[..], &["--scene", "one.glb", "--view", view, "--out", &out], &PRIMARY].concat();
        bench.fails(&call, 2, &["--view", view, "char:shotCam"]);
    }
}

/// Proves that files of one stem are distinguished by their folders or endings in the record, on the page and in the tables, that one
/// which shares its name with nothing keeps it, and that one may be called as a scene of the catalogue.
#[test]
fn files_of_one_stem_are_distinguished() {
    let bench = Bench::new();
    for (index, path) in ["a/box.glb", "b/box.glb", "b/box.gltf", "b/other.glb", "room.glb"].iter().enumerate() {
        let path = bench.path(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, glb(&TRIANGLE.map(|[x, y, z]| [x * (index + 1) as f32, y, z]))).unwrap();
    }
    let scenes = ["--scene", "a/box.glb,room,b/box.glb,b/other.glb,b/box.gltf,./room.glb"];
    let run = bench.run(&[&scenes[..], &PRIMARY].concat(), "out");
    let found: Vec<&str> =
        run["rows"].as_array().unwrap().iter().map(|row| row["scene"]["name"].as_str().unwrap()).collect();
    assert_eq!(found, ["a/box.glb", "room", "b/box.glb", "other", "b/box.gltf", "./room.glb"]);
    let text = |name: &str| std::fs::read_to_string(bench.path("out").join(name)).unwrap();
    for name in found {
        assert_eq!(text("summary.md").matches(&format!("\n## {name} (")).count(), 1, "{name}");
        assert!(text("rows.csv").lines().any(|line| line.split(',').any(|field| field == name)), "{name}");
    }
    assert!(names(&bench.path("out")).contains("error_vs_speed_a_box_glb.svg"), "{:?}", names(&bench.path("out")));
}

/// Proves that a path which is there is one path whatever is in it, also one that is no text, and that lists are lists where there
/// is no such path.
#[test]
fn scenes_have_any_path() {
    let bench = Bench::new();
    let wide = glb(&TRIANGLE.map(|[x, y, z]| [2.0 * x, y, z]));
    for (name, bytes) in [("one,two.glb", &wide), (" spaced .glb", &wide), ("one.glb", &glb(&TRIANGLE))] {
        std::fs::write(bench.path(name), bytes).unwrap();
    }
    let scenes = |scene: &str| -> Vec<String> {
        let run = bench.run(&[&["--scene", scene][..], &PRIMARY].concat(), "out");
        run["rows"].as_array().unwrap().iter().map(|row| row["scene"]["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(scenes("one,two.glb"), ["one,two"]);
    assert_eq!(scenes(" spaced .glb"), [" spaced "]);
    assert_eq!(scenes("one.glb, room"), ["one", "room"]);
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt as _;
        let odd = OsStr::from_bytes(b"\xff,\xfe.glb");
        std::fs::write(bench.folder.path().join(odd), &wide).unwrap();
        let out = bench.text("odd");
        let last = ["--out", out.as_str(), "--scene"];
        let mut call: Vec<&OsStr> = SMOKE.iter().chain(&PRIMARY).chain(&last).map(OsStr::new).collect();
        call.push(odd);
        let outcome = bench.call(&call);
        assert_eq!(outcome.status, 0, "{outcome:?}");
        assert_eq!(bench.result("odd")["rows"][0]["scene"]["triangles"], 1);
    }
}

/// Proves that names stand as they are in Markdown and HTML, whatever looks like markup in them.
#[test]
fn names_are_no_markup() {
    let bench = Bench::new();
    let name = "_a_ *b* **c** [d](e) <i>f &amp; `g` ~~h~~ \\_i";
    let camera = "[k]: __l__ <b>m";
    std::fs::write(bench.path(&format!("{name}.glb")), seen_by(&[camera])).unwrap();
    bench.run(&[&["--scene", &format!("{name}.glb")][..], &PRIMARY].concat(), "out");
    let page = std::fs::read_to_string(bench.path("out/summary.md")).unwrap();
    let events: Vec<pulldown_cmark::Event<'_>> = pulldown_cmark::Parser::new_ext(
        &page,
        pulldown_cmark::Options::ENABLE_TABLES | pulldown_cmark::Options::ENABLE_STRIKETHROUGH,
    )
    .collect();
    let text: String = events
        .iter()
        .map(|event| match event {
            pulldown_cmark::Event::Text(text) => text.to_string(),
            _ => String::new(),
        })
        .collect();
    assert!(
        text.contains(&format!("{name} (1 triangles)")) && text.contains(&format!("Viewpoint {camera} at")),
        "{page}"
    );
    let out = bench.text("page.html");
    let outcome = bench.call(&["report", "out", "--html", &out]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let html = std::fs::read_to_string(out).unwrap();
    let escaped = name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    assert!(html.contains(&format!("{escaped} (1 triangles)")), "the heading of the scene");
    for markup in ["<em>a", "<em>b", "<strong>c", "<i>f", "<b>m", "<code>g", "<del>h", "<strong>l"] {
        assert!(!html.contains(markup), "{markup}");
    }
}

/// A triangle that stands still beside one that is not there at time 0 and at time 1 is.
fn popping() -> Vec<u8> {
    let mut bin: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let mut document = gltf(3, bin.len(), None);
    for (kind, values) in [("SCALAR", &[0.0_f32, 1.0][..]), ("VEC3", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0])] {
        let view = json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": 4 * values.len()});
        document["bufferViews"].as_array_mut().unwrap().push(view);
        bin.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let views = document["bufferViews"].as_array().unwrap().len();
        let accessor = json!({"bufferView": views - 1, "componentType": 5126, "type": kind, "count": 2});
        document["accessors"].as_array_mut().unwrap().push(accessor);
    }
    document["buffers"][0]["byteLength"] = json!(bin.len());
    document["nodes"] = json!([{"mesh": 0, "translation": [3, 0, 0]}, {"mesh": 0, "name": "body"}]);
    document["scenes"][0]["nodes"] = json!([0, 1]);
    document["animations"] = json!([{
        "samplers": [{"input": 1, "output": 2}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "scale"}}],
    }]);
    packed(&document, &bin)
}

/// Proves that what has no area at the time that is traced is left out with a warning in every place, and is there at another time; and
/// that a study of several frames has it at all of them.
#[test]
fn what_pops_in_is_there_when_it_is() {
    let bench = Bench::new();
    std::fs::write(bench.path("pop.glb"), popping()).unwrap();
    let scene = ["--scene", "pop.glb", "--view", "1,0,9:1,0,0"];
    for (time, triangles) in [("0", 1), ("1", 2), ("0.5", 2)] {
        let run = bench.run(&[&scene[..], &["--animation-time", time], &PRIMARY].concat(), "out");
        let found = &run["rows"][0]["scene"];
        assert_eq!(found["triangles"], triangles, "{time}");
        assert_eq!(found["warnings"].as_array().unwrap().len(), 2 - triangles, "{found}");
        let page = std::fs::read_to_string(bench.path("out/summary.md")).unwrap();
        assert_eq!(page.contains("at 0 s 1 of 2 triangles have zero area and are left out"), triangles == 1, "{page}");
    }
    let out = bench.text("frames");
    let words = [
        "frames", "--scene", "pop.glb", "--rays", "primary", "--tracer", "bvh-cpu", "--preset", "smoke", "--size",
        "16x8",
    ];
    let outcome =
        bench.call(&[&words[..], &["--move", "geometry", "--frames", "2", "--fps", "1", "--out", &out]].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert_eq!(bench.result("frames")["frames"]["scenes"][0]["scene"]["triangles"], 2);
}

/// Proves that a view of nothing says so in every verb and shows no share of right answers, and that a view of something shows it.
#[test]
fn views_of_nothing_say_so() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    let common = ["--scene", "one.glb", "--rays", "primary", "--preset", "smoke", "--size", "16x8"];
    for (view, is_nothing) in [("0,0,5:0,0,9", true), ("0,0,5:0,0,0", false)] {
        let cpu = ["--tracer", "bvh-cpu"];
        for (verb, page) in [
            (&["run"][..], "summary.md"),
            (&["sweep"], "sweep.md"),
            (&["explain"], "explain.md"),
            (&["table", "bvh"], "table_bvh.md"),
            (&["need"], "need.md"),
            (&["sweep", "--choose", "footprint"], "sweep.md"),
        ] {
            let out = bench.text("out");
            let tunes = verb.contains(&"--choose");
            let tracer = match verb[0] {
                "table" => &[][..],
                "need" => &["--tracer", "dirt"],
                "sweep" if tunes => &["--tracer", "screen-dda", "--over", "thickness=0,1"],
                "explain" => &["--tracer", "quadtree"],
                _ => &cpu,
            };
            let outcome = bench.call(&[verb, &common, tracer, &["--view", view, "--out", &out]].concat());
            assert_eq!(outcome.status, 0, "{verb:?}: {outcome:?}");
            assert_eq!(outcome.stderr.contains(NOTHING), is_nothing, "{verb:?}: {outcome:?}");
            let page = std::fs::read_to_string(bench.path("out").join(page)).unwrap();
            assert_eq!(page.contains(NOTHING), is_nothing, "{verb:?}: {page}");
            if verb[0] != "explain" && !tunes {
                assert_eq!(page.contains("100 % ["), !is_nothing, "{verb:?}: {page}");
            }
            assert!(!(is_nothing && tunes && page.contains("100 %")), "{verb:?}: {page}");
            if verb[0] == "run" {
                assert_eq!(outcome.stdout.contains("100 %"), !is_nothing, "{outcome:?}");
                assert_eq!(outcome.stdout.contains(NOTHING), is_nothing, "{outcome:?}");
                let again = bench.call(&["compare", "out", "out"]);
                assert_eq!(again.stdout.contains("100 %"), !is_nothing, "{again:?}");
            }
            std::fs::remove_dir_all(bench.path("out")).unwrap();
        }
    }
}

/// Proves that a backend which serves only in part is refused in one line with what to do, and that tracers of the host go on. Where
/// there is none, that is said in one line, too.
#[test]
fn backends_that_serve_in_part_are_refused() {
    let bench = Bench::new();
    for tracer in ["dirt", "fragment-abuffer", "screen-dda", "ploc-gpu"] {
        let out = bench.text("out");
        let call = [&SMOKE[..], &["--tracer", tracer, "--rays", "primary", "--quiet", "--out", &out]].concat();
        let outcome = Bench::finish(bench.command(&call).env("WGPU_BACKEND", "gl"));
        assert_eq!((outcome.status, outcome.stderr.lines().count()), (1, 1), "{outcome:?}");
        assert!(
            !outcome.stderr.contains("Caused by") && outcome.stderr.contains("a tracer that runs on the host"),
            "{outcome:?}"
        );
    }
    let out = bench.text("host");
    let call = [&SMOKE[..], &PRIMARY, &["--out", &out]].concat();
    assert_eq!(Bench::finish(bench.command(&call).env("WGPU_BACKEND", "gl")).status, 0);
}
