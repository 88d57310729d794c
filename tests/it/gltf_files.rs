//! glTF files as programs write them: the same surface is read whatever way it is stored, and what
//! cannot be read is refused by name.

use std::fs;

use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use insta::assert_snapshot;
use serde_json::{Value, json};
use soilsig::geometry::Bed;
use soilsig::geometry::ingest::IngestError;
use soilsig::support::error::Failure;

use crate::support::{
    PIT_CORNERS, PIT_FACES, Place, area, facets, load, load_from, load_scene, message, pit_lines,
    scene_of,
};

const PROTOTYPE: &str = r#"{"name": "m", "file": "m.gltf", "unit_um": 1}"#;

/// A file under construction: its text and its one buffer.
#[derive(Clone)]
struct File {
    json: Value,
    bytes: Vec<u8>,
}

impl File {
    /// A file without nodes.
    fn empty() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
            "meshes": [], "materials": [{"name": "rock"}], "accessors": [], "bufferViews": [],
            "buffers": [{"byteLength": 0}],
        });
        Self { json, bytes: Vec::new() }
    }

    /// The pit as one node, with y up: accessor 0 has the indices and accessor 1 the vertices.
    fn pit() -> Self {
        let mut file = Self::empty();
        let corners = PIT_FACES.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
        let corners: Vec<u16> = corners.map(|i| i as u16).collect();
        let indices = file.accessor(5123, "SCALAR", corners.len(), &u16_bytes(&corners));
        let vertices = file.floats("VEC3", &PIT_CORNERS.map(y_up).concat());
        file.mesh(
            json!([{"attributes": {"POSITION": vertices}, "indices": indices, "material": 0}]),
        );
        file.node(json!({"name": "pit", "mesh": 0}));
        file
    }

    fn push(&mut self, list: &str, item: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(item);
        list.len() - 1
    }

    fn accessor(&mut self, kind: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": kind, "type": shape, "count": count});
        self.push("accessors", accessor)
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = self.bytes.len().into();
        self.push("bufferViews", view)
    }

    fn floats(&mut self, shape: &str, numbers: &[f32]) -> usize {
        let width = shape.strip_prefix("VEC").map_or(1, |n| n.parse().expect("a number"));
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(5126, shape, numbers.len() / width, &bytes)
    }

    #[allow(clippy::needless_pass_by_value, reason = "`json!` makes it on the spot")]
    fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({"name": "mesh", "primitives": primitives}))
    }

    /// A node of the scene.
    fn node(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(node.into());
        node
    }

    fn with(mut self, change: impl FnOnce(&mut Value)) -> Self {
        change(&mut self.json);
        self
    }

    /// The text, with the buffer in a file beside it.
    fn text(&self, uri: &str) -> String {
        let mut json = self.json.clone();
        json["buffers"][0]["uri"] = uri.into();
        json.to_string()
    }

    fn load(&self) -> Result<Bed, IngestError> {
        let text = self.text("m.bin");
        load(&[("m.gltf", text.as_bytes()), ("m.bin", &self.bytes)], PROTOTYPE)
    }

    fn read(&self) -> Bed {
        self.load().unwrap_or_else(|error| panic!("{error}: {}", self.json))
    }

    fn assert_is_pit(&self, why: &str) {
        assert_eq!(facets(&self.read(), 1.0), facets(&pit(), 1.0), "{why}");
    }

    /// The message and hint of its refusal.
    fn refusal(&self) -> String {
        match self.load() {
            Ok(bed) => panic!("{} triangles are read of {}", bed.triangles(), self.json),
            Err(error) => message(&error, error.hint()),
        }
    }

    /// The binary form, with these bytes after the JSON text to fill it up.
    fn binary(&self, filling: u8) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), filling);
        let mut blob = self.bytes.clone();
        blob.resize(blob.len().next_multiple_of(4), 0);
        let length = 12 + 8 + json.len() + 8 + blob.len();
        let word = |n: usize| (n as u32).to_le_bytes();
        [
            b"glTF",
            &word(2)[..],
            &word(length),
            &word(json.len()),
            b"JSON",
            &json,
            &word(blob.len()),
            b"BIN\0",
            &blob,
        ]
        .concat()
    }
}

