//! The page of pictures: its commands are sound, its pictures are there and small, and no scene is forgotten.
//!
//! That they are what the commands make is not tested: some take minutes. Small pictures of the same scenes are among the
//! golden images.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use xtask::{gallery, repository};

/// The folders of scenes that are made to be looked at.
const FOLDERS: [&str; 4] = ["scenes", "scenes/endless", "scenes/nature", "scenes/vast"];
/// The largest picture, in bytes.
const MOST_BYTES: u64 = 384 * 1024;
/// The most that all pictures may take.
const MOST_OF_ALL: u64 = 3 * 1024 * 1024;

fn files(folder: &Path) -> BTreeSet<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder exists");
    entries.map(|entry| entry.expect("it can be read").path()).filter(|path| path.is_file()).collect()
}

#[test]
fn every_command_makes_a_picture_that_the_page_shows() {
    let root = repository();
    let page = fs::read_to_string(root.join("docs/gallery.md")).unwrap();
    let exhibits = gallery::exhibits(&root).unwrap_or_else(|error| panic!("{error}"));
    for exhibit in &exhibits {
        assert!(exhibit.render.scene.scene.is_file(), "{exhibit:?}");
        let link = format!("](figures/gallery/{}.png)", exhibit.name);
        assert!(page.contains(&link), "the page does not show {}", exhibit.name);
        assert_eq!(exhibit.picture.parent(), Some(&*root.join("docs/figures/gallery")));
    }
    let shown: BTreeSet<PathBuf> = exhibits.into_iter().map(|exhibit| exhibit.picture).collect();
    assert_eq!(shown, files(&root.join("docs/figures/gallery")));
    let sizes: Vec<u64> = shown.iter().map(|path| fs::metadata(path).unwrap().len()).collect();
    for (path, bytes) in shown.iter().zip(&sizes) {
        assert!(*bytes <= MOST_BYTES, "{} has {bytes} bytes", path.display());
    }
    assert!(sizes.iter().sum::<u64>() <= MOST_OF_ALL, "{sizes:?}");
}

#[test]
fn every_scene_to_be_looked_at_is_on_the_page() {
    let root = repository();
    let exhibits = gallery::exhibits(&root).unwrap_or_else(|error| panic!("{error}"));
    let shown: BTreeSet<PathBuf> = exhibits.into_iter().map(|exhibit| exhibit.render.scene.scene).collect();
    let all: BTreeSet<PathBuf> = FOLDERS.iter().flat_map(|folder| files(&root.join(folder))).collect();
    assert_eq!(shown, all);
}

#[test]
fn a_name_that_is_no_picture_is_an_error() {
    let error = gallery::gallery(&repository(), &["firr".to_owned()]).unwrap_err();
    assert!(error.to_string().contains("no picture `firr`"), "{error}");
}
