//! The golden images, and that the comparison finds what it must.

use image::RgbImage;
use xtask::golden::{Comparison, run};
use xtask::repository;

#[test]
fn every_picture_is_as_accepted() {
    let report = run(&repository(), &repository().join("tests/golden"), &[]).unwrap();
    assert!(report.failures.is_empty(), "{}", report.failures.join("\n"));
    assert!(report.passed >= 8, "only {} golden images", report.passed);
}

fn accepted(name: &str) -> RgbImage {
    let path = repository().join("tests/golden").join(name).with_extension("png");
    image::open(path).expect("the case has an accepted picture").to_rgb8()
}

#[test]
fn a_picture_shifted_by_one_pixel_fails() {
    for name in ["sympodial", "sierpinski", "cone_tower", "puzzle_ball"] {
        let expected = accepted(name);
        let width = expected.width();
        let shifted =
            RgbImage::from_fn(width, expected.height(), |x, y| *expected.get_pixel((x + 1) % width, y));
        let comparison = Comparison::new(&expected, &shifted).unwrap();
        assert!(!comparison.passes(), "{name}: {comparison:?}");
        assert!(Comparison::new(&expected, &expected).unwrap().passes(), "{name}");
    }
}

#[test]
fn a_slight_change_of_colour_fails() {
    let expected = accepted("sympodial");
    let mut tinted = expected.clone();
    tinted.pixels_mut().for_each(|pixel| pixel.0[0] = pixel.0[0].saturating_add(3));
    assert!(!Comparison::new(&expected, &tinted).unwrap().passes());
}

#[test]
fn a_picture_of_another_size_is_not_compared() {
    assert!(Comparison::new(&RgbImage::new(8, 8), &RgbImage::new(8, 9)).is_none());
}

#[test]
fn failures_leave_evidence_and_stray_files_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &[u8]| std::fs::write(folder.path().join(name), content).unwrap();
    let scene = "scenes/sierpinski.pcsg --set n=1 --samples 1 --size";
    write("new.args", format!("{scene} 24x24").as_bytes());
    write("changed.args", format!("{scene} 24x24").as_bytes());
    write("broken.args", b"scenes/no_such_scene.pcsg");
    write("stray.png", b"");
    let black = RgbImage::new(24, 24);
    black.save(folder.path().join("changed.png")).unwrap();

    let report = run(&repository(), folder.path(), &[]).unwrap();
    assert_eq!(report.passed, 0);
    let failures = report.failures.join("\n");
    for expected in
        ["stray.png: belongs to no case", "new: no accepted picture", "changed: similarity", "broken: "]
    {
        assert!(failures.contains(expected), "{failures}");
    }
    let failed = folder.path().join("failed");
    for file in ["new.actual.png", "changed.expected.png", "changed.actual.png", "changed.difference.png"] {
        assert!(failed.join(file).exists(), "{file}");
    }

    std::fs::remove_file(folder.path().join("stray.png")).unwrap();
    std::fs::remove_file(folder.path().join("broken.args")).unwrap();
    let blessed = ["new".to_owned(), "changed".to_owned()];
    let report = run(&repository(), folder.path(), &blessed).unwrap();
    assert_eq!((report.passed, report.blessed.len(), report.failures.len()), (2, 2, 0));
    assert!(!failed.exists(), "evidence of earlier failures is cleared");
    assert!(run(&repository(), folder.path(), &["nobody".to_owned()]).is_err());
}
