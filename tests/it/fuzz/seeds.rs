//! Valid inputs, small, to begin with.

use std::path::Path;
use std::sync::OnceLock;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use soilsig::pipeline::{self, Options};
use soilsig::support::cache::Cache;
use soilsig::table::{Part, Target};
use soilsig::{Grid, Request, Scene, Unwatched, trace};

use super::parsers::BETWEEN;

type Inputs = Vec<Vec<u8>>;

/// Text inputs, each of one or more files.
fn of(inputs: &[&[&str]]) -> Inputs {
    let bytes = |input: &&[&str]| {
        let files: Vec<&[u8]> = input.iter().map(|file| file.as_bytes()).collect();
        files.join(BETWEEN)
    };
    inputs.iter().map(bytes).collect()
}

/// The scene of a mesh.
pub fn scene_of(prototype: &str) -> String {
    format!(
        r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300,
"view": {{"zenith_deg": 0}},
"materials": [{{"name": "rock", "spectrum": {{"constant": 0.5}}}}],
"geometry": {{"placed": {{"prototypes": [{prototype}]}}}}}}"#
    )
}

pub const PIT: &str = "# pit\no pit\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\n\
                   v 0 1 1\nusemtl rock\nf 1 2 3 4\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

pub fn scenes() -> Inputs {
    let prototype = r#"{"name": "m", "file": "a.obj", "unit_um": 1000, "up": "y"}"#;
    let placed = scene_of(prototype);
    let rich = json!({
        "soilsig_scene": 1, "name": "rich", "seed": 7, "temperature_k": 300.5,
        "sky_temperature_k": [{"zenith_deg": 0, "temperature_k": 220},
                              {"zenith_deg": 90, "temperature_k": 280}],
        "view": {"zenith_deg": 30, "azimuth_deg": 90},
        "sensor": {
            "pixels": [4, 3],
            "optics": {"pinhole": {"distance_um": 5e6, "field_of_view_deg": 2}},
            "bands": [{"box": {"centre_um": 9, "width_um": 0.5}},
                      {"grid": {"from_um": 8, "to_um": 10, "step_um": 1, "fwhm_um": 0.5}}],
            "noise": {"nedt_k": 0.1, "seed": 3},
        },
        "materials": [
            {"name": "rock", "spectrum": {"builtin": "quartz_fine"}, "temperature_k": 290},
            {"name": "b", "specular": 0.2,
             "spectrum": {"mix": [{"share": 0.5, "spectrum": {"constant": 0.9}},
                                  {"share": 0.5, "spectrum": {"builtin": "quartz_coarse"}}]}},
        ],
        "geometry": {"placed": {
            "prototypes": [{"name": "m", "file": "a.obj"}],
            "instances": [
                {"prototype": "m", "transform": [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0]},
                {"prototype": "m", "transform": [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]},
            ],
            "domain": {"min_um": [0, 0], "max_um": [10, 10], "sides": "mirror",
                       "floor": {"z_um": 0, "material": "b"}},
        }}
    });
    of(&[
        &[include_str!("../../../scenes/small.json"), PIT],
        &[include_str!("../../../scenes/sparse.json"), PIT],
        &[include_str!("../../../scenes/quartz_sand.json"), PIT],
        &[&placed, PIT],
        &[&rich.to_string(), PIT],
    ])
}

pub fn obj() -> Inputs {
    let rich = "mtllib a.mtl\no one\ng part\nv 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
                v 0.5 0.5 1\nvt 0 0\nvt 1 1\nvn 0 0 1\nusemtl rock\ns 1\nf 1/1/1 2/2/1 3//1\n\
                f -5 -4 -1\nf 1 2 \\\n 3 4\nl 1 2 3\np 1\no two\nf 1 2 5\nf 2 3 5 # a comment\n";
    of(&[&[PIT], &[rich]])
}

/// The pit as glTF, and the bytes of its buffer.
fn pit() -> (Value, Vec<u8>) {
    let corners: [[f32; 3]; 8] = [
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 0., -1.],
        [0., 0., -1.],
        [0., 1., 0.],
        [1., 1., 0.],
        [1., 1., -1.],
        [0., 1., -1.],
    ];
    let faces: [u16; 30] =
        [0, 1, 2, 0, 2, 3, 0, 4, 5, 0, 5, 1, 1, 5, 6, 1, 6, 2, 2, 6, 7, 2, 7, 3, 3, 7, 4, 3, 4, 0];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(faces.iter().flat_map(|i| i.to_le_bytes()));
    let json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "pit", "children": [1, 2], "scale": [2, 2, 2]},
            {"mesh": 0, "translation": [1, 0, 0], "rotation": [0, 0, 0, 1]},
            {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]},
        ],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0}, "indices": 1, "material": 0, "mode": 4}
        ]}],
        "materials": [{"name": "rock"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8,
             "min": [0, 0, -1], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 30},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 60},
        ],
        "buffers": [{"byteLength": bytes.len()}],
    });
    (json, bytes)
}

