//! A set of rays as a folder: a manifest, an array a field, and the truth.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use tracebench_api::{Query, Ray};
use tracebench_scenes::Scene;

use super::{ExchangeError, glb, npy, text};
use crate::files::{self, OutputFolder};
use crate::hash::{sha256_of, sha256_of_file};
use crate::judge::REFERENCE_PIXELS;
use crate::rays::sampling::Stream;
use crate::rays::{KnownRays, MAX_RAYS, RaySet};
use crate::results::{RULES_VERSION, SceneRecord, ViewpointRecord};
use crate::truth::{Answer, MOVES, Ray64, TrueHit, Truth};

/// The file that says what the arrays beside it are.
pub const MANIFEST: &str = "manifest.json";

/// The files of the truth.
const TRUTH: [&str; 5] = ["t.npy", "triangle.npy", "ambiguous.npy", "perturbed_t.npy", "perturbed_triangle.npy"];

/// What arrays of triangles say where nothing is hit.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// How many truths are computed anew before answers are judged by them.
pub const TRUTHS_CHECKED: usize = 1000;

/// By how much the length of a direction may be off 1.
const MAX_OFF_UNIT: f32 = 1e-4;

/// Not a tag of any set of rays.
const CHECK_TAG: u64 = 1001;

/// What a set of rays is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Of the set.
    pub name: String,
    /// What is asked of the rays.
    pub query: Query,
    /// Rays.
    pub count: u64,
    /// Hash of the rays, 32 bytes each: origin, `t_min`, direction, `t_max`, as f32 in little-endian order.
    pub rays_sha256: String,
    /// Hashes of the files of the truth; empty of a set without.
    #[serde(default)]
    pub truth_sha256: BTreeMap<String, String>,
    /// The scene.
    pub scene: SceneRecord,
    /// The eye, from which the reference camera looks whose pixel `footprint` is of, and how rays were made; none of rays without an eye.
    pub viewpoint: Option<ViewpointRecord>,
    /// Seed of the rays.
    #[serde(default)]
    pub seed: u64,
    /// What was said about ray sets.
    #[serde(default)]
    pub ray_parameters: BTreeMap<String, Value>,
    /// What is the same of all sets of this version.
    #[serde(flatten)]
    pub fixed: Map<String, Value>,
}

/// What all sets of this version say. `perturbed`: how an ambiguous ray was moved, in the order of the columns.
fn fixed() -> Map<String, Value> {
    let units = "scene units, right-handed; t along unit directions; degrees; seconds";
    let moves =
        ["origin right", "origin left", "origin up", "origin down", "t_min up", "t_min down", "t_max up", "t_max down"];
    let all = json!({ "format": "tracebench rays", "version": 1, "rules_version": RULES_VERSION, "units": units,
                      "reference_pixels": REFERENCE_PIXELS, "perturbed": moves });
    all.as_object().cloned().unwrap_or_default()
}

impl Manifest {
    /// Of rays with their truth.
    pub fn new(
        name: &str,
        query: Query,
        (rays, answers): (&[Ray], &[Answer]),
        scene: SceneRecord,
        viewpoint: Option<ViewpointRecord>,
        seed: u64,
    ) -> Self {
        let truth_sha256 = truth_files(answers).map(|(name, bytes)| (name.to_owned(), sha256_of(&bytes))).collect();
        let (name, count, rays_sha256) = (name.to_owned(), rays.len() as u64, sha256_of(rays));
        let (ray_parameters, fixed) = (BTreeMap::new(), fixed());
        Self { name, query, count, rays_sha256, truth_sha256, scene, viewpoint, seed, ray_parameters, fixed }
    }

    /// The eye, if the rays have one.
    pub fn eye(&self) -> Option<glam::DVec3> {
        self.viewpoint.as_ref().map(|viewpoint| glam::DVec3::from(viewpoint.eye.map(f64::from)))
    }

