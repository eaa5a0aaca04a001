//! What is written, replaced, refused and put back.

use super::marker::{Coming, INCOMPLETE, INCOMPLETE_TEXT, MARKER, Marker, listed};
use super::{Outputs, note_input, refuse_incomplete, write_whole};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

type Files = BTreeMap<String, Vec<u8>>;

fn of(files: &[(&str, &str)]) -> Files {
    files.iter().map(|(n, t)| ((*n).to_owned(), t.as_bytes().to_vec())).collect()
}

fn write(target: &Path, files: &[(&str, &str)]) -> Result<(), String> {
    write_as(Outputs::default(), target, files)
}

fn write_as(mut outputs: Outputs, target: &Path, files: &[(&str, &str)]) -> Result<(), String> {
    outputs.folder(target, of(files)).and_then(|()| outputs.write()).map_err(|e| e.to_string())
}

/// All names below a folder, but for the list.
fn names(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        for entry in at.read_dir().unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() && !path.is_symlink() {
                open.push(path);
            } else if name != MARKER {
                names.push(name);
            }
        }
    }
    names.sort();
    names
}

#[test]
fn only_files_of_ours_go() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("deep/out");
    write(&out, &[("a.csv", "1"), ("paths/1.csv", "1"), ("figures/x.png", "1")]).unwrap();
    let first = fs::read(out.join(MARKER)).unwrap();
    fs::write(out.join("notes.txt"), "mine").unwrap();
    fs::write(out.join("paths/mine.csv"), "mine").unwrap();
    write(&out, &[("a.csv", "2"), ("new/b.csv", "2")]).unwrap();
    assert_eq!(names(&out), ["a.csv", "new/b.csv", "notes.txt", "paths/mine.csv"]);
    // The empty folder went, the one with a file of the user stays.
    assert!(!out.join("figures").exists() && out.join("paths").exists());
    assert_eq!(fs::read(out.join("a.csv")).unwrap(), b"2");
    // The same files give the same list, whatever lies beside them.
    write(&out, &[("a.csv", "1"), ("paths/1.csv", "1"), ("figures/x.png", "1")]).unwrap();
    assert_eq!(fs::read(out.join(MARKER)).unwrap(), first);
    assert_eq!(room.path().join("deep").read_dir().unwrap().count(), 1, "debris");
}

#[test]
fn files_are_added_beside_those_of_before() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    write(&out, &[("result.json", "r"), ("page.html", "old")]).unwrap();
    let mut outputs = Outputs::default();
    outputs.add_to_folder(&out, of(&[("page.html", "new"), ("more.csv", "x")])).unwrap();
    outputs.write().unwrap();
    assert_eq!(names(&out), ["more.csv", "page.html", "result.json"]);
    write(&out, &[("result.json", "s")]).unwrap();
    assert_eq!(names(&out), ["result.json"]);
}

#[test]
fn what_a_user_has_put_there_is_never_lost() {
    let room = tempfile::tempdir().unwrap();
    let theirs = room.path().join("theirs");
    fs::create_dir_all(theirs.join(".git")).unwrap();
    fs::write(theirs.join("summary.json"), "{}").unwrap();
    for overwrite in [false, true] {
        let error = write_as(Outputs::new(overwrite), &theirs, &[("summary.json", "x")]);
        assert!(error.unwrap_err().contains("not an ergopath output folder"));
    }
    assert_eq!(fs::read(theirs.join("summary.json")).unwrap(), b"{}");

    let out = room.path().join("out");
    let files = [("a.csv", "1"), ("paths/1.csv", "1")];
    // A file of ours that was edited: refused whether it would be replaced or taken away.
    for kept in [&files[..], &files[1..]] {
        write(&out, &files).unwrap();
        fs::write(out.join("a.csv"), "edited").unwrap();
        assert!(write(&out, kept).unwrap_err().contains("`a.csv` in it was changed"));
        assert_eq!(fs::read(out.join("a.csv")).unwrap(), b"edited");
        write_as(Outputs::new(true), &out, kept).unwrap();
        assert_eq!(out.join("a.csv").exists(), kept.len() == 2);
        fs::remove_dir_all(&out).unwrap();
    }
    // A file of theirs where one of ours would come.
    write(&out, &files).unwrap();
    fs::write(out.join("b.csv"), "mine").unwrap();
    assert!(write(&out, &[("b.csv", "x")]).unwrap_err().contains("did not write"));
    // The notice of an interrupted run is not taken for ours either.
    fs::remove_file(out.join("b.csv")).unwrap();
    fs::write(out.join(INCOMPLETE), "to do").unwrap();
    assert!(write(&out, &files).unwrap_err().contains(INCOMPLETE));
    assert_eq!(names(&out), [INCOMPLETE, "a.csv", "paths/1.csv"]);
}