/// The pit of the .obj file: the same corners in the same order.
fn pit() -> Bed {
    let text = pit_lines().join("\n");
    load(&[("m.obj", text.as_bytes())], r#"{"name": "m", "file": "m.obj"}"#).expect("sound")
}

/// A point of the scene as glTF has it.
fn y_up([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, z, -y]
}

fn u16_bytes(numbers: &[u16]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn glb(bytes: &[u8]) -> Result<Bed, IngestError> {
    load(&[("m.glb", bytes)], &PROTOTYPE.replace("gltf", "glb"))
}

#[test]
fn a_pit_is_read_from_text_and_from_binary_files() {
    let file = File::pit();
    file.assert_is_pit("a buffer beside the text");
    for filling in [b' ', 0] {
        let bytes = file.binary(filling);
        assert_eq!(facets(&glb(&bytes).expect("binary"), 1.0), facets(&pit(), 1.0));
        // What the file is stands in it, not in its name.
        let named = load(&[("m.gltf", &bytes)], PROTOTYPE).expect("binary");
        assert_eq!(named.triangles(), 10);
    }
    let padded = STANDARD.encode(&file.bytes);
    let bare = STANDARD_NO_PAD.encode(&file.bytes);
    for uri in [
        format!("data:application/octet-stream;base64,{padded}"),
        format!("data:application/gltf-buffer;base64,{bare}"),
        format!("data:;base64,{padded}"),
        format!("DATA:application/octet-stream;base64,{padded}"),
        format!("data:application/octet-stream;base64,{}", padded.replace('=', "%3D")),
        format!("data:application/octet-stream;base64,{}", padded.replace('+', "%2B")),
    ] {
        let text = file.text(&uri);
        let utf_16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in [text.as_bytes(), format!("\u{feff}{text}").as_bytes(), &utf_16] {
            let bed = load(&[("m.gltf", bytes)], PROTOTYPE).expect(&uri[..60]);
            assert_eq!(facets(&bed, 1.0), facets(&pit(), 1.0));
        }
    }
}

#[test]
fn a_buffer_that_is_no_file_is_refused() {
    let text = File::pit().text("../../dev/zero");
    let error = load(&[("m.gltf", text.as_bytes())], PROTOTYPE).expect_err("it never ends");
    assert!(error.to_string().contains("plain file"), "{error}");
}

#[test]
fn a_buffer_is_found_by_its_encoded_or_its_plain_name() {
    let file = File::pit();
    for (name, uri) in [
        ("sand bed.bin", "sand%20bed.bin"),
        ("sand bed.bin", "sand bed.bin"),
        ("10%.bin", "10%25.bin"),
        ("10%.bin", "10%.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("k\u{f6}rner.bin", "k%C3%B6rner.bin"),
        ("k\u{f6}rner.bin", "k\u{f6}rner.bin"),
        ("#1.bin", "./%231.bin"),
    ] {
        let text = file.text(uri);
        let files: [(&str, &[u8]); 2] = [("m.gltf", text.as_bytes()), (name, &file.bytes)];
        let bed = load(&files, PROTOTYPE).unwrap_or_else(|error| panic!("{uri}: {error}"));
        assert_eq!(facets(&bed, 1.0), facets(&pit(), 1.0), "{uri}");
    }
    let plain = STANDARD.encode(&file.bytes);
    let percent: String = file.bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    for uri in [
        format!("DATA:application/octet-stream;BASE64,{plain}"),
        format!("data:;base64,{}", plain.replace('+', "-").replace('/', "_")),
        format!("data:application/octet-stream,{percent}"),
    ] {
        let bed = load(&[("m.gltf", file.text(&uri).as_bytes())], PROTOTYPE);
        let bed = bed.unwrap_or_else(|error| panic!("{uri}: {error}"));
        assert_eq!(facets(&bed, 1.0), facets(&pit(), 1.0), "{uri}");
    }
    // Quaternions that are not of length 1 turn, and do not stretch.
    let longer = File::pit().with(|json| json["nodes"][0]["rotation"] = json!([0, 1.4, 0, 1.4]));
    let right = File::pit().with(|json| {
        let half = 0.5_f64.sqrt();
        json["nodes"][0]["rotation"] = json!([0, half, 0, half]);
    });
    let [longer, right] = [longer, right].map(|file| glb(&file.binary(b' ')).expect("read"));
    assert_eq!(facets(&longer, 1.0), facets(&right, 1.0));
    let mut told = String::new();
    for uri in ["https://there.org/m.bin", "file:///there/m.bin", "/there/m.bin", "%2Fthere/m.bin"]
    {
        let text = file.text(uri);
        let error = load(&[("m.gltf", text.as_bytes())], PROTOTYPE).expect_err(uri);
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}

/// The floor of the pit as one node, and a wall that stands four times about its middle.
fn instanced(attributes: impl Fn(&mut File) -> Value) -> File {
    let mut file = File::empty();
    let floor = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    let wall = [[0.5, 0.5, 0.0], [0.5, 0.5, 1.0], [-0.5, 0.5, 1.0], [-0.5, 0.5, 0.0]];
    let indices = file.accessor(5123, "SCALAR", 6, &u16_bytes(&[0, 1, 2, 0, 2, 3]));
    let [floor, wall] = [floor, wall].map(|of| file.floats("VEC3", &of.map(y_up).concat()));
    for of in [floor, wall] {
        let attributes = json!({"POSITION": of});
        file.mesh(json!([{"attributes": attributes, "indices": indices, "material": 0}]));
    }
    let attributes = attributes(&mut file);
    file.node(json!({"mesh": 0, "translation": [0.5, 0.0, -0.5]}));
    file.node(json!({
        "mesh": 1, "translation": [0.5, 0.0, -0.5],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
    }));
    file
}

/// Quarter turns about the vertical.
fn turns() -> Vec<f32> {
    (0..4)
        .flat_map(|i| {
            let half = f32::from(i as u8) * std::f32::consts::FRAC_PI_4;
            [0.0, half.sin(), 0.0, half.cos()]
        })
        .collect()
}

#[test]
fn instances_on_the_graphics_card_are_placed() {
    let turned = instanced(|file| json!({"ROTATION": file.floats("VEC4", &turns())}));
    turned.assert_is_pit("turned");
    turned
        .clone()
        .with(|json| json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]))
        .assert_is_pit("used");
    turned
        .clone()
        .with(|json| json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]))
        .assert_is_pit("required");
    let rounded = instanced(|file| {
        let bytes: Vec<u8> =
            turns().iter().flat_map(|x| ((x * 32767.0).round() as i16).to_le_bytes()).collect();
        let accessor = file.accessor(5122, "VEC4", 4, &bytes);
        file.json["accessors"][accessor]["normalized"] = true.into();
        json!({"ROTATION": accessor, "_ID": accessor})
    });
    rounded.assert_is_pit("rounded to 16 bits");
    // Drawn at another size, shifted and scaled back. The node's own scale comes last.
    let mut scaled = instanced(|file| {
        let shift = file.floats("VEC3", &[0.25; 12]);
        let scale = file.floats("VEC3", &[0.5; 12]);
        json!({"ROTATION": file.floats("VEC4", &turns()), "SCALE": scale, "TRANSLATION": shift})
    });
    scaled.json["nodes"][1]["translation"] = json!([0.0, -0.5, -1.0]);
    scaled.json["nodes"][1]["scale"] = json!([2.0, 2.0, 2.0]);
    scaled.assert_is_pit("scaled");
    let mut told = String::new();
    told += &instanced(|file| {
        json!({"ROTATION": file.floats("VEC4", &turns()), "SCALE": file.floats("VEC3", &[1.0; 9])})
    })
    .refusal();
    told += &instanced(|_| json!({"TRANSLATION": 77})).refusal();
    told += &instanced(|file| json!({"translation": file.floats("VEC3", &[0.0; 12])})).refusal();
    told += &instanced(|file| json!({"TRANSLATION": file.floats("VEC4", &[0.0; 16])})).refusal();
    assert_snapshot!(told);
}

