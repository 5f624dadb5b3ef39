//! The figures of the documents are what their commands draw.

#[test]
fn the_figures_are_up_to_date() {
    if let Err(error) = xtask::figures::figures(&xtask::repository(), true) {
        panic!("{error}");
    }
}