pub fn gltf() -> Inputs {
    let (plain, bytes) = pit();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut json = plain.clone();
        json["buffers"][0]["uri"] = "a.bin".into();
        change(&mut json);
        [json.to_string().into_bytes(), bytes.clone()].join(BETWEEN)
    };
    vec![
        with(&|_| {}),
        with(&|json| {
            json["accessors"][0]["sparse"] = json!({
                "count": 2, "indices": {"bufferView": 1, "componentType": 5123},
                "values": {"bufferView": 0},
            });
        }),
        with(&|json| {
            json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
            json["accessors"].as_array_mut().expect("a list").push(json!(
                {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}
            ));
            json["nodes"][1]["extensions"] =
                json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}});
        }),
        with(&|json| {
            let text = STANDARD.encode(&bytes);
            json["buffers"][0]["uri"] =
                format!("data:application/octet-stream;base64,{text}").into();
        }),
        with(&|json| json["meshes"][0]["primitives"][0]["mode"] = 5.into()),
    ]
}

pub fn glb() -> Inputs {
    let (json, mut bytes) = pit();
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + text.len() as u32 + bytes.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bytes)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    vec![file]
}

/// Tables of a pit's trace, whole or in parts.
fn traced(change: &dyn Fn(&mut Value), parts: u64) -> Inputs {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a.obj"), PIT).expect("written");
    let prototype = r#"{"name": "m", "file": "a.obj", "unit_um": 1000}"#;
    let mut scene: Value = serde_json::from_str(&scene_of(prototype)).expect("JSON");
    change(&mut scene);
    std::fs::write(path("a.json"), scene.to_string()).expect("written");
    let grid = Grid::new(8.0, 9.0, 0.5).expect("a grid");
    let table = |part: u64| {
        let of = 256 * parts;
        let exactly = Some(Part { first: 256 * part, end: 256 * (part + 1), of });
        let target = Target { exactly, ..Target::of(0.3) };
        let scene = Scene::read(&path("a.json")).expect("a scene");
        let table = trace(scene, Request::new(&grid, target), &Unwatched).expect("a table");
        table.write(&path("table.json")).expect("written");
        std::fs::read(path("table.json")).expect("read")
    };
    (0..parts).map(table).collect()
}

pub fn tables() -> Inputs {
    let sky = |scene: &mut Value| {
        scene["sky_temperature_k"] = json!([{"zenith_deg": 0, "temperature_k": 220}, {"zenith_deg": 90, "temperature_k": 280}]);
        scene["materials"] = json!([
            {"name": "rock", "spectrum": {"builtin": "quartz_fine"}, "temperature_k": 290},
            {"name": "other", "spectrum": {"constant": 0.9}},
        ]);
    };
    [traced(&|_| {}, 1), traced(&sky, 1)].concat()
}

pub fn shards() -> Inputs {
    vec![traced(&|_| {}, 2).join(BETWEEN)]
}

/// The record of a run.
pub fn records() -> Inputs {
    static RECORD: OnceLock<Vec<u8>> = OnceLock::new();
    let record = || {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let prototype = r#"{"name": "m", "file": "a.obj", "unit_um": 1000}"#;
        std::fs::write(path("a.obj"), PIT).expect("written");
        std::fs::write(path("a.json"), scene_of(prototype)).expect("written");
        let options = json!({
            "source": {"scene": path("a.json")}, "set": ["temperature_k=290"], "seed": 3,
            "packings": 1, "field": null, "tolerance": 0.2, "max_paths": 300,
            "max_seconds": 60.0, "grid": {"from_um": 8.0, "to_um": 9.0, "step_um": 0.5},
            "patch_obj": false, "blender": "/usr/bin/blender", "blender_timeout_s": 600,
        });
        let options: Options = serde_json::from_value(options).expect("options");
        let command = vec!["soilsig".to_owned(), "pipeline".to_owned()];
        let cache = Cache::new(path("cache"));
        let record = pipeline::run(&options, command, &path("out"), &cache, &Unwatched);
        serde_json::to_vec_pretty(&record.expect("a run")).expect("JSON")
    };
    vec![RECORD.get_or_init(record).clone()]
}

