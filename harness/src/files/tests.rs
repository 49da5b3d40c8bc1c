//! What a folder of results does with files that are there.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use tempfile::TempDir;

use super::*;
use crate::hash::sha256_of;

fn open(folder: &TempDir) -> OutputFolder {
    OutputFolder::open(folder.path()).unwrap()
}

fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// The line of a list, as `sha256sum` has it.
fn line(name: &str, contents: &str) -> String {
    format!("{}  {name}\n", sha256_of(contents.as_bytes()))
}

fn list_of(folder: &TempDir) -> String {
    fs::read_to_string(folder.path().join(LIST)).unwrap()
}

/// Adds to a list as a process does that is killed before it writes the file.
fn list(folder: &TempDir, text: &str) {
    let mut list = fs::File::options().append(true).open(folder.path().join(LIST)).unwrap();
    list.write_all(text.as_bytes()).unwrap();
}

/// Proves that what was written is replaced and removed; that what the user wrote, or changed, is neither, and is named with the reason
/// while all else is written; that an identical file stays and is on the list from then on; and that the list says what is there.
#[test]
fn only_what_is_listed_and_unchanged_is_touched() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let read = |name: &str| fs::read_to_string(at(name)).unwrap();
    fs::write(at("theirs"), "mine").unwrap();
    fs::write(at("same"), "same").unwrap();
    let results = open(&folder);
    results.write_all([("own", &b"1"[..]), ("interleaved_sets/one", b"1"), ("same", b"same")]).unwrap();
    results.write("own", b"2").unwrap();
    let error = results.write_all([("theirs", &b"x"[..]), ("after", b"x")]).unwrap_err().to_string();
    assert!(error.contains("theirs (not on the list of this folder)") && !error.contains("after"), "{error}");
    assert_eq!((read("theirs"), read("own"), read("after")), ("mine".into(), "2".into(), "x".into()));
    fs::write(at("own"), "changed").unwrap();
    let error = results.write("own", b"3").unwrap_err().to_string();
    assert!(error.contains("own (changed since it was written)"), "{error}");
    for name in ["own", "theirs", "after", "interleaved_sets/one", "absent", "../own"] {
        results.remove(name);
    }
    assert_eq!(names(folder.path()), ["own", "same", "theirs", LIST].map(str::to_owned).into());
    assert_eq!((read("own"), read("theirs")), ("changed".into(), "mine".into()));
    // What an earlier process wrote is there for a later one.
    drop(results);
    assert!(list_of(&folder).ends_with(&line("same", "same")), "{}", list_of(&folder));
    open(&folder).write("same", b"other").unwrap();
    assert_eq!(read("same"), "other");
    let text = list_of(&folder);
    assert!(text.contains(&line("same", "other")) && !text.contains(&line("same", "same")), "{text}");
}

/// Proves that a process may be killed between an entry and its file, where there was none and where there was an older one, and within a
/// line of the list: what it had written is replaced all the same.
#[test]
fn a_list_may_say_more_than_is_there() {
    let folder = TempDir::new().unwrap();
    open(&folder).write("old", b"old").unwrap();
    list(&folder, &(line("old", "new") + &line("absent", "new") + &line("cut", "new")[..70]));
    let results = open(&folder);
    assert!(results.holds("old") && !results.holds("absent"));
    results.write_all([("old", &b"new"[..]), ("absent", b"new")]).unwrap();
    results.write("old", b"newer").unwrap();
    drop(results);
    assert_eq!(list_of(&folder).lines().count(), 3, "{}", list_of(&folder));
    open(&folder).write("old", b"newest").unwrap();
}

