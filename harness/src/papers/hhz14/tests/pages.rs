//! Pages of HHZ14's tables: what stands on them, and that no time stands there without its accuracy.

use super::table_1;
use crate::papers::fixture::{page_of, run_of, take_judgements};
use crate::papers::{find, report};

/// Table 1 sets ratios beside the paper's, of the octree's rows alone, and of scenes that stand for the paper's.
#[test]
fn table_1_stands_beside_the_papers() {
    let mut record = run_of(table_1("solids"));
    let page = page_of("hhz14-table1", &record);
    // 35.6 over 10.8, 79.6 over 8.7, 109.1 over 22.1 as printed.
    for part in ["| 3.30 | 9.15 | 4.94 |", "| 9.00 |", "| 7.20 |", "90.00 at ", "stands for the paper's Figure 8 top"] {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
    let own: Vec<&str> = page.lines().filter(|line| line.starts_with("| solids | voxel-abuffer ")).collect();
    assert!(own.len() == 2 && own.iter().all(|row| row.ends_with("| – | – | – |")), "{own:?}");
    record.rows.iter_mut().for_each(|one| "barn".clone_into(&mut one.scene.name));
    assert!(!page_of("hhz14-table1", &record).contains("| 3.30 | 9.15 | 4.94 |"));
}

/// No page tells a trace's time where the rays could not be judged.
#[test]
fn no_time_without_accuracy() {
    for (name, rays) in [("hhz14-table1", "visibility"), ("hhz14-figure6", "ao"), ("hhz14-figure7", "pixel-random")] {
        let mut record = run_of(table_1("solids"));
        for one in &mut record.rows {
            one.traces[2].rays = "pixel-random".to_owned();
            one.traces.retain(|trace| name == "hhz14-table1" || trace.rays == rays);
            one.traces.iter_mut().for_each(|trace| trace.times.submit_to_done_median_ms = Some(77.25));
        }
        // A frame is three sets.
        let times =
            |page: &str| page.matches("77.25").count() + page.matches("231.7").count() + page.matches("231.8").count();
        assert!(times(&page_of(name, &record)) > 0, "{name}");
        take_judgements(&mut record);
        assert_eq!(times(&page_of(name, &record)), 0, "{name}");
    }
}

/// Every experiment's page is made of any run that holds its tracer, whatever rows there are.
#[test]
fn pages_are_made_of_any_run() {
    let record = run_of(table_1("atrium"));
    for name in ["hhz14-figure6", "hhz14-figure7", "hhz14-figure9", "hhz14-figure11", "hhz14-text", "hhz14-scenes"] {
        let (paper, experiment) = find(name).unwrap();
        let made = report(paper, experiment, &record).unwrap().contents().unwrap();
        assert!(made.iter().any(|(file, _)| file.ends_with(".md")), "{name}");
    }
}