/// The pit drawn a tenth as deep in y of the file, whose one morph target makes it whole.
fn morphed() -> File {
    let mut file = File::pit();
    let flat: Vec<f32> =
        PIT_CORNERS.map(y_up).iter().flat_map(|[x, y, z]| [*x, y / 10.0, *z]).collect();
    let change: Vec<f32> =
        PIT_CORNERS.map(y_up).iter().flat_map(|[_, y, _]| [0.0, y * 0.9, 0.0]).collect();
    let [flat, change] = [flat, change].map(|numbers| file.floats("VEC3", &numbers));
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["POSITION"] = flat.into();
    primitive["targets"] = json!([{"POSITION": change}]);
    file
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let flat = area(&morphed().read(), 1.0);
    assert!((flat - 1.4).abs() < 1e-3, "a floor and four walls a tenth as high: {flat}");
    let of_mesh = morphed().with(|json| json["meshes"][0]["weights"] = json!([1.0]));
    of_mesh.assert_is_pit("the mesh's weight");
    let of_node = morphed().with(|json| {
        json["meshes"][0]["weights"] = json!([0.0]);
        json["nodes"][0]["weights"] = json!([1.0]);
    });
    of_node.assert_is_pit("the node's weight goes before the mesh's");
    let mut both = of_node.clone();
    both.node(json!({"mesh": 0, "translation": [5, 0, 0]}));
    both.node(json!({"mesh": 0, "translation": [9, 0, 0], "weights": [0.0]}));
    let bed = both.read();
    assert_eq!((bed.meshes.len(), bed.placements.len()), (2, 3), "one mesh for each shape");
    assert!((area(&bed, 1.0) - (5.0 + 1.4 + 1.4)).abs() < 1e-3);

    // Changes of a few vertices only, on zeros that no buffer holds.
    let mut sparse = morphed().with(|json| json["meshes"][0]["weights"] = json!([1.0]));
    let raised: Vec<u8> =
        [0.0, 0.9, 0.0].repeat(4).iter().flat_map(|x: &f32| x.to_le_bytes()).collect();
    let (places, values) = (sparse.view(&[4, 5, 6, 7]), sparse.view(&raised));
    let accessor = json!({
        "componentType": 5126, "type": "VEC3", "count": 8,
        "sparse": {
            "count": 4, "indices": {"bufferView": places, "componentType": 5121},
            "values": {"bufferView": values},
        },
    });
    let target = sparse.push("accessors", accessor);
    sparse.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
    sparse.assert_is_pit("a sparse target");
    let zeros = json!({"componentType": 5126, "type": "VEC3", "count": 8});
    let zeros = sparse.push("accessors", zeros);
    let primitive = &mut sparse.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{"POSITION": target}, {"POSITION": zeros, "NORMAL": zeros}]);
    sparse.json["meshes"][0]["weights"] = json!([1.0, 1.0]);
    sparse.assert_is_pit("a target that changes nothing");

    let short = morphed().with(|json| {
        json["meshes"][0]["weights"] = json!([1.0]);
        json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    });
    let many = morphed().with(|json| json["meshes"][0]["weights"] = json!([0.5, 0.5]));
    assert_snapshot!(short.refusal() + &many.refusal());
}