/// Proves that links are neither followed nor replaced, whatever they lead to: those of a file, of a folder, and of the list.
#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let (folder, elsewhere) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let there = elsewhere.path().join("one.png");
    fs::write(&there, "mine").unwrap();
    for (target, name) in
        [(there.as_path(), "summary.md"), (elsewhere.path(), "pictures"), (Path::new("gone"), "run.json")]
    {
        symlink(target, folder.path().join(name)).unwrap();
    }
    let results = open(&folder);
    for name in ["summary.md", "pictures/one.png", "pictures/two.png", "run.json"] {
        // Even where a list has it.
        list(&folder, &line(name, "mine"));
        let error = results.write(name, b"x").unwrap_err().to_string();
        assert!(error.contains(&format!("{name} (a link)")), "{error}");
    }
    drop(results);
    let results = open(&folder);
    results.listed().iter().for_each(|name| results.remove(name));
    assert_eq!(names(elsewhere.path()), ["one.png".to_owned()].into());
    assert_eq!(fs::read_to_string(&there).unwrap(), "mine");
    assert!(["summary.md", "pictures", "run.json"].iter().all(|name| folder.path().join(name).is_symlink()));
    let other = TempDir::new().unwrap();
    symlink(elsewhere.path().join("list"), other.path().join(LIST)).unwrap();
    assert!(matches!(OutputFolder::open(other.path()), Err(FileError::NoList(..))));
    assert_eq!(names(elsewhere.path()).len(), 1);
}

/// Proves that a list which leads out of its folder, or is none, is refused and stays as it is; a plain one is none of these.
#[test]
fn strange_lists_are_refused() {
    let folder = TempDir::new().unwrap();
    open(&folder).write("a", b"1").unwrap();
    let sound = list_of(&folder);
    let long = "0".repeat(64);
    for text in [
        String::new(),
        "mine".to_owned(),
        line("a", "1"),
        sound.clone() + "mine\n",
        sound.clone() + &line("../a", "1"),
        sound.clone() + &line("b/../../a", "1"),
        sound.clone() + &line("/etc/passwd", "1"),
        sound.clone() + &line("..\\a", "1"),
        sound.clone() + &line("", "1"),
        sound.clone() + &format!("{}  a\n", &long[1..]),
        sound.clone() + &format!("{}  a\n", long.replace('0', "G")),
    ] {
        fs::write(folder.path().join(LIST), &text).unwrap();
        let error = OutputFolder::open(folder.path()).map(drop).unwrap_err();
        assert!(matches!(error, FileError::NoList(..)), "{text}: {error}");
        assert_eq!(list_of(&folder), text);
    }
    fs::write(folder.path().join(LIST), sound).unwrap();
    open(&folder).write("a", b"2").unwrap();
}

/// Proves that one process alone has a folder, that the next one may have it, and that where nothing was written nothing is left.
#[test]
fn a_folder_has_one_writer() {
    let folder = TempDir::new().unwrap();
    let below = folder.path().join("a/b");
    let first = OutputFolder::open(&below).unwrap();
    assert!(OutputFolder::is_busy(&below));
    assert!(matches!(OutputFolder::open(&below), Err(FileError::Busy(..))));
    first.write("one", b"1").unwrap();
    first.remove("one");
    // The list goes, and is made anew by whoever comes next.
    drop(first);
    assert!(names(&below).is_empty() && !OutputFolder::is_busy(&below));
    OutputFolder::open(&below).unwrap().abandon();
    assert!(below.is_dir(), "a folder that was there is removed");
    OutputFolder::open(&folder.path().join("c/d")).unwrap().abandon();
    assert_eq!(names(folder.path()), ["a".to_owned()].into());
}

