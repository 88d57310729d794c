//! Everything that reads files of others, as functions of bytes. What is read is checked, so that
//! a wrong number is found as well as a panic. The crate in `fuzz/` runs the same for longer.

use std::error::Error;
use std::fs;
use std::path::Path;

use soilsig::beds::own_grains::Grain;
use soilsig::geometry::ingest;
use soilsig::pipeline::record::Record;
use soilsig::products::cube::Cube;
use soilsig::products::export;
use soilsig::products::retrieve::{self, Known, Target};
use soilsig::radiometry::{Assumed, Atmosphere, Method, SkyTable, Temperature};
use soilsig::report::compare::Curve;
use soilsig::spectrum::format::{self, Reading};
use soilsig::spectrum::optics::Crystal;
use soilsig::spectrum::resample::Response;
use soilsig::spectrum::sensors::Sensor;
use soilsig::{Scene, Table, evaluate, merge};

use super::seeds;

type Read = Result<(), Box<dyn Error>>;

/// A format.
pub struct Parser {
    pub name: &'static str,
    /// The files that an input makes; the first is read. [`BETWEEN`] parts them.
    pub files: &'static [&'static str],
    /// Valid inputs.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads the first of the files of a folder.
    read: fn(&Path) -> Read,
}

/// The line that parts the files of an input.
pub const BETWEEN: &[u8] = b"\n=== next file ===\n";

impl Parser {
    /// Reads an input as files in a folder.
    ///
    /// # Errors
    /// The input is refused.
    ///
    /// # Panics
    /// What must not happen: the reader panics, or what it gives is not sound.
    pub fn read(&self, input: &[u8], folder: &Path) -> Read {
        let mut rest = input;
        for (i, name) in self.files.iter().enumerate() {
            let is_last = i + 1 == self.files.len();
            let found = rest.windows(BETWEEN.len()).position(|window| window == BETWEEN);
            let (file, further) = match found {
                Some(at) if !is_last => (&rest[..at], &rest[at + BETWEEN.len()..]),
                _ => (rest, &[][..]),
            };
            fs::write(folder.join(name), file).expect("written");
            rest = further;
        }
        (self.read)(&folder.join(self.files[0]))
    }
}

/// All of them.
pub const PARSERS: &[Parser] = &[
    Parser { name: "scene", files: &["a.json", "a.obj"], seeds: seeds::scenes, read: scene },
    Parser { name: "obj", files: &["a.obj"], seeds: seeds::obj, read: mesh },
    Parser { name: "gltf", files: &["a.gltf", "a.bin"], seeds: seeds::gltf, read: mesh },
    Parser { name: "glb", files: &["a.glb"], seeds: seeds::glb, read: mesh },
    Parser { name: "table", files: &["a.json"], seeds: seeds::tables, read: table },
    Parser { name: "shards", files: &["a.json", "b.json"], seeds: seeds::shards, read: shards },
    Parser { name: "record", files: &["run.json"], seeds: seeds::records, read: record },
    Parser { name: "csv", files: &["a.csv"], seeds: seeds::csv, read: spectra },
    Parser { name: "ecostress", files: &["a.txt"], seeds: seeds::ecostress, read: spectra },
    Parser { name: "usgs", files: &["a.txt", "um.txt"], seeds: seeds::usgs, read: spectra },
    Parser { name: "jcamp", files: &["a.jdx"], seeds: seeds::jcamp, read: spectra },
    Parser { name: "sli", files: &["a.hdr", "a.sli"], seeds: seeds::sli, read: spectra },
    Parser { name: "ems", files: &["a.ems"], seeds: seeds::ems, read: spectra },
    Parser { name: "image", files: &["a.hdr", "a.img"], seeds: seeds::images, read: image },
    Parser { name: "sky", files: &["a.csv"], seeds: seeds::skies, read: sky },
    Parser { name: "atmosphere", files: &["a.csv"], seeds: seeds::atmospheres, read: atmosphere },
    Parser { name: "radiance", files: &["a.csv"], seeds: seeds::radiances, read: radiance },
    Parser { name: "response", files: &["a.csv"], seeds: seeds::responses, read: response },
    Parser { name: "sensor", files: &["a.csv"], seeds: seeds::sensors, read: sensor },
    Parser { name: "signature", files: &["a.csv"], seeds: seeds::signatures, read: signature },
    Parser {
        name: "dirsig",
        files: &["a.odb", "a.mat", "a.ems", "a.obj"],
        seeds: seeds::dirsig,
        read: dirsig,
    },
    Parser { name: "grain", files: &["a.json", "a.obj"], seeds: seeds::grains, read: grain },
    Parser { name: "optics", files: &["a.json"], seeds: seeds::optics, read: optics },
];

/// The scene, its meshes, and the same after it is written.
fn scene(path: &Path) -> Read {
    let scene = Scene::read(path)?;
    let written = serde_json::to_string(&scene)?;
    assert_eq!(Scene::parse(&written, path).expect("it was read before"), scene);
    if scene.placed().is_ok() {
        bed(&scene)?;
    }
    Ok(())
}