pub fn csv() -> Inputs {
    of(&[
        &["wavelength_um,emissivity\n8,0.9\n8.5,0.8\n9,0.7\n10,0.95\n"],
        &["# dry sand\nWavelength (nm);Reflectance (%)\n8000;5,9\n9000;32,0\n10000;5,9\n"],
        &["8 0.9\n9 0.8\n10 0.7\n"],
        &["\u{feff}\"Wavenumber (cm-1)\",\"Refl.\"\r\n\"1250\",\"0.1\"\r\n\"1000\",\"0.3\"\r\n"],
    ])
}

pub fn ecostress() -> Inputs {
    let head = "Name: Sand\nType: Soil\nClass: Entisol\nDescription: dry\nMeasurement: \
                Hemispherical reflectance\nFirst Column: X\nSecond Column: Y\nX Units: Wavelength \
                (micrometers)\nY Units: Reflectance (percent)\nNumber of X Values: 3\n\
                Additional Information: none\n\n";
    let rows = " 10.0\t5.9\n 9.0\t32.0\n 8.0\t5.9\n";
    of(&[&[&format!("{head}{rows}")]])
}

pub fn usgs() -> Inputs {
    let seven = " splib07a Record=5932: Quartz GDS74 Sand Ottawa   NIC4aaa RREF\n \
                 5.9E-02\n 3.2E-01\n -1.23E+34\n";
    let um = " splib07a Record=10: Wavelengths NIC4 Nicolet 1.12-216 microns\n 8.0\n 9.0\n 10.0\n";
    let dashes = "-".repeat(52);
    let six = format!(
        "USGS Digital Spectral Library splib06a\nClark and others 2007\n\nwavelength reflectance\n\
         {dashes}\nQuartz GDS74 Sand W1R1Fa AREF\ncopy of splib05a r 1\n 8 0.059 0\n 9 0.32 0.01\n \
         9.5 -1.23e34 0\n 10 0.059 0\n"
    );
    of(&[&[seven, um], &[&six, ""]])
}

pub fn jcamp() -> Inputs {
    let head = "##TITLE=sand\n##JCAMP-DX=4.24\n##DATA TYPE=INFRARED SPECTRUM\n##ORIGIN=lab\n\
                ##OWNER=lab\n";
    let points = "##XUNITS=MICROMETERS\n##YUNITS=REFLECTANCE\n##XFACTOR=1.0\n##YFACTOR=1.0\n\
                  ##FIRSTX=8\n##LASTX=10\n##NPOINTS=3\n##XYPOINTS=(XY..XY)\n8,0.059\n9,0.32\n\
                  10,0.059\n##END=\n";
    let packed = "##XUNITS=1/CM\n##YUNITS=REFLECTANCE\n##XFACTOR=1\n##YFACTOR=0.001\n\
                  ##FIRSTX=1000\n##LASTX=1004\n##NPOINTS=5\n##DELTAX=1\n##FIRSTY=0.1\n\
                  ##XYDATA=(X++(Y..Y))\n1000 100+110+120\n1003A30J0\n##END=\n";
    of(&[&[&format!("{head}{points}")], &[&format!("{head}{packed}")]])
}

/// A header, and so many numbers of single precision.
fn envi(header: &str, numbers: usize) -> Vec<u8> {
    let data: Vec<u8> = (0..numbers).flat_map(|i| (0.5 + 0.01 * i as f32).to_le_bytes()).collect();
    [header.as_bytes().to_vec(), data].join(BETWEEN)
}

pub fn sli() -> Inputs {
    let header = "ENVI\ndescription = { sand }\nsamples = 4\nlines = 2\nbands = 1\n\
                  header offset = 0\nfile type = ENVI Spectral Library\ndata type = 4\n\
                  interleave = bsq\nbyte order = 0\nwavelength units = Micrometers\n\
                  spectra names = {one, two}\nreflectance scale factor = 1\n\
                  z plot titles = {Wavelength, Emissivity}\nwavelength = {8, 9, 10, 11}\n";
    vec![envi(header, 8)]
}

