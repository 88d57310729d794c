//! Files opened by the readers of others: ENVI images and libraries in SPy, NetCDF in xarray, CSV
//! in pandas.

use std::fs;
use std::path::Path;
use std::process::Command;

use soilsig::products::cube::Cube;

use crate::support::{Place, Tool, shipped, tool};

#[test]
fn others_read_what_we_write_to_the_last_bit() {
    let Some(python) = tool(Tool::Readers) else { return };
    let place = Place::new();
    let scene = &shipped("settled_patch.json");
    let bands = ["--range", "8-12", "--step", "0.5"];
    let to = |args: &[&str]| place.run(args, 0);
    to(&[&["image", scene, "--out", "image", "--noise", "0.1", "--pixels", "6x4"][..], &bands]
        .concat());
    to(&[&["trace", scene, "--out", "table.json", "--tolerance", "0.05"][..], &bands].concat());
    to(&[&["signature", "table.json", "--out", "signature.csv"][..], &bands].concat());
    to(&[&["signature", "table.json", "--out", "signature.nc"][..], &bands].concat());
    // modis 32 lies beyond the spectra.
    place.write("short.csv", "7.4,0.9\n11.5,0.9\n");
    let sensors = ["--sensor", "aster,modis", "--spectrum", "fine=short.csv"];
    for out in ["bands.csv", "bands.nc"] {
        to(&[&["signature", "table.json", "--out", out][..], &sensors].concat());
    }
    to(&[&["spectra", "convert", "quartz_fine", "--out", "library.sli"][..], &bands].concat());
    to(&[&["spectra", "convert", "quartz_fine", "--out", "library.csv"][..], &bands].concat());
    // What we read ourselves, for the others to compare with: band by band, line by line.
    for name in ["radiance", "radiance_standard_error", "emissivity"] {
        let path = place.path(format!("image/{name}.img"));
        let cube = Cube::read(&path).expect("a cube");
        assert_eq!((cube.lines, cube.samples, cube.wavelengths_um.len()), (4, 6, 9));
        let text: Vec<String> = cube.data.iter().map(ToString::to_string).collect();
        fs::write(place.path(format!("{name}.txt")), text.join("\n")).expect("written");
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers/read.py");
    let output =
        Command::new(python).arg(script).current_dir(place.folder()).output().expect("it starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}{errors}", String::from_utf8_lossy(&output.stdout));
}