    fn read(path: &Path) -> Result<Self, ExchangeError> {
        let invalid = |problem: String| ExchangeError::invalid(path, problem);
        let manifest: Self = serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_str(&text(path)?))
            .map_err(|error| invalid(format!("`{}`: {}", error.path(), error.inner())))?;
        if let Some((key, value)) = fixed().into_iter().find(|(key, value)| manifest.fixed.get(key) != Some(value)) {
            return Err(invalid(format!("`{key}` must be {value}: write the set by this version of the program")));
        }
        let Self { name, count, scene, viewpoint, .. } = &manifest;
        let finite = |of: &ViewpointRecord| {
            let ViewpointRecord { eye, forward, up, vertical_fov_degrees, near, far, .. } = of;
            eye.iter().chain(forward).chain(up).chain([vertical_fov_degrees, near, far]).all(|part| part.is_finite())
        };
        let rules = [
            ("name", is_name(name), "1 to 64 letters, digits and -_. +:=@".to_owned()),
            ("count", (1..=MAX_RAYS).contains(count), format!("from 1 to {MAX_RAYS}")),
            ("scene.diagonal", scene.diagonal.is_finite(), "a number".to_owned()),
            ("viewpoint", viewpoint.as_ref().is_none_or(finite), "of finite numbers".to_owned()),
        ];
        match rules.into_iter().find(|(_, holds, _)| !holds) {
            Some((field, _, must)) => Err(invalid(format!("`{field}` must be {must}"))),
            None => Ok(manifest),
        }
    }
}

/// Whether a text may be the name of a set or of who answered it.
pub(crate) fn is_name(text: &str) -> bool {
    let sound = |letter: char| letter.is_ascii_alphanumeric() || "-_. +:=@".contains(letter);
    (1..=64).contains(&text.len()) && text.chars().all(sound) && text.trim() == text && !text.starts_with('.')
}

/// Rays that were read from a folder.
#[derive(Clone, Debug)]
pub struct SavedRays {
    /// What they are.
    pub manifest: Manifest,
    /// The rays.
    pub rays: Arc<Vec<Ray>>,
}

/// The truth as files, made one after the other.
fn truth_files(answers: &[Answer]) -> impl Iterator<Item = (&'static str, Vec<u8>)> {
    let t = |hit: Option<TrueHit>| hit.map_or(f64::INFINITY, |hit| hit.t);
    let triangle = |hit: Option<TrueHit>| hit.map_or(NO_TRIANGLE, |hit| hit.primitive);
    let all = |answer: &Answer| answer.perturbed.as_deref().copied().unwrap_or([answer.hit; MOVES]);
    TRUTH.into_iter().map(move |name| {
        let (own, moved) = (answers.iter().map(|answer| answer.hit), answers.iter().flat_map(all));
        let file = match name {
            "t.npy" => npy::write(None, &own.map(t).collect::<Vec<f64>>()),
            "triangle.npy" => npy::write(None, &own.map(triangle).collect::<Vec<u32>>()),
            "ambiguous.npy" => npy::write(None, &answers.iter().map(Answer::is_ambiguous).collect::<Vec<bool>>()),
            "perturbed_t.npy" => npy::write(Some(MOVES), &moved.map(t).collect::<Vec<f64>>()),
            _ => npy::write(Some(MOVES), &moved.map(triangle).collect::<Vec<u32>>()),
        };
        (name, file)
    })
}

