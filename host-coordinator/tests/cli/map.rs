//! `chargehand map`: maps of other programs become sites.

use std::{fs, io::Cursor, path::Path};

use super::{chargehand, json, text};

/// A real map of another program.
fn data(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planning/tests/data").join(file);
    text(&path).to_owned()
}

#[test]
fn info_counts_what_a_ros_map_has() {
    let info = json(&["map", "info", &data("ros/tb3_sandbox.yaml")]);
    assert_eq!((&info["free"], &info["unknown"]), (&7903.into(), &138_683.into()));
    assert_eq!((&info["resolution_m"], &info["kind"]), (&0.05.into(), &"ROS map".into()));
}

#[test]
fn a_building_becomes_a_site_that_is_ready_to_run() {
    let folder = tempfile::tempdir().unwrap();
    let site = folder.path().join("hotel");
    let building = data("rmf/hotel.building.yaml");
    let arguments = ["map", "convert", &building, "--level", "L1", "--radius", "0.2", "--to", text(&site)];
    let made = json(&arguments);
    assert_eq!(made["piles"], 4);
    assert!(made["doors"].as_u64().unwrap() >= 5, "{made}");
    chargehand(&["keys", "--site", text(&site)]).succeeds();
    let ready = chargehand(&["check", "--config", text(&site.join("chargehand.toml"))]).succeeds();
    assert!(ready.contains("is ready to run"), "{ready}");
}

#[test]
fn a_ros_map_comes_back_through_a_ros_map() {
    let folder = tempfile::tempdir().unwrap();
    let (yaml, map) = (folder.path().join("copy.YAML"), folder.path().join("copy.map"));
    chargehand(&["map", "convert", &data("ros/depot.yaml"), "--to", text(&yaml)]).succeeds();
    chargehand(&["map", "convert", text(&yaml), "--to", text(&map)]).succeeds();
    for file in [&yaml, &map] {
        assert_eq!(json(&["map", "info", text(file)])["free"], 179_481);
    }
}

#[test]
fn a_picture_is_drawn_and_a_segmentation_written() {
    let folder = tempfile::tempdir().unwrap();
    let render = |file: &str| {
        let picture = folder.path().join(file);
        let arguments = ["map", "render", &data("rmf/office.building.yaml"), "--to", text(&picture)];
        (chargehand(&arguments), picture)
    };
    let (rendered, png) = render("office.png");
    rendered.succeeds();
    let picture = png::Decoder::new(Cursor::new(fs::read(png).unwrap())).read_info().unwrap();
    // 433 x 222 cells of two pixels.
    assert_eq!((picture.info().width, picture.info().height), (866, 444));
    let (rendered, svg) = render("office.SVG");
    rendered.succeeds();
    let svg = fs::read_to_string(svg).unwrap();
    let svg = roxmltree::Document::parse(&svg).unwrap();
    assert_eq!(svg.root_element().attribute("width"), Some("866"));
    // Doors, and piles in their rings.
    assert!(svg.descendants().filter(|node| node.has_tag_name("circle")).count() >= 3 + 2 * 2);
    let error = render("office.jpg").0.fails();
    assert!(error.ends_with("office.jpg is no picture: name a .png or an .svg file\n"), "{error}");
    chargehand(&["map", "segment", &data("rmf/office.building.yaml"), "--to", text(folder.path())])
        .succeeds();
    let doors = fs::read_to_string(folder.path().join("doors.toml")).unwrap();
    assert!(doors.matches("[[door]]").count() >= 3, "{doors}");
    assert_eq!(fs::read_to_string(folder.path().join("subareas.txt")).unwrap().lines().count(), 222);
}

#[test]
fn an_integrator_is_told_what_to_do() {
    let error = chargehand(&["map", "info", &data("rmf/hotel.building.yaml")]).fails();
    assert!(error.contains("has several levels; choose `--level` of `L1`, `L2`, `L3`"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.yaml");
    fs::write(&file, "image: none.png\nresolution: 0.05\norigin: [0, 0, 0]\n").unwrap();
    let error = chargehand(&["map", "info", text(&file)]).fails();
    assert!(error.contains("none.png cannot be read"), "{error}");
    fs::write(&file, "name: nothing\n").unwrap();
    let error = chargehand(&["map", "info", text(&file)]).fails();
    assert!(error.contains("is no map that is known"), "{error}");
}
