//! `pcsg render -o FILE.exr`: what the layers hold.

use std::fs;

use crate::run_in;

#[test]
fn an_exr_file_has_what_every_pixel_shows_in_layers() {
    use exr::prelude::*;

    let folder = tempfile::tempdir().unwrap();
    let bowl = "{ r = 0.5; } material(ambient = 2, diffuse = 0) (color(1, 0.25, 0.125) cube \\ move(0, 0, 1) uscale(r) ball)\n\
                ball = color(0.0625, 0.25, 0.5) sphere\n\
                camera { eye = (0, 0, 5); target = (0, 0, 0); up = (0, 1, 0); fov = 60; }";
    fs::write(folder.path().join("bowl.pcsg"), bowl).unwrap();
    // The walk tests the boxes of the solid's parts; the fast engine has none to test in a single solid.
    let scene = ["render", "bowl.pcsg", "--set", "r=1/2", "--engine", "reference"];
    let args = [&scene[..], &["--size", "33x21", "--samples", "1", "-o", "a.exr"]].concat();
    let (code, out, err, files) = run_in(folder.path(), &args);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "", ""));
    assert_eq!(files, ["a.exr", "bowl.pcsg"]);
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(folder.path().join("a.exr"))
        .unwrap();

    let names: Vec<String> = image
        .layer_data
        .iter()
        .map(|layer| layer.attributes.layer_name.clone().unwrap().to_string())
        .collect();
    assert_eq!(
        names,
        ["colour", "depth", "normal", "position", "recursion", "node", "state", "samples", "box_tests"]
    );
    for layer in &image.layer_data {
        let software = layer.attributes.software_name.clone().unwrap().to_string();
        assert_eq!(software, concat!("pcsg ", env!("CARGO_PKG_VERSION")));
        assert_eq!(layer.size, Vec2(33, 21));
        let attribute = |name: &str| layer.attributes.other[&Text::from(name)].to_text().unwrap().to_string();
        assert_eq!((attribute("scene"), attribute("parameters")), ("bowl.pcsg".into(), "r=1/2".into()));
    }
    let sample = |layer: &str, channel: &str, x: usize, y: usize| {
        let layer = &image.layer_data[names.iter().position(|name| name == layer).unwrap()];
        let channels = &layer.channel_data.list;
        let channel = channels.iter().find(|found| found.name == *channel).unwrap();
        channel.sample_data.value_by_flat_index(y * 33 + x)
    };
    let triple = |layer: &str, channels: [&str; 3], x, y| {
        channels.map(|channel| sample(layer, channel, x, y).to_f32())
    };

    // In the middle is the bottom of the bowl, beside it the rim, and in the corner nothing.
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close(triple("colour", ["R", "G", "B"], 16, 10), [0.125, 0.5, 1.0]));
    assert!(close(triple("colour", ["R", "G", "B"], 21, 10), [2.0, 0.5, 0.25]), "brighter than a screen");
    assert!(close(triple("normal", ["X", "Y", "Z"], 16, 10), [0.0, 0.0, 1.0]));
    assert!(close(triple("position", ["X", "Y", "Z"], 16, 10), [0.0, 0.0, 0.5]));
    assert!((sample("depth", "Z", 16, 10).to_f32() - 4.5).abs() < 1e-5);
    assert!((sample("depth", "Z", 21, 10).to_f32() - 4.0).abs() < 1e-5);
    assert_eq!(sample("depth", "Z", 0, 0), Sample::F32(f32::INFINITY));
    assert!(close(triple("normal", ["X", "Y", "Z"], 0, 0), [0.0; 3]));
    assert_eq!(sample("recursion", "depth", 16, 10), Sample::U32(0));
    let nodes = [(16, 10), (21, 10), (0, 0)].map(|(x, y)| sample("node", "id", x, y).to_u32());
    assert!(nodes[0] != nodes[1] && nodes[1] < 20 && nodes[2] == u32::MAX, "{nodes:?}");
    assert_eq!(sample("state", "id", 16, 10), Sample::U32(u32::MAX), "there is no symbol");
    assert_eq!(sample("samples", "count", 16, 10), Sample::U32(1));
    assert!(sample("box_tests", "count", 16, 10).to_u32() > 0);
}
