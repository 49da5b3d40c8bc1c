//! Pictures that are kept beside a record, each named by the beginning of its hash.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::hash::sha256_of;
use crate::results::{AttackRecord, FramesRecord, FrontScene, PICTURES_FOLDER, Record};

/// Hexadecimal digits of a name.
const DIGITS: usize = 32;

/// What lies where a record says that a picture is.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    Picture(Vec<u8>),
    /// Something else under its name.
    Other,
    Missing,
}

/// Looks for a picture beside a record, its folder or its file. A record names files of one folder alone.
pub(crate) fn picture(path: &Path, name: &str) -> Kept {
    let folder = if path.is_dir() { Some(path) } else { path.parent() };
    let is_hash = |hash: &&str| hash.len() == DIGITS && hash.bytes().all(|c| c.is_ascii_hexdigit());
    let (Some(folder), Some(hash)) = (folder, name.strip_suffix(".png").filter(is_hash)) else { return Kept::Missing };
    match fs::read(folder.join(PICTURES_FOLDER).join(name)) {
        Ok(bytes) if sha256_of(&bytes).starts_with(hash) => Kept::Picture(bytes),
        Ok(_) => Kept::Other,
        Err(_) => Kept::Missing,
    }
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
    files.into_iter().filter(|name| picture(path, name) == Kept::Other).map(str::to_owned).collect()
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
        assert_eq!(picture(folder.path(), &name), Kept::Picture(b"one".to_vec()));
        assert_eq!(picture(&folder.path().join("run.json"), &name), Kept::Picture(b"one".to_vec()));
        assert_eq!(picture(folder.path(), &short), Kept::Missing);
        assert_eq!(picture(folder.path(), &format!("../{PICTURES_FOLDER}/{name}")), Kept::Missing);
        fs::write(pictures.join(&name), "two").unwrap();
        assert_eq!(picture(folder.path(), &name), Kept::Other);
    }
}