/// Proves that files in the way are found before anything is written: by what may be written, in whatever case where the disk ignores it,
/// and those of the list that were changed; those that are as they were, and others, are not.
#[test]
fn files_in_the_way_are_found_before() {
    let folder = TempDir::new().unwrap();
    let results = open(&folder);
    let check =
        || results.check_all(|name| ["run.json", "interleaved_sets"].contains(&name) || name.starts_with("chart_"));
    results.write_all([("run.json", &b"1"[..]), ("interleaved_sets/one", b"1"), ("pictures/one", b"1")]).unwrap();
    for name in ["notes.txt", "interleaved_sets/mine", "pictures/mine"] {
        fs::write(folder.path().join(name), "mine").unwrap();
    }
    check().unwrap();
    for (name, is_in_the_way) in
        [("chart_room.svg", true), ("interleaved_sets/one", true), ("run.json", true), ("other.json", false)]
    {
        let before = fs::read(folder.path().join(name)).ok();
        fs::write(folder.path().join(name), "mine").unwrap();
        let found = check().map_err(|error| error.to_string());
        assert_eq!(found.is_err_and(|error| error.contains(name)), is_in_the_way, "{name}");
        match before {
            Some(before) => fs::write(folder.path().join(name), before).unwrap(),
            None => fs::remove_file(folder.path().join(name)).unwrap(),
        }
    }
    let other = TempDir::new().unwrap();
    fs::create_dir(other.path().join("interleaved_sets")).unwrap();
    assert!(open(&other).check_all(|name| name == "interleaved_sets").is_err(), "a folder of the user's is taken");
    // As where a disk ignores case, both spellings are there.
    let both = TempDir::new().unwrap();
    fs::write(both.path().join("Run.json"), "mine").unwrap();
    let ignores_case = both.path().join("run.json").exists();
    assert_eq!(open(&both).check_all(|name| name == "run.json").is_err(), ignores_case);
}

/// Proves that a folder is removed with the folders of results in it, and that any other file in them keeps itself and its folders.
#[test]
fn folders_are_removed_by_their_lists() {
    let folder = TempDir::new().unwrap();
    let all = folder.path().join("all");
    let make = || {
        for (path, name) in [("all", "report.html"), ("all/step", "run.json"), ("all/step", "pictures/one.png")] {
            OutputFolder::open(&folder.path().join(path)).unwrap().write(name, b"1").unwrap();
        }
    };
    make();
    OutputFolder::remove_all(&all).unwrap();
    assert!(!all.exists());
    for theirs in ["all/mine.txt", "all/step/mine.txt", "all/step/pictures/mine.png", "all/mine/notes.txt"] {
        make();
        let theirs = folder.path().join(theirs);
        fs::create_dir_all(theirs.parent().unwrap()).unwrap();
        fs::write(&theirs, "mine").unwrap();
        let error = OutputFolder::remove_all(&all).unwrap_err();
        assert!(matches!(error, FileError::InTheWay(..)), "{error}");
        assert_eq!(fs::read_to_string(&theirs).unwrap(), "mine");
        fs::remove_dir_all(&all).unwrap();
    }
}

/// Proves that a document is written anew where it is, and that a link is not.
#[test]
fn documents_are_edited_in_place() {
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("page.md");
    fs::write(&page, "1").unwrap();
    edit(&page, b"2").unwrap();
    assert_eq!(fs::read_to_string(&page).unwrap(), "2");
    assert!(edit(&folder.path().join("none.md"), b"2").is_err());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("page.md", folder.path().join("link.md")).unwrap();
        assert!(edit(&folder.path().join("link.md"), b"3").is_err());
        assert_eq!(fs::read_to_string(&page).unwrap(), "2");
    }
    assert_eq!(names(folder.path()).len(), if cfg!(unix) { 2 } else { 1 });
}

/// Proves that every list in results/ has each file beside it as it is, the record too: else it could not be measured over.
#[test]
fn committed_lists_are_true() {
    let below =
        |folder: &Path| -> Vec<_> { fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect() };
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../results")];
    let mut lists = 0;
    while let Some(folder) = folders.pop() {
        let (inner, files): (Vec<_>, Vec<_>) = below(&folder).into_iter().partition(|path| path.is_dir());
        folders.extend(inner);
        let Ok(list) = fs::read_to_string(folder.join(LIST)) else { continue };
        lists += 1;
        for path in files.iter().filter(|path| !path.ends_with(LIST)) {
            let name = path.file_name().unwrap().to_str().unwrap();
            let line = format!("{}  {name}", sha256_of(&fs::read(path).unwrap()));
            assert!(list.lines().any(|one| one == line), "{}", path.display());
        }
    }
    assert!(lists >= 3, "{lists}");
}
