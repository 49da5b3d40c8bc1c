//! The cache and the audit.

use super::*;

fn cached_scene() -> (Truth, Arc<Vec<Ray>>) {
    let truth = sphere(100.0, 2, [1, 1, 1]).truth();
    let mut numbers = tracebench_tests::Numbers::new(14);
    let rays = (0..32).map(|_| tracebench_tests::ray(numbers.point() * 150.0, numbers.direction())).collect();
    (truth, Arc::new(rays))
}

fn answer(truth: &Truth, rays: &Arc<Vec<Ray>>, cache: &Cache) -> Result<Vec<Answer>, TruthError> {
    truth.answer(rays, Query::Closest, cache, &Progress::new(true))
}

fn only_file(folder: &Path) -> PathBuf {
    let files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

/// Proves that answers are the same without a cache, with an empty one and with a filled one, that queries and scenes do
/// not share answers, and that a damaged file is told anew and mended.
#[test]
fn the_cache_changes_no_answer() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let fresh = answer(&truth, &rays, &Cache::none()).unwrap();
    assert!(fresh.iter().any(|each| each.hit.is_some()) && fresh.iter().any(|each| each.hit.is_none()));
    assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
    let path = only_file(folder.path());
    let stored = std::fs::read(&path).unwrap();
    assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
    for damage in [0, 40, stored.len() - 1] {
        let mut bytes = stored.clone();
        bytes[damage] ^= 0x10;
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
        assert_eq!(std::fs::read(&path).unwrap(), stored, "the file was not mended");
    }
    for shorter in [0, 31, 32, stored.len() - 16] {
        std::fs::write(&path, &stored[..shorter]).unwrap();
        assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
    }
    truth.answer(&rays, Query::Any, &cache, &Progress::new(true)).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    let other = Truth::new(truth.geometry(), "another scene");
    answer(&other, &rays, &cache).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

/// Proves that a cache that cannot be written costs nothing but time.
#[test]
fn a_cache_that_cannot_be_written_is_no_error() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, b"in the way").unwrap();
    let answers = answer(&truth, &rays, &Cache::in_folder(&file.join("below"))).unwrap();
    assert_eq!(answers, answer(&truth, &rays, &Cache::none()).unwrap());
}

/// Negative control of the audit: answers that are whole by their digest but wrong in one hit's t, its triangle, or in
/// whether there is one, are refused, with the ray named.
#[test]
fn the_audit_refuses_wrong_answers() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let fresh = answer(&truth, &rays, &cache).unwrap();
    let hit = fresh.iter().position(|each| each.hit.is_some()).unwrap();
    let path = only_file(folder.path());
    let stored = std::fs::read(&path).unwrap();
    // A record is t as f64, the triangle as u32, flags as u32 with bit 0 for a hit; SHA-256 of all follows.
    for (offset, flip) in [(0, 1), (8, 1), (12, 1)] {
        let mut body = stored[..stored.len() - 32].to_vec();
        body[hit * 16 + offset] ^= flip;
        let digest = Sha256::digest(&body);
        body.extend_from_slice(&digest);
        std::fs::write(&path, &body).unwrap();
        match answer(&truth, &rays, &cache) {
            Err(error @ TruthError::Audit { ray, by_brute_force, .. }) => {
                assert_eq!((ray, by_brute_force), (hit, fresh[hit].hit));
                assert!(error.to_string().contains(&folder.path().display().to_string()), "{error}");
            }
            other => panic!("not refused at {offset}: {other:?}"),
        }
    }
    std::fs::write(&path, &stored).unwrap();
    assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
}

/// The same of what an ambiguous ray hits when it is moved.
#[test]
fn the_audit_refuses_wrong_perturbed_answers() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let fresh = answer(&truth, &rays, &Cache::none()).unwrap();
    let at = fresh.iter().position(|each| each.hit.is_some()).unwrap();
    let mut ending = rays.to_vec();
    ending[at].t_max = fresh[at].hit.unwrap().t as f32;
    let ending = Arc::new(ending);
    let fresh = answer(&truth, &ending, &cache).unwrap();
    let before = fresh[..at].iter().filter(|each| each.is_ambiguous()).count();
    let perturbed = fresh[at].perturbed.clone().unwrap();
    assert!(perturbed[6].is_some() && perturbed[7].is_none(), "{perturbed:?}");
    let path = only_file(folder.path());
    let stored = std::fs::read(&path).unwrap();
    // Behind one record a ray eight of every ambiguous one; the seventh is of the span that ends later.
    let place = (rays.len() + 8 * before + 6) * 16;
    for (offset, flip) in [(0, 1), (8, 1), (12, 1)] {
        let mut body = stored[..stored.len() - 32].to_vec();
        body[place + offset] ^= flip;
        let digest = Sha256::digest(&body);
        body.extend_from_slice(&digest);
        std::fs::write(&path, &body).unwrap();
        match answer(&truth, &ending, &cache) {
            Err(TruthError::Audit { ray, by_brute_force, .. }) => assert_eq!((ray, by_brute_force), (at, perturbed[6])),
            other => panic!("not refused at {offset}: {other:?}"),
        }
    }
    std::fs::write(&path, &stored).unwrap();
    assert_eq!(answer(&truth, &ending, &cache).unwrap(), fresh);
}

/// Proves scenes of one triangle, and of many with the same bounds and centre, for which hierarchies are built in
/// special ways.
#[test]
fn hierarchies_of_odd_scenes() {
    let mut dice = Dice::new(15);
    let one = Scene { triangles: vec![[[0, 0, 0], [8, 1, 0], [2, 8, 3]]] };
    agree(
        &one,
        &(0..800).map(|_| ExactRay::endless([dice.within(6), dice.within(6), 8], [0, 0, -1])).collect::<Vec<_>>(),
    );
    let piled = Scene { triangles: vec![[[-4, -4, 0], [4, -4, 1], [0, 4, 0]]; 500] };
    agree(&piled, &rays(&mut dice, 800, 4));
    let line = Scene { triangles: (0..200).map(|x| [[x, 0, 0], [x, 2, 0], [x, 0, 2]]).collect() };
    let along: Vec<ExactRay> =
        (0..800).map(|_| ExactRay::endless([dice.within(250), dice.within(3), dice.within(3)], [1, 0, 0])).collect();
    agree(&line, &along);
    assert!(Geometry::new(Vec::new(), Vec::new(), None).is_err());
}