#[test]
fn skins_are_refused() {
    let mut file = File::pit();
    let joint = file.node(json!({"name": "joint"}));
    file.json["skins"] = json!([{"joints": [joint]}]);
    file.assert_is_pit("a skin that no node has");
    file.json["nodes"][0]["skin"] = 0.into();
    assert_snapshot!(file.refusal());
}

#[test]
fn what_is_no_surface_does_not_matter() {
    let beside = |change: &dyn Fn(&mut Value)| File::pit().with(change);
    for extension in [
        "KHR_materials_variants",
        "KHR_materials_unlit",
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "KHR_lights_punctual",
        "KHR_xmp_json_ld",
        "KHR_animation_pointer",
        "MSFT_texture_dds",
        "KHR_node_visibility",
    ] {
        beside(&|json| json["extensionsRequired"] = json!([extension])).assert_is_pit(extension);
    }
    beside(&|json| {
        json["extensionsUsed"] = json!(["ANY_unknown", "KHR_draco_mesh_compression"]);
        json["textures"] = json!([{"source": 99}]);
        json["images"] = json!([{"uri": "gone.png"}]);
        json["animations"] = json!([{"channels": "broken"}]);
        json["cameras"] = json!([{"type": "unknown"}]);
        json["materials"][0]["pbrMetallicRoughness"] = json!({"baseColorTexture": {"index": 99}});
        json["nodes"][0]["camera"] = 7.into();
        json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 99.into();
        json["meshes"][0]["primitives"][0]["attributes"]["_OWN"] = 99.into();
        json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 0.into();
    })
    .assert_is_pit("textures, animations, cameras, attributes");
    beside(&|json| json["asset"]["version"] = "2.1".into()).assert_is_pit("a later version");
    // Least and greatest coordinates are not needed.
    beside(&|json| json["accessors"][1]["min"] = json!(["x"])).assert_is_pit("broken bounds");
}