pub fn ems() -> Inputs {
    let weights = "1.0\n".repeat(91);
    of(&[&[&format!(" 1\n{weights}CURVE_BEGIN\n   8.0   0.5\n   9.0   0.6\n   20.0   0.5\n")]])
}

pub fn images() -> Inputs {
    let header = "ENVI\nsamples = 2\nlines = 2\nbands = 3\nheader offset = 0\n\
                  file type = ENVI Standard\ndata type = 4\ninterleave = bil\nbyte order = 0\n\
                  wavelength units = Micrometers\nwavelength = {8, 9, 10}\nfwhm = {1, 1, 1}\n\
                  bbl = {1, 0, 1}\ndata ignore value = -9999\n";
    vec![envi(header, 12)]
}

pub fn skies() -> Inputs {
    of(&[
        &["wavelength_um,l_downwelling_w_m2_sr_um\n8,1.5\n9,1.25\n10,1\n"],
        &["zenith_deg,wavelength_um,l_downwelling_w_cm2_sr_um\n0,8,1e-4\n0,9,1e-4\n90,8,2e-4\n\
           90,9,2e-4\n"],
    ])
}

pub fn atmospheres() -> Inputs {
    of(&[&["wavelength_um,transmittance,l_path_w_m2_sr_um\n8,0.8,0.5\n9,0.9,0.25\n10,1,0\n"]])
}

pub fn radiances() -> Inputs {
    let rows: String = (0..12)
        .map(|i| format!("{},{},1.5\n", 8.0 + 0.25 * f64::from(i), 9.0 + 0.05 * f64::from(i)))
        .collect();
    of(&[&[&format!("wavelength_um,radiance_w_m2_sr_um,l_downwelling_w_m2_sr_um\n{rows}")]])
}

pub fn responses() -> Inputs {
    of(&[&["wavelength_um,transmittance\n8,0\n8.5,0.5\n9,1\n9.5,0.25\n10,0\n"]])
}

pub fn sensors() -> Inputs {
    of(&[&["wavelength_um,one,two\n8,0,0\n8.5,1,0\n9,0.5,0.5\n9.5,0,1\n10,0,0\n"]])
}

pub fn signatures() -> Inputs {
    let heading = "wavelength_um,emissivity,emissivity_half_width_95,total_95\n";
    of(&[&[&format!("{heading}8,0.9,0.01,0.02\n9,0.8,0.01,0.02\n")], &["8,0.9\n9,0.8\n"]])
}

pub fn dirsig() -> Inputs {
    let odb = "DIRSIG_ODB = 1.0\n\n# one pit\nOBJECT {\n  OBJ_FILENAME = a.obj\n  UNITS = METERS\n  \
               INSTANCES {\n    INFO = 0, 0, 0, 0.001, 0.001, 0.001, 0, 0, 0\n    INFO = 1 0 0 0 0 \
               1 0 0 0 0 1 0 0 0 0 1\n  }\n}\n";
    let mat = "MATERIAL_ENTRY {\n  ID = rock\n  NAME = Class #2\n  TEMP_SOLVER {\n    TEMPERATURE = \
               300\n  }\n  SURFACE_PROPERTIES {\n    EMISSIVITY_PROP {\n      FILENAME = a.ems\n      \
               SPECULAR_FRACTION = 0\n    }\n  }\n}\n";
    let ems = String::from_utf8(ems().remove(0)).expect("text");
    of(&[&[odb, mat, &ems, PIT]])
}

pub fn grains() -> Inputs {
    let json = r#"{"soilsig_grain": 1, "shape": "angular", "diameter_um": 620.3505}"#;
    let obj = "o cube\nv 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nv 0 0 500\nv 500 0 500\n\
               v 500 500 500\nv 0 500 500\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n\
               f 4 1 5 8\n";
    of(&[&[json, obj]])
}

pub fn optics() -> Inputs {
    of(&[
        &[include_str!("../../../spectra/calcite.json")],
        &[include_str!("../../../spectra/quartz_spitzer_kleinman.json")],
        &[include_str!("../../../spectra/quartz_zeidler.json")],
        &[include_str!("../../../spectra/corundum.json")],
        &[include_str!("../../../spectra/hematite.json")],
    ])
}

/// The folder of inputs that were once read wrongly, below that of the crate.
pub fn found(root: &Path, parser: &str) -> Inputs {
    let folder = root.join("tests/it/fuzz/found").join(parser);
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort_unstable();
    paths.iter().map(|path| std::fs::read(path).expect("read")).collect()
}