#[cfg(unix)]
#[test]
fn links_and_folders_in_place_of_files_stay() {
    use std::os::unix::fs::symlink;
    let room = tempfile::tempdir().unwrap();
    let (out, far) = (room.path().join("out"), room.path().join("far"));
    let files = [("a.csv", "1"), ("paths/1.csv", "1")];
    write(&out, &files).unwrap();
    fs::rename(out.join("paths"), &far).unwrap();
    symlink(&far, out.join("paths")).unwrap();
    // A folder that became a link is not followed: neither to write nor to remove.
    assert!(write(&out, &files).unwrap_err().contains("`paths`"));
    write(&out, &files[..1]).unwrap();
    assert_eq!(fs::read(far.join("1.csv")).unwrap(), b"1");
    fs::remove_file(out.join("a.csv")).unwrap();
    symlink(far.join("1.csv"), out.join("a.csv")).unwrap();
    assert!(write(&out, &files[..1]).unwrap_err().contains("`a.csv`"));
    fs::remove_file(out.join("a.csv")).unwrap();
    fs::create_dir(out.join("a.csv")).unwrap();
    assert!(write(&out, &files[..1]).unwrap_err().contains("`a.csv`"));
    assert_eq!(fs::read(far.join("1.csv")).unwrap(), b"1");

    // The output folder itself may be a link, also one to a place that is not there yet.
    let (real, link) = (room.path().join("real"), room.path().join("link"));
    symlink(&real, &link).unwrap();
    for text in ["1", "2"] {
        write(&link, &[("a.csv", text)]).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(real.join("a.csv")).unwrap(), text.as_bytes());
    }
}

#[test]
fn a_run_that_was_killed_between_is_told_and_mended() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    let (old, new) =
        (of(&[("a", "old"), ("b", "old"), ("c", "old")]), of(&[("a", "new"), ("d", "new")]));
    write(&out, &[("a", "old"), ("b", "old"), ("c", "old")]).unwrap();
    // As it stands after a kill: one file of each run, copies in the working folder.
    let mut marker = Marker::new(listed(&old));
    marker.coming = Some(Coming { staging: ".ergopath-x1".to_owned(), files: listed(&new) });
    fs::write(out.join(MARKER), marker.bytes().unwrap()).unwrap();
    fs::write(out.join(INCOMPLETE), INCOMPLETE_TEXT).unwrap();
    fs::create_dir(out.join(".ergopath-x1")).unwrap();
    fs::write(out.join(".ergopath-x1/d"), "new").unwrap();
    fs::write(out.join("a"), "new").unwrap();
    fs::remove_file(out.join("b")).unwrap();
    assert!(refuse_incomplete(&out).unwrap_err().to_string().contains("incomplete"));
    write(&out, &[("a", "newest")]).unwrap();
    assert_eq!(names(&out), ["a"]);
    refuse_incomplete(&out).unwrap();
}

#[test]
fn all_or_nothing_over_folders_and_files() {
    let room = tempfile::tempdir().unwrap();
    let (out, file) = (room.path().join("out"), room.path().join("new/time.csv"));
    write(&out, &[("a", "old"), ("b", "old")]).unwrap();
    let before = fs::read(out.join(MARKER)).unwrap();
    // A file whose place becomes a folder after the checks: the last step fails.
    let blocked = room.path().join("blocked");
    let mut outputs = Outputs::default();
    outputs.folder(&out, of(&[("a", "new"), ("c/d", "new")])).unwrap();
    outputs.folder(&room.path().join("fresh/er"), of(&[("x", "new")])).unwrap();
    outputs.file(&file, "x").unwrap();
    outputs.file(&room.path().join("fresh/er/deep/beside"), "x").unwrap();
    outputs.file(&blocked, "x").unwrap();
    fs::create_dir_all(blocked.join("by")).unwrap();
    outputs.write().unwrap_err();
    assert_eq!(names(&out), ["a", "b"]);
    assert_eq!(fs::read(out.join("a")).unwrap(), b"old");
    assert_eq!(fs::read(out.join(MARKER)).unwrap(), before);
    assert_eq!(names(room.path()), ["out/.ergopath-output.json", "out/a", "out/b"]);
    let left: Vec<_> = room.path().read_dir().unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn a_file_is_replaced_only_by_its_kind() {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("f");
    let put = |overwrite: bool, bytes: &str| {
        let mut outputs = Outputs::new(overwrite);
        outputs.file(&file, bytes).and_then(|()| outputs.write()).map_err(|e| e.to_string())
    };
    let model = |n: u32| format!("{{\"schema\":\"ergopath/posture-model/{n}\"}}");
    put(false, &model(1)).unwrap();
    put(false, &model(2)).unwrap();
    assert!(put(false, "q0,q1\n").unwrap_err().contains("does not look like"));
    assert_eq!(fs::read_to_string(&file).unwrap(), model(2));
    put(true, "q0,q1\n").unwrap();
    // The same bytes again are no change; a table of somebody is not replaced by another.
    put(false, "q0,q1\n").unwrap();
    put(false, "q0,q1\n1,2\n").unwrap_err();
    // An input stays, also on demand and under another name.
    note_input(&file);
    assert!(put(true, "x").unwrap_err().contains("input"));
    #[cfg(unix)]
    {
        let twin = room.path().join("twin");
        fs::hard_link(&file, &twin).unwrap();
        let mut outputs = Outputs::new(true);
        outputs.file(&twin, "x").unwrap();
        assert!(outputs.write().unwrap_err().to_string().contains("input"));
    }
    let mut outputs = Outputs::new(true);
    outputs.state(&file, "x").unwrap();
    outputs.write().unwrap();
}

#[test]
fn an_input_in_a_folder_of_ours_stays() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    write(&out, &[("a", "1"), ("b", "1")]).unwrap();
    note_input(&out.join("b"));
    for files in [&[("a", "2"), ("b", "2")][..], &[("a", "2")]] {
        let error = write_as(Outputs::new(true), &out, files).unwrap_err();
        assert!(error.contains("`b` in it is an input"), "{error}");
    }
    assert_eq!(fs::read(out.join("a")).unwrap(), b"1");
}