#[test]
fn lines_and_points_are_passed_over() {
    for mode in 0..4 {
        let mut file = File::pit();
        file.mesh(json!([{"attributes": {"POSITION": 1}, "mode": mode}]));
        file.mesh(json!([{"attributes": {}, "mode": mode, "material": 9}]));
        file.node(json!({"name": "edges", "mesh": 1}));
        file.node(json!({"mesh": 2}));
        let line = json!({"attributes": {"POSITION": 1}, "mode": mode});
        file.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(line);
        file.assert_is_pit("lines beside it");
        let alone = PROTOTYPE.replace('}', r#", "object": "edges"}"#);
        let text = file.text("m.bin");
        let files: [(&str, &[u8]); 2] = [("m.gltf", text.as_bytes()), ("m.bin", &file.bytes)];
        let error = load(&files, &alone).expect_err("no faces");
        assert!(error.to_string().contains("there are no faces"), "{error}");
    }
    // A mesh without area may have lost it to the rounding of its coordinates.
    let mut file = File::pit();
    let flat = file.floats("VEC3", &[0.5; 9]);
    file.mesh(json!([{"attributes": {"POSITION": flat}, "material": 0}]));
    file.node(json!({"mesh": 1}));
    assert!(file.refusal().contains("mesh: there are no faces"));
}

#[test]
fn hidden_nodes_are_passed_over() {
    let hide = json!({"KHR_node_visibility": {"visible": false}});
    for hidden in [json!({"extensions": hide}), json!({"scale": [0, 0, 0]})] {
        let mut file = File::pit();
        let below = file.push("nodes", json!({"mesh": 0, "translation": [3, 0, 0]}));
        let node = file.node(hidden);
        file.json["nodes"][node]["children"] = json!([below]);
        file.json["nodes"][node]["mesh"] = 0.into();
        file.assert_is_pit("hidden");
    }
    let shown = json!({"KHR_node_visibility": {"visible": true}});
    File::pit().with(|json| json["nodes"][0]["extensions"] = shown).assert_is_pit("shown");
    let flat = File::pit().with(|json| json["nodes"][0]["scale"] = json!([1, 0, 1]));
    assert_snapshot!(flat.refusal());
}

#[test]
fn compressed_and_quantised_meshes_are_refused_by_name() {
    let mut told = String::new();
    for extension in [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
        "ANY_unknown_shapes",
    ] {
        let file = File::pit().with(|json| json["extensionsRequired"] = json!([extension]));
        told += &file.refusal();
    }
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    let draco = File::pit().with(|json| json["meshes"][0]["primitives"][0]["extensions"] = draco);
    draco.assert_is_pit("the triangles are there without compression too");
    let bare = |json: &mut Value| json["accessors"][1]["bufferView"].take();
    told += &draco.with(|json| drop(bare(json))).refusal();

    // The copy without compression is in a buffer that the file leaves out, or not.
    let meshopt = json!({"EXT_meshopt_compression": {"buffer": 0, "byteLength": 9, "count": 8}});
    let meshopt = File::pit().with(|json| json["bufferViews"][1]["extensions"] = meshopt);
    meshopt.assert_is_pit("the vertices are there without compression too");
    told += &meshopt
        .with(|json| {
            json["buffers"].as_array_mut().expect("a list").push(json!({"byteLength": 96}));
            json["bufferViews"][1]["buffer"] = 1.into();
        })
        .refusal();

    let mut quantised = File::pit();
    let whole: Vec<u8> = PIT_CORNERS
        .map(y_up)
        .iter()
        .flat_map(|corner| corner.map(|x| (x * 32767.0) as i16))
        .flat_map(i16::to_le_bytes)
        .collect();
    let accessor = quantised.accessor(5122, "VEC3", 8, &whole);
    quantised.json["accessors"][accessor]["normalized"] = true.into();
    quantised.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = accessor.into();
    told += &quantised.refusal();
    assert_snapshot!(told);
    // Where only normals are quantised, the shape is whole.
    let mut normals = File::pit();
    let up = normals.accessor(5120, "VEC3", 8, &[0, 127, 0].repeat(8));
    normals.json["accessors"][up]["normalized"] = true.into();
    normals.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = up.into();
    normals.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    normals.assert_is_pit("quantised normals");
    assert_eq!(normals.read().meshes[0].quality.curved, 0.0, "they serve no warning");
    // Whole ones do: four of five faces are upright.
    let up = normals.floats("VEC3", &[0.0, 1.0, 0.0].repeat(8));
    normals.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = up.into();
    let curved = normals.read().meshes[0].quality.curved;
    assert!((curved - 0.8).abs() < 1e-6, "{curved}");
}

#[test]
fn numbers_that_are_not_all_there_are_refused() {
    let mut told = String::new();
    let mut refuse = |change: &dyn Fn(&mut Value)| told += &File::pit().with(change).refusal();
    refuse(&|json| json["accessors"][0]["count"] = 33.into());
    refuse(&|json| json["accessors"][1]["count"] = 9.into());
    refuse(&|json| json["accessors"][1]["count"] = u64::MAX.into());
    refuse(&|json| json["accessors"][1]["byteOffset"] = 4.into());
    refuse(&|json| json["accessors"][1]["byteOffset"] = u64::MAX.into());
    refuse(&|json| json["accessors"][1]["type"] = "VEC2".into());
    refuse(&|json| json["accessors"][0]["componentType"] = 5122.into());
    refuse(&|json| json["accessors"][0]["componentType"] = 9.into());
    refuse(&|json| json["accessors"][1]["bufferView"] = 9.into());
    refuse(&|json| json["bufferViews"][1]["byteStride"] = 8.into());
    refuse(&|json| json["bufferViews"][1]["byteStride"] = 16.into());
    refuse(&|json| json["bufferViews"][1]["byteLength"] = 95.into());
    refuse(&|json| json["bufferViews"][1]["byteLength"] = 97.into());
    refuse(&|json| json["bufferViews"][1]["byteOffset"] = u64::MAX.into());
    refuse(&|json| json["bufferViews"][1]["buffer"] = 5.into());
    refuse(&|json| json["buffers"][0]["byteLength"] = 9999.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 9.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 0.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["indices"] = 9.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["indices"] = 1.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["mode"] = 7.into());
    refuse(&|json| json["meshes"][0]["primitives"][0]["material"] = 7.into());
    refuse(&|json| json["nodes"][0]["mesh"] = 7.into());
    refuse(&|json| json["accessors"][0]["count"] = 29.into());
    refuse(&|json| {
        json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]);
    });
    refuse(&|json| json["scenes"][0]["nodes"] = json!([7]));
    refuse(&|json| json["scene"] = 7.into());
    refuse(&|json| drop(json["accessors"][1]["bufferView"].take()));
    refuse(&|json| {
        let mut vertices = json["accessors"][1].take();
        vertices["bufferView"].take();
        vertices["count"] = 4_000_000_000_u64.into();
        json["accessors"][1] = vertices;
    });
    refuse(&|json| {
        let indices = json!({"bufferView": 0, "byteOffset": 2, "componentType": 5123});
        let sparse = json!({"count": 30, "indices": indices, "values": {"bufferView": 1}});
        json["accessors"][1]["sparse"] = sparse;
    });
    refuse(&|json| json["asset"]["version"] = "1.0".into());
    refuse(&|json| json["asset"]["minVersion"] = "2.1".into());
    let mut normals = File::pit();
    let short = normals.floats("VEC3", &[0.0; 9]);
    normals.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = short.into();
    told += &normals.refusal();
    normals.json["accessors"][short]["count"] = 8.into();
    told += &normals.refusal();
    assert_snapshot!(told);
}

