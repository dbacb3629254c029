#![allow(clippy::unwrap_used)]
use std::os::unix::fs::symlink;

use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_and_nothing_else_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    for bytes in [b"one".as_slice(), b"other"] {
        write(&path, bytes).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn a_draft_has_the_targets_ending_and_leaves_nothing_when_it_is_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    let mut draft = Draft::of(&path).unwrap();
    assert_eq!(draft.path().extension(), path.extension());
    draft.file().write_all(b"half").unwrap();
    drop(draft);
    assert_eq!(names(folder.path()), ["a.png"]);
    assert_eq!(fs::read(&path).unwrap(), b"old");
}

#[test]
fn what_a_library_wrote_by_name_is_put_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    let draft = Draft::of(&path).unwrap();
    fs::write(draft.path(), "by name").unwrap();
    draft.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"by name");
}

#[test]
fn links_stay_links_and_permissions_stay() {
    let folder = tempfile::tempdir().unwrap();
    let (path, link) = (folder.path().join("a"), folder.path().join("link"));
    fs::write(&path, "old").unwrap();
    fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
    symlink(&path, &link).unwrap();
    write(&link, b"new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&path).unwrap(), b"new");
    let mode = fs::metadata(&path).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    // A new file is not for this user alone, unless the umask says so.
    write(&folder.path().join("b"), b"new").unwrap();
    fs::write(folder.path().join("c"), "new").unwrap();
    let mode = |name| {
        fs::metadata(folder.path().join(name))
            .unwrap()
            .permissions()
            .mode()
    };
    assert_eq!(mode("b"), mode("c"));
}

#[test]
fn what_the_system_refuses_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    write(&taken, b"").unwrap_err();
    write(&folder.path().join("missing/a"), b"").unwrap_err();
    assert_eq!(names(folder.path()), ["taken"]);
    assert!(names(&taken).is_empty());
}
