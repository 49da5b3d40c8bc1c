//! A folder of results with the list of what was written there. Only what is on the list, and as it was written, is ever replaced or
//! removed. Links are never followed.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{FileError, temporary, writing};
use crate::hash::sha256_of;

/// The list of a folder: a line a file, in the form of `sha256sum`. While a process writes into the folder it holds the list's lock.
pub const LIST: &str = "tracebench.sha256";

/// The first line of a list.
const HEADER: &str = "# tracebench wrote these files; it replaces or removes no others in this folder\n";

/// How long another process that is about to end is waited for.
const PATIENCE: Duration = Duration::from_secs(1);
const BETWEEN_TRIES: Duration = Duration::from_millis(20);

/// A folder that this process alone writes results into.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that were made for it, the outermost last. They are removed again, while empty, when nothing comes of the work.
    made: Vec<PathBuf>,
    list: Mutex<List>,
}

/// What lies under a name: the hash of a regular file, `None` for nothing, or in words what is never replaced or removed.
type Entry = Result<Option<String>, String>;

impl OutputFolder {
    /// Opens a folder, and makes it if need be.
    ///
    /// # Errors
    /// If it cannot be written, another process writes into it, or its list is none.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        let fail = |source| FileError::Folder(path.to_owned(), source);
        let missing = |part: &&Path| !part.as_os_str().is_empty() && !part.exists();
        let made: Vec<PathBuf> = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        let writable = fs::create_dir_all(path).and_then(|()| temporary(path)).map(drop).map_err(fail);
        match writable.and_then(|()| List::open(path)) {
            Ok(list) => Ok(Self { path: path.to_owned(), made, list: Mutex::new(list) }),
            Err(error) => {
                remove_empty(&made);
                Err(error)
            }
        }
    }

    /// A new folder below `parent`; where its name is taken a number is appended.
    pub(crate) fn fresh(parent: &Path, name: &str) -> Result<Self, FileError> {
        let is_first = !parent.exists();
        let made = fs::create_dir_all(parent);
        let is_taken = |error: io::Error| made.is_ok() && error.kind() == ErrorKind::AlreadyExists;
        let mut path = parent.join(name);
        for attempt in 2.. {
            if !fs::create_dir(&path).is_err_and(is_taken) {
                break;
            }
            path = parent.join(format!("{name}-{attempt}"));
        }
        let mut folder = Self::open(&path)?;
        folder.made = std::iter::once(path).chain(is_first.then(|| parent.to_owned())).collect();
        Ok(folder)
    }

    /// The folder of a single file, which must be there, and the file's name.
    pub(crate) fn of_file(path: &Path) -> Result<(Self, String), FileError> {
        let fail = |source| FileError::Write(path.to_owned(), source);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::read_dir(folder).map_err(fail)?;
        let name = path.file_name().and_then(|name| name.to_str()).filter(|name| is_below(name));
        let name = name.ok_or_else(|| fail(invalid("its name cannot be put on a list")))?;
        Ok((Self::open(folder)?, name.to_owned()))
    }

    /// Whether another process writes into a folder.
    pub(crate) fn is_busy(path: &Path) -> bool {
        let list = File::options().append(true).open(path.join(LIST));
        list.is_ok_and(|list| matches!(list.try_lock(), Err(TryLockError::WouldBlock)))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The names on the list.
    pub(crate) fn listed(&self) -> Vec<String> {
        self.list().hashes.keys().cloned().collect()
    }

    /// Whether a file is there as it was written.
    pub(crate) fn holds(&self, name: &str) -> bool {
        matches!(self.entry(name), Ok(Some(sha256)) if self.list().has(name, &sha256))
    }

    /// Refuses a name under which something lies that must not be replaced.
    pub(crate) fn check(&self, name: &str) -> Result<(), FileError> {
        self.refuse(self.kept(name).into_iter().collect())
    }

    /// Refuses a folder with files in the way of what may be written, before there is anything to write.
    pub(crate) fn check_all(&self, may_be_written: impl Fn(&str) -> bool) -> Result<(), FileError> {
        let fail = |source| FileError::Folder(self.path.clone(), source);
        let found = |name: &str| self.path.join(name).symlink_metadata().ok();
        let listed = self.listed();
        // What was changed further below would be found out when all else is measured.
        let mut names: Vec<String> = listed.iter().filter(|name| name.contains('/')).cloned().collect();
        for entry in fs::read_dir(&self.path).map_err(fail)? {
            let name = entry.map_err(fail)?.file_name().to_string_lossy().into_owned();
            // On a disk that ignores case another spelling names the same file.
            let lower = name.to_lowercase();
            let may = may_be_written(&name) || may_be_written(&lower) && found(&lower).is_some();
            let is_dir = found(&name).is_some_and(|found| found.is_dir());
            if may && !(is_dir && listed.iter().any(|one| one.starts_with(&format!("{name}/")))) {
                names.push(name);
            }
        }
        names.sort();
        self.refuse(names.iter().filter_map(|name| self.kept(name)).collect())
    }

    /// Writes a file, and gives its path: [`OutputFolder::write_all`] of one.
    pub(crate) fn write(&self, name: &str, contents: &[u8]) -> Result<PathBuf, FileError> {
        self.write_all([(name, contents)])?;
        Ok(self.path.join(name))
    }

    /// Writes files, whole or not at all, and gives their paths. What is there and identical stays. What must not be replaced stays too;
    /// all others are written before it is refused.
    pub(crate) fn write_all<'c>(
        &self,
        files: impl IntoIterator<Item = (&'c str, &'c [u8])>,
    ) -> Result<Vec<PathBuf>, FileError> {
        let _writing = writing();
        let (mut paths, mut lines, mut open, mut in_the_way) = (Vec::new(), String::new(), Vec::new(), Vec::new());
        for (name, contents) in files {
            let (path, sha256) = (self.path.join(name), sha256_of(contents));
            let entry = self.entry(name);
            let is_there = entry.as_ref().is_ok_and(|there| there.as_ref() == Some(&sha256));
            let kept = self.list().why_kept(name, &entry);
            match kept {
                Some(kept) if !is_there => in_the_way.push(kept),
                _ => {
                    lines += &self.list().add(name, &sha256);
                    open.extend((!is_there).then_some((name, contents, sha256, entry == Ok(None))));
                    paths.push(path);
                }
            }
        }
        // Before the files that it names.
        let listed = self.list().file.write_all(lines.as_bytes());
        listed.map_err(|source| FileError::Write(self.path.join(LIST), source))?;
        for (name, contents, sha256, is_new) in open {
            let path = self.path.join(name);
            self.put(&path, contents, is_new).map_err(|source| FileError::Write(path, source))?;
            self.list().hashes.insert(name.to_owned(), vec![sha256]);
        }
        self.refuse(in_the_way)?;
        Ok(paths)
    }

    /// Removes a file that was written, and its folder below this one once that is empty. What is no longer as it was written stays.
    pub(crate) fn remove(&self, name: &str) {
        let path = self.path.join(name);
        if self.holds(name) && fs::remove_file(&path).is_ok() && name.contains('/') {
            // One that is not empty stays.
            let _ = path.parent().map(fs::remove_dir);
        }
    }

    /// Removes a folder with all that its list names, and the folders in it that have lists, too.
    ///
    /// # Errors
    /// If anything else is there, which stays, or another process writes there.
    pub fn remove_all(path: &Path) -> Result<(), FileError> {
        let fail = |source| FileError::Folder(path.to_owned(), source);
        let has_list = |path: &Path| path.join(LIST).symlink_metadata().is_ok();
        if has_list(path) {
            let folder = Self::open(path)?;
            folder.listed().iter().for_each(|name| folder.remove(name));
        }
        let mut others = Vec::new();
        for entry in fs::read_dir(path).map_err(fail)? {
            let below = entry.map_err(fail)?.path();
            match has_list(&below) && !below.is_symlink() {
                true => Self::remove_all(&below)?,
                false => others.push(below.file_name().unwrap_or_default().to_string_lossy().into_owned()),
            }
        }
        match others.is_empty() {
            true => fs::remove_dir(path).map_err(fail),
            false => Err(FileError::InTheWay(path.to_owned(), others)),
        }
    }

    /// Where nothing was written nothing is left; a folder that is not empty stays, whatever happens here.
    pub(crate) fn abandon(&self) {
        let _ = self.tidy();
        remove_empty(&self.made);
    }

    fn list(&self) -> MutexGuard<'_, List> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn refuse(&self, names: Vec<String>) -> Result<(), FileError> {
        match names.is_empty() {
            true => Ok(()),
            false => Err(FileError::InTheWay(self.path.clone(), names)),
        }
    }

    /// What is in the way under a name, with the reason; `None` if it may be written.
    fn kept(&self, name: &str) -> Option<String> {
        let entry = self.entry(name);
        self.list().why_kept(name, &entry)
    }

    fn entry(&self, name: &str) -> Entry {
        if !is_below(name) {
            return Err("no name of a file in this folder".to_owned());
        }
        // From the outermost folder to the file.
        let mut steps: Vec<&Path> = Path::new(name).ancestors().filter(|step| !step.as_os_str().is_empty()).collect();
        while let Some(step) = steps.pop() {
            match self.path.join(step).symlink_metadata() {
                Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(error.to_string()),
                Ok(found) if found.is_symlink() => return Err("a link".to_owned()),
                Ok(found) if steps.is_empty() && found.is_file() || !steps.is_empty() && found.is_dir() => {}
                Ok(found) => return Err(if found.is_dir() { "a folder" } else { "no regular file" }.to_owned()),
            }
        }
        fs::read(self.path.join(name)).map(|contents| Some(sha256_of(&contents))).map_err(|error| error.to_string())
    }

    /// Writes beside the place and renames, so that readers see the old contents or the new, never a part.
    fn put(&self, path: &Path, contents: &[u8], is_new: bool) -> io::Result<()> {
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        let mut file = temporary(&self.path)?;
        file.write_all(contents)?;
        // What has come there meanwhile is nobody's to replace.
        let put = if is_new { file.persist_noclobber(path) } else { file.persist(path) };
        put.map(drop).map_err(|error| error.error)
    }

    /// Writes the list anew without what is gone and without hashes that were replaced; a list of nothing is removed.
    fn tidy(&self) -> io::Result<()> {
        let (mut list, path) = (self.list(), self.path.join(LIST));
        if !is_at(&list.file, &path) {
            return Ok(());
        }
        list.hashes.retain(|name, _| self.path.join(name).symlink_metadata().is_ok());
        if list.hashes.is_empty() {
            return fs::remove_file(path);
        }
        let lines = list.hashes.iter().flat_map(|(name, hashes)| hashes.iter().map(move |sha256| line(sha256, name)));
        let text = HEADER.to_owned() + &lines.collect::<String>();
        let mut file = temporary(&self.path)?;
        file.write_all(text.as_bytes())?;
        let _ = file.as_file().try_lock();
        list.file = file.persist(&path)?;
        Ok(())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        let _writing = writing();
        // A list that says too much is no error.
        let _ = self.tidy();
    }
}

