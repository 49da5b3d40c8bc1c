//! The report against made-up runs.

use super::*;

fn looks(name: &str, run: &Run) {
    if let Ok(directory) = std::env::var("LOOK") {
        write_run(run, &Path::new(&directory).join(name)).unwrap();
    }
}

#[test]
fn look() {
    looks("typical", &fixture::typical());
    looks("crowded", &fixture::crowded());
}