#[test]
fn binary_files_that_are_cut_short_are_refused() {
    let whole = File::pit().binary(b' ');
    for length in 4..whole.len() {
        assert!(glb(&whole[..length]).is_err(), "{length} bytes");
    }
    let mut first = whole.clone();
    first[4] = 1;
    let error = glb(&first).expect_err("version 1");
    assert_snapshot!(message(&error, error.hint()));
    let more = [&whole[..], b"more"].concat();
    assert_eq!(glb(&more).expect("what comes after does not matter").triangles(), 10);
}

#[test]
fn nodes_that_are_no_tree_are_refused_at_once() {
    let mut told = String::new();
    let below = |pairs: &[(usize, &[usize])]| {
        let mut file = File::pit();
        for _ in 0..40 {
            file.push("nodes", json!({}));
        }
        for &(node, children) in pairs {
            file.json["nodes"][node]["children"] = json!(children);
        }
        file
    };
    told += &below(&[(0, &[0])]).refusal();
    told += &below(&[(0, &[1]), (1, &[0])]).refusal();
    told += &below(&[(0, &[1, 2]), (1, &[3]), (2, &[3])]).refusal();
    let doubling: Vec<[usize; 2]> = (0..40).map(|i| [i + 1, i + 1]).collect();
    let doubling: Vec<(usize, &[usize])> = doubling.iter().map(|of| &of[..]).enumerate().collect();
    told += &below(&doubling).refusal();
    told += &File::pit().with(|json| json["scenes"][0]["nodes"] = json!([0, 0])).refusal();
    assert_snapshot!(told);
    // A long chain is a tree.
    let mut chain = File::pit();
    for i in 1..20_000 {
        chain.push("nodes", json!({"children": [i + 1]}));
    }
    chain.push("nodes", json!({"mesh": 0}));
    chain.json["scenes"][0]["nodes"] = json!([1]);
    chain.assert_is_pit("a chain");
}