/// Writes a set with its truth below a folder of results, into `below` where that is not empty. `pixels`: column and row of the pixel that
/// every ray started from, or nothing.
///
/// # Errors
/// If a file cannot be written.
pub fn write(
    folder: &OutputFolder,
    below: &str,
    manifest: &Manifest,
    (rays, answers): (&[Ray], &[Answer]),
    pixels: &[[u32; 2]],
) -> Result<(), ExchangeError> {
    let put = |name: &str, contents: &[u8]| {
        let path = if below.is_empty() { name.to_owned() } else { format!("{below}/{name}") };
        folder.write(&path, contents).map(drop)
    };
    let vectors = |of: fn(&Ray) -> [f32; 3]| npy::write(Some(3), &rays.iter().flat_map(of).collect::<Vec<f32>>());
    let ends = |of: fn(&Ray) -> f32| npy::write(None, &rays.iter().map(of).collect::<Vec<f32>>());
    put("origin.npy", &vectors(|ray| ray.origin))?;
    put("direction.npy", &vectors(|ray| ray.direction))?;
    put("t_min.npy", &ends(|ray| ray.t_min))?;
    put("t_max.npy", &ends(|ray| ray.t_max))?;
    if !pixels.is_empty() {
        put("pixel.npy", &npy::write(Some(2), pixels.as_flattened()))?;
    }
    truth_files(answers).try_for_each(|(name, file)| put(name, &file))?;
    // The last, so that a folder with one is whole.
    put(MANIFEST, &files::json(MANIFEST, manifest)?)?;
    Ok(())
}

/// Reads the rays of a folder and checks them with their hash. The truth is not looked at.
///
/// # Errors
/// [`ExchangeError`] with the field that is not as it must be.
pub fn read(folder: &Path) -> Result<SavedRays, ExchangeError> {
    let manifest = Manifest::read(&folder.join(MANIFEST))?;
    let (count, path) = (manifest.count as usize, |name: &str| folder.join(name));
    let origin = npy::read::<f32>(&path("origin.npy"), Some(3), count)?;
    let direction = npy::read::<f32>(&path("direction.npy"), Some(3), count)?;
    let t_min = npy::read::<f32>(&path("t_min.npy"), None, count)?;
    let t_max = npy::read::<f32>(&path("t_max.npy"), None, count)?;
    let vector = |of: &[f32], at: usize| [of[3 * at], of[3 * at + 1], of[3 * at + 2]];
    let mut rays = Vec::with_capacity(count);
    for at in 0..count {
        let (origin, direction) = (vector(&origin, at), vector(&direction, at));
        let ray = Ray { origin, t_min: t_min[at], direction, t_max: t_max[at] };
        let is_unit = (glam::Vec3::from(direction).length() - 1.0).abs() <= MAX_OFF_UNIT;
        let rules = [
            ("origin.npy", origin.iter().all(|part| part.is_finite()), "of finite numbers"),
            ("direction.npy", is_unit, "of unit vectors"),
            ("t_min.npy", (0.0..=Ray::UNBOUNDED).contains(&ray.t_min), "from 0 to 1e30"),
            ("t_max.npy", (ray.t_min..=Ray::UNBOUNDED).contains(&ray.t_max), "from t_min to 1e30, which is no end"),
        ];
        if let Some((name, _, must)) = rules.into_iter().find(|(_, holds, _)| !holds) {
            return Err(ExchangeError::invalid(&path(name), format!("must be {must}; that of ray {at} is not")));
        }
        rays.push(ray);
    }
    if sha256_of(&rays) != manifest.rays_sha256 {
        return Err(ExchangeError::invalid(
            &path(MANIFEST),
            "`rays_sha256` is not that of the arrays: they were changed",
        ));
    }
    Ok(SavedRays { manifest, rays: Arc::new(rays) })
}

/// The rays of a folder as a ray set, `--rays file:DIR`.
///
/// # Errors
/// As [`read`].
pub fn ray_set(folder: &Path) -> Result<RaySet, ExchangeError> {
    RaySet::of_folder(folder, || {
        let SavedRays { manifest, rays } = read(folder)?;
        let (eye, sha256, scene_sha256) = (manifest.eye(), manifest.rays_sha256, manifest.scene.sha256);
        Ok((manifest.name, manifest.query, KnownRays { rays, sha256, eye, scene_sha256 }))
    })
}