#[derive(Debug)]
struct List {
    /// Locked, and written at its end alone.
    file: File,
    /// By name. A process may end between an entry and its file, so that an earlier hash is right, too.
    hashes: BTreeMap<String, Vec<String>>,
}

impl List {
    /// Opens and locks the list of a folder, and begins it if there is none.
    fn open(folder: &Path) -> Result<Self, FileError> {
        let path = folder.join(LIST);
        let fail = |source| FileError::NoList(path.clone(), source);
        let begun = Instant::now();
        loop {
            let opened = match path.symlink_metadata() {
                Ok(found) if found.is_file() => File::options().read(true).append(true).open(&path),
                Ok(_) => Err(invalid("it is no regular file")),
                Err(error) if error.kind() == ErrorKind::NotFound => temporary(folder).and_then(|mut list| {
                    list.write_all(HEADER.as_bytes())?;
                    list.persist_noclobber(&path).map_err(|error| error.error)
                }),
                Err(error) => Err(error),
            };
            let is_patient = begun.elapsed() < PATIENCE;
            match opened {
                // Made or removed by another process just now.
                Err(error) if is_patient && [ErrorKind::NotFound, ErrorKind::AlreadyExists].contains(&error.kind()) => {
                }
                Err(error) => return Err(fail(error)),
                Ok(file) => match file.try_lock() {
                    Err(TryLockError::WouldBlock) if is_patient => {}
                    Err(TryLockError::WouldBlock) => return Err(FileError::Busy(folder.to_owned())),
                    // Replaced by another process just now.
                    _ if is_patient && !is_at(&file, &path) => {}
                    // A file system without locks keeps nobody out.
                    _ => return Self::read(file).map_err(fail),
                },
            }
            sleep(BETWEEN_TRIES);
        }
    }