/// So many instances by the scene of as many instances by the file.
fn many(number: usize) -> (File, String) {
    let file =
        instanced(|file| json!({"TRANSLATION": file.floats("VEC3", &vec![0.0; 3 * number])}));
    let mut scene: Value = serde_json::from_str(&scene_of(PROTOTYPE)).expect("JSON");
    let instance = json!({"prototype": "m", "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]});
    scene["geometry"]["placed"]["instances"] = vec![instance; number].into();
    (file, scene.to_string())
}

#[test]
fn more_instances_than_can_be_traced_are_refused() {
    let (file, scene) = many(6000);
    let text = file.text("m.bin");
    let files: [(&str, &[u8]); 2] = [("m.gltf", text.as_bytes()), ("m.bin", &file.bytes)];
    let error = load_scene(&files, &scene).expect_err("36 million");
    assert_snapshot!(message(&error, error.hint()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_bed_for_which_there_is_no_memory_is_refused_before_it_takes_any() {
    let (file, scene) = many(2500);
    let place = Place::new();
    place.write("m.gltf", file.text("m.bin"));
    place.write("m.bin", &file.bytes);
    place.write("scene.json", scene);
    let program = env!("CARGO_BIN_EXE_soilsig");
    let line =
        format!("ulimit -v 2500000; '{program}' trace scene.json --out table.json --threads 2");
    let output = std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(place.folder())
        .env("SOILSIG_CACHE", place.path("cache"))
        .output()
        .expect("it runs");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.contains("GB of memory, but") && said.contains("hint:"), "{said}");
    assert!(!said.contains("panicked") && output.status.code().is_some_and(|code| code > 0));
}

/// The number that a user comes for, out of a file with many of the traits at once.
#[test]
fn a_pit_has_its_emissivity_whatever_way_it_is_stored() {
    let mut file = instanced(|file| json!({"ROTATION": file.floats("VEC4", &turns())}));
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing", "KHR_texture_transform"]);
    let place = Place::new();
    place.write("m.gltf", file.text("the%20pit.bin"));
    place.write("the pit.bin", &file.bytes);
    place.write("scene.json", scene_of(&PROTOTYPE.replace("\"unit_um\": 1", "\"unit_um\": 1000")));
    place.run(&["trace", "scene.json", "--out", "table.json"], 0);
    let (curve, _) = place.run(&["signature", "table.json", "--range", "9-9"], 0);
    let line = curve.lines().last().expect("a band");
    let emissivity: f64 = line.split(',').nth(1).and_then(|e| e.parse().ok()).expect("a number");
    assert!((emissivity - 0.8454).abs() < 0.0023, "{line}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("m.gltf"), file.text("gone.bin")).expect("written");
    let gone = load_from(folder.path(), &scene_of(PROTOTYPE)).expect_err("no buffer");
    assert!(gone.to_string().contains("gone.bin"), "{gone}");
}
