//! What of a glTF 2.0 file makes a surface, as the specification by Khronos names it. The gltf crate
//! is given this and nothing else: it refuses or panics on files whose other parts are broken.

use std::collections::BTreeMap;
use std::path::Path;

use gltf::Document;
use serde::{Deserialize, Serialize};

use crate::support::file_error::FileError;
use crate::support::text;

/// What to do about a mesh that is compressed.
pub(super) const COMPRESSED: &str = "export the mesh again without compression";

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Gltf {
    asset: Asset,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffer_views: Vec<View>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
}

#[derive(Deserialize, Serialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Deserialize, Serialize)]
pub(super) struct Node {
    pub name: Option<String>,
    #[serde(default)]
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    #[serde(skip_serializing)]
    pub skin: Option<usize>,
    pub weights: Option<Vec<f64>>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    #[serde(default, skip_serializing)]
    pub extensions: NodeExtensions,
}

#[derive(Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instances: Option<Instances>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

#[derive(Deserialize)]
pub(super) struct Instances {
    #[serde(default)]
    pub attributes: BTreeMap<String, usize>,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    pub visible: Option<bool>,
}

#[derive(Deserialize, Serialize)]
pub(super) struct Mesh {
    pub name: Option<String>,
    #[serde(default)]
    pub primitives: Vec<Primitive>,
    pub weights: Option<Vec<f64>>,
}

#[derive(Deserialize, Serialize)]
pub(super) struct Primitive {
    #[serde(default)]
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "Primitive::triangles")]
    pub mode: u32,
    #[serde(default)]
    pub targets: Vec<Attributes>,
    #[serde(default, skip_serializing)]
    pub extensions: PrimitiveExtensions,
}

/// Accessors of the vertices; those of a morph target change them.
#[derive(Default, Deserialize, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<usize>,
}

impl Primitive {
    fn triangles() -> u32 {
        4
    }
}

#[derive(Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize, Serialize)]
pub(super) struct Material {
    pub name: Option<String>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(skip_serializing_if = "Sparse::is_empty")]
    pub sparse: Option<Sparse>,
}

#[derive(Deserialize, Serialize)]
pub(super) struct Sparse {
    pub count: usize,
    pub indices: SparsePart,
    pub values: SparsePart,
}

impl Sparse {
    #[allow(clippy::ref_option, reason = "serde passes a reference")]
    fn is_empty(of: &Option<Self>) -> bool {
        of.as_ref().is_none_or(|sparse| sparse.count == 0)
    }
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    /// Of the indices only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component_type: Option<u32>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct View {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    #[serde(default, skip_serializing)]
    pub extensions: ViewExtensions,
}

#[derive(Default, Deserialize)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    meshopt: Option<serde::de::IgnoredAny>,
    #[serde(rename = "KHR_meshopt_compression")]
    meshopt_khr: Option<serde::de::IgnoredAny>,
}

impl ViewExtensions {
    /// The extension that compresses its bytes.
    pub fn compression(&self) -> Option<&'static str> {
        let first = self.meshopt.map(|_| "EXT_meshopt_compression");
        first.or(self.meshopt_khr.map(|_| "KHR_meshopt_compression"))
    }
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    #[serde(skip_serializing)]
    pub uri: Option<String>,
    pub byte_length: usize,
}

impl Gltf {
    /// The same as the gltf crate has it.
    pub fn document(&self, path: &Path) -> Result<Document, FileError> {
        let wrong = |error: serde_json::Error| FileError::wrong(path, error.to_string());
        let json = serde_json::to_value(self).map_err(wrong)?;
        Ok(Document::from_json_without_validation(serde_json::from_value(json).map_err(wrong)?))
    }
}

/// What a file says of itself.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

/// A file, and the buffer that it holds if it is binary.
///
/// # Errors
/// It is cut short, no glTF 2.0, or needs an extension that may change its shapes.
pub(super) fn parse<'a>(
    path: &Path,
    bytes: &'a [u8],
) -> Result<(Gltf, Option<&'a [u8]>), FileError> {
    let (json, blob) = chunks(bytes).map_err(|problem| FileError::wrong(path, problem))?;
    let text = text::decode(json);
    // Some programs fill up the text with zeros.
    let text = text.trim_end_matches('\0');
    let wrong = |error: serde_json::Error| FileError::wrong(path, error.to_string());
    let Head { asset, extensions_required } = serde_json::from_str(text).map_err(wrong)?;
    // A file of a later version is as good, unless it says that it is not.
    let Asset { version, min_version } = asset;
    let version = min_version.as_ref().unwrap_or(&version);
    if !version.starts_with("2.") || min_version.as_ref().is_some_and(|least| least != "2.0") {
        let problem = format!("it is glTF {version}: glTF 2.0 is read");
        return Err(FileError::wrong(path, problem).with_hint("export the mesh as glTF 2.0"));
    }
    for extension in extensions_required {
        let problem = format!("it needs the extension {extension}");
        match effect(&extension) {
            Effect::None => {}
            Effect::Compression => {
                return Err(FileError::wrong(path, problem).with_hint(COMPRESSED));
            }
            Effect::Unknown => {
                let hint = "export the mesh again without this extension";
                return Err(
                    FileError::wrong(path, problem + ", which is not known").with_hint(hint)
                );
            }
        }
    }
    Ok((serde_json::from_str(text).map_err(wrong)?, blob))
}

/// What an extension does to the shapes.
enum Effect {
    None,
    Compression,
    Unknown,
}

fn effect(extension: &str) -> Effect {
    const NO_SHAPES: [&str; 8] =
        ["materials", "texture", "lights", "animation", "audio", "techniques", "xmp", "structural"];
    match extension {
        // The first two are read; quantised normals are too, and positions are refused by name.
        "EXT_mesh_gpu_instancing" | "KHR_node_visibility" | "KHR_mesh_quantization" => Effect::None,
        _ if extension.contains("draco") || extension.contains("meshopt") => Effect::Compression,
        _ if extension.split('_').nth(1).is_some_and(|word| NO_SHAPES.contains(&word)) => {
            Effect::None
        }
        _ => Effect::Unknown,
    }
}

/// The JSON text of a file, and the buffer after it if it is binary.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |bytes: &[u8], at: usize| -> Option<usize> {
        let word = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(word) as usize)
    };
    let cut_short = || "the file is cut short".to_owned();
    let (version, length) = word(bytes, 4).zip(word(bytes, 8)).ok_or_else(cut_short)?;
    if version != 2 {
        return Err(format!("it is binary glTF {version}: glTF 2.0 is read"));
    }
    let mut rest = bytes.get(12..length).ok_or_else(cut_short)?;
    let (mut json, mut blob) = (None, None);
    while let Some((length, kind)) = word(rest, 0).zip(rest.get(4..8)) {
        let end = 8 + length;
        let chunk = rest.get(8..end).ok_or_else(cut_short)?;
        match kind {
            b"JSON" => json = json.or(Some(chunk)),
            b"BIN\0" => blob = blob.or(Some(chunk)),
            _ => {}
        }
        rest = &rest[end..];
    }
    Ok((json.ok_or("it has no JSON chunk")?, blob))
}