    fn read(mut file: File) -> io::Result<Self> {
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(0))?;
        file.read_to_end(&mut bytes)?;
        // A process may have ended within its last line.
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let text = std::str::from_utf8(&bytes[..whole]).ok().and_then(|text| text.strip_prefix(HEADER));
        let mut hashes: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for line in text.ok_or_else(|| invalid("it does not begin like one"))?.lines() {
            let is_hash = |text: &str| text.len() == 64 && text.bytes().all(|c| c.is_ascii_hexdigit());
            let parts = line.split_once("  ").filter(|(sha256, name)| is_hash(sha256) && is_below(name));
            let (sha256, name) = parts
                .ok_or_else(|| invalid(&format!("its line '{}' names no file in this folder", line.escape_debug())))?;
            hashes.entry(name.to_owned()).or_default().push(sha256.to_owned());
        }
        if whole < bytes.len() {
            file.set_len(whole as u64)?;
            file.seek(SeekFrom::End(0))?;
        }
        Ok(Self { file, hashes })
    }

    fn has(&self, name: &str, sha256: &str) -> bool {
        self.hashes.get(name).is_some_and(|hashes| hashes.iter().any(|one| one == sha256))
    }

    /// Adds a hash, and gives the line to be written; an empty text if it is there.
    fn add(&mut self, name: &str, sha256: &str) -> String {
        if self.has(name, sha256) {
            return String::new();
        }
        self.hashes.entry(name.to_owned()).or_default().push(sha256.to_owned());
        line(sha256, name)
    }

    /// Why what lies under a name must stay as it is; `None` if it may be replaced.
    fn why_kept(&self, name: &str, entry: &Entry) -> Option<String> {
        let why = match entry {
            Ok(None) => return None,
            Ok(Some(sha256)) if self.has(name, sha256) => return None,
            Ok(Some(_)) if self.hashes.contains_key(name) => "changed since it was written",
            Ok(Some(_)) => "not on the list of this folder",
            Err(why) => why,
        };
        Some(format!("{name} ({why})"))
    }
}

/// A line of a list.
fn line(sha256: &str, name: &str) -> String {
    format!("{sha256}  {name}\n")
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, what)
}

/// Whether a name leads to a file below the folder, whatever lies there.
fn is_below(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let is_plain = parts.all(|part| matches!(part, Component::Normal(_)));
    is_plain && !name.is_empty() && !name.contains(|c: char| c == '\\' || c.is_control())
}

/// Whether a path leads to an open file, and to no other that has taken its place.
fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let id = |found: io::Result<fs::Metadata>| found.ok().map(|found| (found.dev(), found.ino()));
        id(file.metadata()).is_some_and(|own| Some(own) == id(path.symlink_metadata()))
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

/// Removes folders while they are empty, the innermost first.
fn remove_empty(folders: &[PathBuf]) {
    for path in folders {
        if fs::remove_dir(path).is_err() {
            break;
        }
    }
}
