//! The figures of the documents are what their commands draw.

use xtask::figures::{FigureError, figures};
use xtask::repository;

#[test]
fn the_figures_are_up_to_date() {
    if let Err(error) = figures(&repository(), &[], true) {
        panic!("{error}");
    }
}

/// With no other folder than an empty one, only what is not asked for is not missed.
#[test]
fn only_the_figures_that_are_named_are_looked_at() {
    let empty = tempfile::tempdir().unwrap();
    let check = |name: &str| figures(empty.path(), &[name.to_owned()], true);
    check("memory.svg").unwrap();
    assert!(check("sympodial_growth.svg").is_err());
    assert!(matches!(check("memory"), Err(FigureError::NoSuchFigure(name)) if name == "memory"));
}
