//! Answers on disk, by hash of scene, rays and query. A cache file that is missing, broken or foreign is as good as
//! none.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::{Answer, MOVES, TrueHit};

/// Part of every key: raised whenever the truth is told differently.
pub const VERSION: u32 = 5;

/// Bytes of a hit or miss: t as f64, primitive as u32, flags as u32. One of every ray, then the moved ones of every ambiguous ray.
const RECORD: usize = 16;
const HIT: u32 = 1;
const AMBIGUOUS: u32 = 2;
const DIGEST: usize = 32;

/// A folder of answers, or none.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// The user's cache: `TRACEBENCH_CACHE` if set (empty switches it off), else `tracebench` below `XDG_CACHE_HOME` or
    /// `~/.cache`.
    pub fn of_user() -> Self {
        let variable = |name| std::env::var_os(name).map(PathBuf::from);
        let filled = |name| variable(name).filter(|path| !path.as_os_str().is_empty());
        let folder = match variable("TRACEBENCH_CACHE") {
            Some(path) if path.as_os_str().is_empty() => None,
            Some(path) => Some(path),
            None => filled("XDG_CACHE_HOME")
                .or_else(|| filled("HOME").map(|home| home.join(".cache")))
                .map(|base| base.join("tracebench")),
        };
        Self { folder }
    }

    /// A cache in a given folder.
    pub fn in_folder(folder: &Path) -> Self {
        Self { folder: Some(folder.to_owned()) }
    }

    /// No cache.
    pub fn none() -> Self {
        Self { folder: None }
    }

    /// Where it is, for messages.
    pub fn describe(&self) -> String {
        self.folder.as_ref().map_or_else(|| "(none)".to_owned(), |folder| folder.display().to_string())
    }

    fn path(&self, key: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{key}.truth")))
    }

    /// The answers under a key, if they are there, whole and as many as expected.
    pub fn load(&self, key: &str, count: usize) -> Option<Vec<Answer>> {
        let bytes = std::fs::read(self.path(key)?).ok()?;
        let body_length = bytes.len().checked_sub(DIGEST)?;
        let (body, digest) = bytes.split_at(body_length);
        if Sha256::digest(body).as_slice() != digest {
            return None;
        }
        let (own, moved) = body.split_at_checked(count * RECORD)?;
        let own: Vec<(Option<TrueHit>, bool)> = own.chunks_exact(RECORD).map(decode).collect();
        if moved.len() != own.iter().filter(|(_, ambiguous)| *ambiguous).count() * MOVES * RECORD {
            return None;
        }
        let mut moved = moved.chunks_exact(RECORD).map(|record| decode(record).0);
        let answer = |(hit, ambiguous): (Option<TrueHit>, bool)| Answer {
            hit,
            perturbed: ambiguous.then(|| Box::new(std::array::from_fn(|_| moved.next().flatten()))),
        };
        Some(own.into_iter().map(answer).collect())
    }

    /// Keeps answers. Failing to is no error: they can be made again.
    pub fn store(&self, key: &str, answers: &[Answer]) {
        let Some(path) = self.path(key) else { return };
        let Some(folder) = path.parent() else { return };
        let own = answers.iter().flat_map(|answer| encode(answer.hit, answer.is_ambiguous()));
        let moved = answers.iter().filter_map(|answer| answer.perturbed.as_deref()).flatten();
        let mut body: Vec<u8> = own.chain(moved.flat_map(|hit| encode(*hit, false))).collect();
        let digest = Sha256::digest(&body);
        body.extend_from_slice(&digest);
        let write = || -> std::io::Result<()> {
            std::fs::create_dir_all(folder)?;
            let mut file = tempfile::NamedTempFile::new_in(folder)?;
            file.write_all(&body)?;
            file.persist(&path)?;
            Ok(())
        };
        // A full or read-only disk only costs the time to answer again.
        let _ = write();
    }
}

fn encode(hit: Option<TrueHit>, ambiguous: bool) -> [u8; RECORD] {
    let (t, primitive) = hit.map_or((0.0, 0), |hit| (hit.t, hit.primitive));
    let flags = u32::from(hit.is_some()) * HIT + u32::from(ambiguous) * AMBIGUOUS;
    let mut record = [0; RECORD];
    record[..8].copy_from_slice(&t.to_le_bytes());
    record[8..12].copy_from_slice(&primitive.to_le_bytes());
    record[12..].copy_from_slice(&flags.to_le_bytes());
    record
}

fn decode(record: &[u8]) -> (Option<TrueHit>, bool) {
    let word = |at: usize| u32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]);
    let t = f64::from_bits(u64::from(word(0)) | u64::from(word(4)) << 32);
    let flags = word(12);
    ((flags & HIT != 0).then(|| TrueHit { t, primitive: word(8) }), flags & AMBIGUOUS != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers() -> Vec<Answer> {
        let moved = |t: f64| Some(TrueHit { t, primitive: 3 });
        let perturbed = [moved(1.5), None, moved(-2.0), None, None, None, None, moved(f64::MAX)];
        let all = [moved(4.0); MOVES];
        vec![
            Answer { hit: Some(TrueHit { t: 1.25e-3, primitive: 7 }), perturbed: None },
            Answer { hit: None, perturbed: Some(Box::new(perturbed)) },
            Answer { hit: Some(TrueHit { t: 0.0, primitive: u32::MAX }), perturbed: Some(Box::new(all)) },
        ]
    }

    /// What is stored is loaded; a flipped bit, another count or another key loads nothing.
    #[test]
    fn a_broken_cache_is_no_cache() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path());
        cache.store("key", &answers());
        assert_eq!(cache.load("key", 3), Some(answers()));
        assert_eq!([0, 1, 2, 4, 11].map(|count| cache.load("key", count)), [const { None }; 5]);
        assert_eq!(cache.load("other", 3), None);
        let path = cache.path("key").unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[5] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(cache.load("key", 3), None);
        bytes.truncate(10);
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(cache.load("key", 3), None);
    }
}
