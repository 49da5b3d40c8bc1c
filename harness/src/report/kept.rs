//! Pictures that are kept beside a record, each named by the beginning of its hash.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::hash::sha256_of;
use crate::results::{AttackRecord, FramesRecord, FrontScene, PICTURES_FOLDER, Record};

/// Hexadecimal digits of a name.
const DIGITS: usize = 32;

/// What lies where a record, its folder or its file, says that a picture is, and whether it is that picture. A record names files of one
/// folder alone.
fn found(path: &Path, name: &str) -> Option<(Vec<u8>, bool)> {
    let folder = if path.is_dir() { path } else { path.parent()? };
    let is_hash = |hash: &&str| hash.len() == DIGITS && hash.bytes().all(|c| c.is_ascii_hexdigit());
    let hash = name.strip_suffix(".png").filter(is_hash)?;
    let bytes = fs::read(folder.join(PICTURES_FOLDER).join(name)).ok()?;
    let is_picture = sha256_of(&bytes).starts_with(hash);
    Some((bytes, is_picture))
}

/// A picture that a record names, where it is beside it.
pub(super) fn picture(path: &Path, name: &str) -> Option<Vec<u8>> {
    found(path, name).filter(|(_, is_picture)| *is_picture).map(|(bytes, _)| bytes)
}

/// The pictures that a record names.
pub(super) fn picture_files(record: &Record) -> impl Iterator<Item = &str> {
    let of_fronts = record.pareto.iter().flat_map(|section| &section.scenes).flat_map(FrontScene::picture_files);
    let of_frames = record.frames.iter().flat_map(FramesRecord::picture_files);
    of_fronts.chain(record.attack.iter().flat_map(AttackRecord::picture_files)).chain(of_frames)
}

/// The pictures that a record names and under whose names something else lies.
pub fn others(path: &Path, record: &Record) -> Vec<String> {
    let files: BTreeSet<&str> = picture_files(record).collect();
    let is_other = |name: &&str| found(path, name).is_some_and(|(_, is_picture)| !is_picture);
    files.into_iter().filter(is_other).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that a picture is what its name says, and that another one, a name cut short and one that leads elsewhere are not it.
    #[test]
    fn pictures_are_what_their_names_say() {
        let folder = tempfile::tempdir().unwrap();
        let pictures = folder.path().join(PICTURES_FOLDER);
        fs::create_dir(&pictures).unwrap();
        let hash = sha256_of(b"one");
        let name = format!("{}.png", &hash[..DIGITS]);
        let short = format!("{}.png", &hash[..4]);
        for name in [&name, &short] {
            fs::write(pictures.join(name), "one").unwrap();
        }
        assert_eq!(picture(folder.path(), &name), Some(b"one".to_vec()));
        assert_eq!(picture(&folder.path().join("run.json"), &name), Some(b"one".to_vec()));
        assert_eq!(found(folder.path(), &short), None);
        assert_eq!(found(folder.path(), &format!("../{PICTURES_FOLDER}/{name}")), None);
        fs::write(pictures.join(&name), "two").unwrap();
        assert_eq!(found(folder.path(), &name), Some((b"two".to_vec(), false)));
    }
}