/// Reads the truth of a set and checks its files with their hashes.
///
/// # Errors
/// [`ExchangeError`] with the field that is not as it must be.
pub fn read_truth(folder: &Path, manifest: &Manifest) -> Result<Vec<Answer>, ExchangeError> {
    let (count, path) = (manifest.count as usize, |name: &str| folder.join(name));
    for name in TRUTH {
        let known = manifest.truth_sha256.get(name);
        if known.is_none() || sha256_of_file(&path(name)).as_ref() != known {
            let problem = "is not there, or not as `truth_sha256` of manifest.json says: take a set with its truth";
            return Err(ExchangeError::invalid(&path(name), problem));
        }
    }
    let t = npy::read::<f64>(&path("t.npy"), None, count)?;
    let triangle = npy::read::<u32>(&path("triangle.npy"), None, count)?;
    let ambiguous = npy::read::<bool>(&path("ambiguous.npy"), None, count)?;
    let moved_t = npy::read::<f64>(&path("perturbed_t.npy"), Some(MOVES), count)?;
    let moved_triangle = npy::read::<u32>(&path("perturbed_triangle.npy"), Some(MOVES), count)?;
    let answer = |at: usize| {
        let hit = |name: &str, t: f64, triangle: u32| match (t == f64::INFINITY, triangle == NO_TRIANGLE) {
            (true, true) => Ok(None),
            (false, false) if t.is_finite() && u64::from(triangle) < manifest.scene.triangles => {
                Ok(Some(TrueHit { t, primitive: triangle }))
            }
            _ => Err(ExchangeError::invalid(
                &path(name),
                format!("of ray {at} is neither a hit on a triangle nor inf and none"),
            )),
        };
        let own = hit("t.npy", t[at], triangle[at])?;
        let mut moved = [None; MOVES];
        for (place, slot) in (at * MOVES..).zip(&mut moved) {
            *slot = hit("perturbed_t.npy", moved_t[place], moved_triangle[place])?;
        }
        if !ambiguous[at] && moved != [own; MOVES] {
            let problem = format!("of ray {at}, which is not ambiguous, does not repeat t.npy and triangle.npy");
            return Err(ExchangeError::invalid(&path("perturbed_t.npy"), problem));
        }
        Ok(Answer { hit: own, perturbed: ambiguous[at].then(|| Box::new(moved)) })
    };
    (0..count).map(answer).collect()
}

/// Computes 1,000 truths anew, which the seed chooses, and compares them with those of a set.
///
/// # Errors
/// [`ExchangeError`] with the first ray that has another truth.
pub fn check_truth(
    folder: &Path,
    truth: &Truth,
    set: &SavedRays,
    answers: &[Answer],
    seed: u64,
) -> Result<(), ExchangeError> {
    let differs = |check: u64| {
        let at = (Stream::new(seed, CHECK_TAG, check).unit() * answers.len() as f64) as usize;
        (truth.answer_one(&Ray64::from(&set.rays[at]), set.manifest.query) != answers[at]).then_some(at)
    };
    let found = (0..TRUTHS_CHECKED as u64).into_par_iter().find_map_first(differs);
    found.map_or(Ok(()), |at| {
        let problem =
            format!("is not the truth of ray {at}, computed anew: write the set by this version of the program");
        Err(ExchangeError::invalid(&folder.join("t.npy"), problem))
    })
}

/// The scene of a set, in its folder or in the one above, whose hash is checked.
///
/// # Errors
/// [`ExchangeError`] if it cannot be read, or is another one.
pub fn scene(folder: &Path, manifest: &Manifest) -> Result<Scene, ExchangeError> {
    let own = folder.join(glb::SCENE_FILE);
    // By the file system and not by the text, which may end in dots.
    let path = if own.exists() { own } else { folder.join("..").join(glb::SCENE_FILE) };
    let scene = tracebench_scenes::import(&path)?;
    if scene.sha256 != manifest.scene.sha256 || scene.mesh.triangles.len() as u64 != manifest.scene.triangles {
        let problem = format!("`scene.sha256` is not that of {}: the rays are of another scene", glb::SCENE_FILE);
        return Err(ExchangeError::invalid(&folder.join(MANIFEST), problem));
    }
    Ok(Scene { name: manifest.scene.name.clone(), ..scene })
}
