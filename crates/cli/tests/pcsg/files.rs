//! What any command does to files, and what it does not do to them.

use std::fs;

use crate::{path, run_in, scene};

#[test]
fn a_failed_render_leaves_the_old_picture_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("old.png"), "old").unwrap();
    fs::write(folder.path().join("bad.pcsg"), "{} spere").unwrap();
    let (code, out, err, files) = run_in(folder.path(), &["render", "bad.pcsg", "-o", "old.png"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(err.contains("sphere") && err.contains("bad.pcsg:1:4"), "{err}");
    assert_eq!(files, ["bad.pcsg", "old.png"]);
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"old");
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let tower = scene("cone_tower.pcsg");
    for (output, reason) in
        [("no/such/folder.png", "there is no folder no/such"), ("taken.png", "it is a folder")]
    {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("taken.png")).unwrap();
        let (code, _, err, files) = run_in(folder.path(), &["render", path(&tower), "-o", output]);
        assert_eq!(code, 1);
        assert_eq!(err, format!("error: {output}: cannot write it: {reason}\n"));
        assert_eq!(files, ["taken.png"]);
    }
}

#[test]
fn a_file_that_is_not_there_may_be_meant_with_another_ending() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tree.pcsg"), "{} sphere").unwrap();
    for (name, guess) in
        [("tree", "; did you mean tree.pcsg?"), ("tree.png", "; did you mean tree.pcsg?"), ("bush", "")]
    {
        let (code, _, err, _) = run_in(folder.path(), &["check", name]);
        assert_eq!(
            (code, err),
            (1, format!("error: {name}: cannot read it: there is no such file{guess}\n"))
        );
    }
}

#[test]
fn a_command_does_not_write_over_its_own_files() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.png"), "{} sphere").unwrap();
    for args in [
        &["render", "scene.png"][..],
        &["render", "scene.png", "-o", "a.png", "--stats", "a.png"],
        &["render", "scene.png", "-o", "a.png", "--stats", "./a.png"],
    ] {
        let (code, _, err, files) = run_in(folder.path(), args);
        assert_eq!(code, 1, "{err}");
        assert_eq!(files, ["scene.png"]);
        assert_eq!(fs::read_to_string(folder.path().join("scene.png")).unwrap(), "{} sphere");
    }
}

#[cfg(unix)]
#[test]
fn links_and_permissions_survive() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("real.pcsg");
    fs::write(&file, "{}sphere").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    symlink("real.pcsg", folder.path().join("link.pcsg")).unwrap();
    assert_eq!(run_in(folder.path(), &["fmt", "--write", "link.pcsg"]).0, 0);
    assert_eq!(fs::read_to_string(&file).unwrap(), "{} sphere\n");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(fs::symlink_metadata(folder.path().join("link.pcsg")).unwrap().is_symlink());

    // One that leads to nothing yet, by another one in another folder.
    fs::create_dir(folder.path().join("pictures")).unwrap();
    symlink("pictures/next.png", folder.path().join("latest.png")).unwrap();
    symlink("first.png", folder.path().join("pictures/next.png")).unwrap();
    let render =
        |output: &str| run_in(folder.path(), &["render", "real.pcsg", "--size", "4x4", "-o", output]);
    assert_eq!(render("latest.png").0, 0);
    for link in ["latest.png", "pictures/next.png"] {
        assert!(fs::symlink_metadata(folder.path().join(link)).unwrap().is_symlink(), "{link}");
    }
    assert!(fs::symlink_metadata(folder.path().join("pictures/first.png")).unwrap().is_file());
    symlink("circle.png", folder.path().join("circle.png")).unwrap();
    let (code, _, err, _) = render("circle.png");
    assert!(code == 1 && err.contains("a link that leads back to itself"), "{err}");
    for entry in ["latest.png", "circle.png"] {
        fs::remove_file(folder.path().join(entry)).unwrap();
    }

    let args = ["render", "real.pcsg", "--size", "4x4", "--samples", "1", "--stats", "/dev/stdout"];
    let (code, out, err, _) = run_in(folder.path(), &args);
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.contains("\"rays\": 16"), "{out}");
}
