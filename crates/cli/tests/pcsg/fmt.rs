//! `pcsg fmt`.

use std::fs;

use crate::run_in;

#[test]
fn files_are_printed_checked_and_rewritten_in_the_standard_layout() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.pcsg");
    fs::write(&file, "{n=1;}A // axiom\nA->sphere|move(n,0,0)cube").unwrap();
    let (code, printed, _, _) = run_in(folder.path(), &["fmt", "a.pcsg"]);
    assert_eq!(code, 0);
    assert!(
        printed.contains("A -> sphere | move(n, 0, 0) cube") && printed.contains("// axiom"),
        "{printed}"
    );
    assert_eq!(run_in(folder.path(), &["fmt", "--check", "a.pcsg"]).0, 1);
    assert_eq!(run_in(folder.path(), &["fmt", "--write", "a.pcsg"]).0, 0);
    assert_eq!(fs::read_to_string(&file).unwrap(), printed);
    let (code, out, err, files) = run_in(folder.path(), &["fmt", "--check", "a.pcsg"]);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "", ""));
    assert_eq!(files, ["a.pcsg"]);
}