#[test]
fn a_file_may_lie_in_a_folder_of_the_same_call() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    for text in ["1", "2"] {
        let mut outputs = Outputs::default();
        outputs.folder(&out, of(&[("x", text)])).unwrap();
        outputs.file(&out.join("sub/time.csv"), format!("stage,seconds\nplan,{text}\n")).unwrap();
        outputs.write().unwrap();
        assert_eq!(names(&out), ["sub/time.csv", "x"]);
    }
}

#[test]
fn two_outputs_do_not_meet() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    for (first, second) in [("a", "a"), ("out/x", "out/../out/x"), ("out", "out")] {
        let mut outputs = Outputs::default();
        outputs.folder(&out, of(&[("x", "1")])).unwrap();
        outputs.file(&room.path().join(first), "1").unwrap();
        outputs.file(&room.path().join(second), "2").unwrap();
        assert!(outputs.write().unwrap_err().to_string().contains("written twice"), "{first}");
    }
    assert_eq!(room.path().read_dir().unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_stay_devices() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let room = tempfile::tempdir().unwrap();
    let at = |name: &str| room.path().join(name);
    fs::create_dir(at("far")).unwrap();
    symlink("far/file", at("link")).unwrap();
    for text in ["1", "2"] {
        write_whole(&at("link"), text.as_bytes()).unwrap();
        assert!(at("link").is_symlink());
        assert_eq!(fs::read_to_string(at("far/file")).unwrap(), text);
        fs::set_permissions(at("far/file"), fs::Permissions::from_mode(0o600)).unwrap();
    }
    // Permissions are kept.
    assert_eq!(at("far/file").metadata().unwrap().permissions().mode() & 0o777, 0o600);
    symlink("circle", at("circle")).unwrap();
    write_whole(&at("circle"), b"x").unwrap_err();
    let mut outputs = Outputs::default();
    outputs.file(Path::new("/dev/null"), "x").unwrap();
    outputs.write().unwrap();
    assert!(Path::new("/dev/null").metadata().unwrap().file_type().is_char_device());
    if Path::new("/dev/full").exists() {
        let mut outputs = Outputs::default();
        outputs.folder(&at("out"), of(&[("x", "1")])).unwrap();
        outputs.file(Path::new("/dev/full"), "x").unwrap();
        let error = outputs.write().unwrap_err();
        assert!(error.is_fault(), "{error}");
        assert!(!at("out").exists());
    }
}

#[test]
fn runs_at_once_leave_one_of_them_whole() {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    std::thread::scope(|scope| {
        for run in 0..8 {
            let out = &out;
            scope.spawn(move || {
                let text = run.to_string();
                write(out, &[("a", &text), ("b", &text), (&format!("only/{run}"), &text)]).unwrap();
            });
        }
    });
    let text = fs::read_to_string(out.join("a")).unwrap();
    assert_eq!(text, fs::read_to_string(out.join("b")).unwrap());
    assert_eq!(names(&out), ["a".to_owned(), "b".to_owned(), format!("only/{text}")]);
    assert_eq!(room.path().read_dir().unwrap().count(), 1);
}