fn mesh(path: &Path) -> Read {
    let name = path.file_name().expect("a file").to_string_lossy();
    let prototype = format!(r#"{{"name": "m", "file": "{name}", "unit_um": 1}}"#);
    bed(&Scene::parse(&seeds::scene_of(&prototype), path).expect("a scene"))
}

fn bed(scene: &Scene) -> Read {
    let bed = ingest::load(scene)?;
    for mesh in &bed.meshes {
        assert!(mesh.vertices.iter().all(|vertex| vertex.is_finite()));
        let vertices = mesh.vertices.len();
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < vertices));
        assert!(mesh.materials.iter().all(|&m| usize::from(m) < scene.materials.len()));
    }
    Ok(())
}

fn table(path: &Path) -> Read {
    let table = Table::read(path)?;
    let again = path.with_file_name("again.json");
    table.write(&again)?;
    assert_eq!(Table::read(&again).expect("it was read before"), table);
    evaluated(table)
}

fn evaluated(table: Table) -> Read {
    // A grid may have 100,000 bands.
    let mut um = table.stop.asked.grid.wavelengths_um();
    um.truncate(8);
    for band in evaluate(&[table], &um)? {
        let [mean, half] = [band.emissivity.mean, band.emissivity.half_width];
        assert!(mean.is_finite() && half.is_finite(), "{mean} {half}");
        assert!((-1e-9..=1.0 + 1e-9).contains(&mean), "an emissivity of {mean}");
    }
    Ok(())
}

fn shards(path: &Path) -> Read {
    evaluated(merge(&[path.to_owned(), path.with_file_name("b.json")])?)
}

fn record(path: &Path) -> Read {
    let record = Record::read(path)?;
    let written = serde_json::to_string(&record)?;
    let again = path.with_file_name("again.json");
    fs::write(&again, &written)?;
    let again = Record::read(&again).expect("it was read before");
    assert_eq!(serde_json::to_string(&again)?, written);
    for scene in record.reached.keys() {
        record.cost(scene);
    }
    Ok(())
}

fn spectra(path: &Path) -> Read {
    let um = path.with_file_name("um.txt");
    let reading = Reading { wavelengths: um.exists().then_some(um), ..Reading::default() };
    for spectrum in format::read(path, &reading)? {
        assert_eq!(spectrum.wavelength_um.len(), spectrum.emissivity.len());
        assert!(spectrum.wavelength_um.is_sorted_by(|a, b| a < b));
        assert!(spectrum.wavelength_um.iter().all(|um| um.is_finite() && *um > 0.0));
        assert!(spectrum.emissivity.iter().all(|e| (0.0..=1.0).contains(e)));
    }
    Ok(())
}

fn image(path: &Path) -> Read {
    let cube = Cube::read(path)?;
    assert_eq!(cube.data.len(), cube.lines * cube.samples * cube.wavelengths_um.len());
    let radiance = Cube::read_radiance(path)?;
    assert!(radiance.data.iter().all(|l| l.is_nan() || l.abs() <= 1e9));
    Ok(())
}

fn sky(path: &Path) -> Read {
    let sky = SkyTable::read(path)?;
    assert!(sky.l_sky.iter().flatten().all(|l| l.is_finite() && *l >= 0.0));
    Ok(())
}

fn atmosphere(path: &Path) -> Read {
    let air = Atmosphere::read(path)?;
    assert!(air.transmittance.iter().all(|tau| (0.0..=1.0).contains(tau)));
    Ok(())
}

fn radiance(path: &Path) -> Read {
    let read = |target| {
        let (sky, assumed) = (retrieve::Sky::OfFile, Assumed::EXACT);
        let spectrum =
            retrieve::spectrum(path, None, &Known { sky, atmosphere: None, target, assumed })?;
        assert!(spectrum.temperature.k.is_finite());
        assert!(!spectrum.csv_text().contains("NaN"));
        Ok::<_, Box<dyn Error>>(())
    };
    read(Target::Given(Temperature { k: 300.0, error_k: 0.1 }))?;
    for method in Method::ALL {
        // A method may find no signal.
        let _ = read(Target::By(method));
    }
    Ok(())
}

fn response(path: &Path) -> Read {
    let response = Response::read(path)?;
    assert!(response.width_um() >= 0.0);
    Ok(())
}

fn sensor(path: &Path) -> Read {
    Sensor::read(path)?;
    Ok(())
}

fn signature(path: &Path) -> Read {
    Curve::read(path)?;
    Ok(())
}

fn dirsig(path: &Path) -> Read {
    let folder = path.parent().expect("a folder");
    let (scene, _) = export::import(path, &path.with_extension("mat"), folder)?;
    let written = serde_json::to_string(&scene)?;
    Scene::parse(&written, &folder.join("scene.json")).expect("a valid scene");
    Ok(())
}

fn grain(path: &Path) -> Read {
    let grain = Grain::read(path.parent().expect("a folder"), "a")?;
    assert!(grain.diameter_um.is_finite() && grain.diameter_um > 0.0);
    Ok(())
}

fn optics(path: &Path) -> Read {
    let crystal = Crystal::read(path)?;
    for um in [6.0, 9.0, 12.0] {
        let r = crystal.reflectance(um, 0.5);
        assert!((-1e-9..=1.0 + 1e-9).contains(&r) || r.is_nan(), "a reflectance of {r}");
    }
    Ok(())
}
