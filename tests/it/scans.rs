//! Scans become grains of one's own: .stl and .ply, binary and text, thinned, through to a signature.

use std::f64::consts::PI;
use std::fmt::Write as _;

use glam::DVec3;

use crate::hollow::pebble;
use crate::support::{Place, a_blender, shipped};

/// Triangles along an edge of the octahedron that the scans are drawn from: 8 x 40^2 in all.
const PARTS: i32 = 40;

/// A scan as programs write it, in millimetres.
struct Scan {
    corners: Vec<[f32; 3]>,
    faces: Vec<[usize; 3]>,
}

impl Scan {
    fn new() -> Self {
        let (corners, faces) = pebble(PARTS);
        let far = [3.0, -2.0, 1.0];
        let place = |at: [f64; 3]| [0, 1, 2].map(|i| (at[i] / 1000.0 + far[i]) as f32);
        Self { corners: corners.into_iter().map(place).collect(), faces }
    }

    /// Volume, um3.
    fn volume(&self) -> f64 {
        let corner = |i: usize| DVec3::from(self.corners[i].map(f64::from)) * 1000.0;
        let of = |face: &[usize; 3]| {
            let [a, b, c] = face.map(|i| corner(i) - corner(0));
            a.dot(b.cross(c)) / 6.0
        };
        self.faces.iter().map(of).sum()
    }

    fn binary_stl(&self) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes.extend((self.faces.len() as u32).to_le_bytes());
        for face in &self.faces {
            bytes.extend([0; 12]);
            let corners = face.iter().flat_map(|&corner| self.corners[corner]);
            bytes.extend(corners.flat_map(f32::to_le_bytes));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn ascii_stl(&self) -> String {
        let mut text = "solid pebble\n".to_owned();
        for face in &self.faces {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in face.map(|corner| self.corners[corner]) {
                let _ = writeln!(text, "vertex {x:e} {y:e} {z:e}");
            }
            text += "endloop\nendfacet\n";
        }
        text + "endsolid pebble\n"
    }

    /// As a scanner's program writes it: with normals and colours beside the places.
    fn ply(&self, format: &str) -> Vec<u8> {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\ncomment a scan\nelement vertex {}\nproperty float x\n\
             property float y\nproperty float z\nproperty uchar red\nelement face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.corners.len(),
            self.faces.len()
        )
        .into_bytes();
        let is_text = format == "ascii";
        for [x, y, z] in &self.corners {
            if is_text {
                bytes.extend(format!("{x} {y} {z} 200\n").into_bytes());
            } else {
                bytes.extend([x, y, z].into_iter().flat_map(|x| x.to_le_bytes()));
                bytes.push(200);
            }
        }
        for face in &self.faces {
            if is_text {
                bytes.extend(format!("3 {} {} {}\n", face[0], face[1], face[2]).into_bytes());
            } else {
                bytes.push(3);
                bytes.extend(face.iter().flat_map(|&corner| (corner as i32).to_le_bytes()));
            }
        }
        bytes
    }
}

#[test]
fn every_format_gives_the_same_grain_thinned_with_the_scan_s_volume() {
    let place = Place::new();
    let scan = Scan::new();
    place.write("binary.stl", scan.binary_stl());
    place.write("ascii.stl", scan.ascii_stl());
    place.write("binary.ply", scan.ply("binary_little_endian"));
    place.write("ascii.ply", scan.ply("ascii"));
    let all = ["binary.stl", "ascii.stl", "binary.ply", "ascii.ply"];
    let diameter = (6.0 * scan.volume() / PI).cbrt();
    let import = |file: &str, deviation: &str| {
        let name = file.replace('.', "_");
        let args = ["grains", "import", file, "--out", "grains", "--shape", "angular"];
        let more = ["--unit-um", "1000", "--name", &name, "--deviation", deviation];
        place.run(&[&args[..], &more].concat(), 0).0
    };
    let kept = |file: &str| {
        let obj = place.read(format!("grains/{}.obj", file.replace('.', "_")));
        obj.lines().filter(|line| line.starts_with("f ")).count()
    };
    for file in all {
        let said = import(file, "0.005");
        assert!(said.contains("of 12800 triangles"), "{said}");
        let about = place.json(format!("grains/{}.json", file.replace('.', "_")));
        let stated = about["diameter_um"].as_f64().expect("a number");
        assert!((stated / diameter - 1.0).abs() < 1e-5, "{stated} {diameter}");
        assert_eq!(about["made_from"]["triangles"], 12800);
        assert!((100..6000).contains(&kept(file)), "{}", kept(file));
    }
    // The same bytes of corners in another order are thinned in another order.
    let counts = all.map(kept);
    assert!(counts.iter().all(|n| n.abs_diff(counts[0]) < counts[0] / 10), "{counts:?}");
    let (said, _) = place.run(&["grains", "check", "grains"], 0);
    assert_eq!(said.matches(": sound").count(), 4, "{said}");
    // A larger deviation takes fewer triangles, none takes all.
    let five = kept("binary.stl");
    import("binary.stl", "0.02");
    assert!(kept("binary.stl") < five / 2, "{five} {}", kept("binary.stl"));
    import("binary.stl", "0");
    assert_eq!(kept("binary.stl"), 12800);
}

/// Each triangle of an .stl file with corners of its own, some of them off by a rounding.
#[test]
fn corners_parted_by_rounding_are_joined_if_that_closes_the_scan() {
    let place = Place::new();
    let scan = Scan::new();
    let extent = 0.6; // of the pebble, in its millimetres
    let parted = |scan: &Scan, share: f32| {
        let mut bytes = scan.binary_stl();
        for (number, triangle) in bytes[84..].chunks_exact_mut(50).enumerate() {
            let x = f32::from_le_bytes(triangle[12..16].try_into().expect("four bytes"));
            let moved = if number % 5 == 0 { x + share * extent } else { x };
            triangle[12..16].copy_from_slice(&moved.to_le_bytes());
        }
        bytes
    };
    let args = ["grains", "import", "s.stl", "--out", "grains", "--shape", "angular"];
    let args = [&args[..], &["--unit-um", "1000", "--deviation", "0"]].concat();
    place.write("s.stl", parted(&scan, 8e-7));
    let (said, _) = place.run(&args, 0);
    assert!(said.contains("corners that differ from another by rounding were joined"), "{said}");
    assert!(said.contains("12800 of 12800 triangles"), "{said}");
    let about = place.json("grains/s.json");
    assert!(about["made_from"]["corners_joined"].as_u64().expect("a number") > 1000, "{about}");
    let stated = about["diameter_um"].as_f64().expect("a number");
    assert!((stated / (6.0 * scan.volume() / PI).cbrt() - 1.0).abs() < 1e-5, "{stated}");
    // What is sound as it is has no remark.
    place.write("s.stl", scan.binary_stl());
    let (said, _) = place.run(&args, 0);
    assert!(!said.contains("joined"), "{said}");
    assert_eq!(place.json("grains/s.json")["made_from"]["corners_joined"], 0);
    // Gaps wider than rounding stay open, and so does a hole beside parted corners.
    place.write("s.stl", parted(&scan, 1e-3));
    assert!(place.refused(&args, 3).contains("it is open"));
    let mut holed = Scan::new();
    holed.faces.pop();
    place.write("s.stl", parted(&holed, 8e-7));
    assert!(place.refused(&args, 3).contains("it is open"));
}

#[test]
fn stl_files_are_read_as_programs_write_them() {
    let scan = Scan::new();
    let (text, binary) = (scan.ascii_stl(), scan.binary_stl());
    let mut solid = binary.clone();
    solid[..5].copy_from_slice(b"solid");
    let mut no_normals = binary.clone();
    for triangle in no_normals[84..].chunks_exact_mut(50) {
        triangle[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    }
    let place = Place::new();
    for content in [
        text.to_uppercase().into_bytes(),
        text.replace("solid pebble", "solid").into_bytes(),
        text.replace("normal 0 0 0", "normal nan nan nan").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        format!("\u{feff}{text}").into_bytes(),
        solid,
        no_normals,
    ] {
        place.write("s.stl", &content);
        let args = ["grains", "import", "s.stl", "--out", "grains", "--shape", "angular"];
        let (said, _) = place.run(&[&args[..], &["--deviation", "0.02"]].concat(), 0);
        assert!(said.contains("of 12800 triangles"), "{said}");
    }
    place.write("s.stl", &binary[..binary.len() - 10]);
    let args = ["grains", "import", "s.stl", "--out", "grains", "--shape", "angular"];
    assert!(place.refused(&args, 3).contains("cut short"));
}

/// A prism over an L, whose ends begin at a corner from which a fan would leave the L.
#[test]
fn concave_faces_of_a_scan_are_cut_into_triangles() {
    let place = Place::new();
    let at = [[2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 0]];
    let corners = [0, 1].map(|z| at.map(|[x, y]| format!("v {x} {y} {z}\n")).concat());
    let sides = (1..=6).map(|i| format!("f {i} {j} {} {}\n", next(i) + 6, i + 6, j = next(i)));
    let ends = "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
    place.write("prism.obj", corners.concat() + ends + &sides.collect::<String>());
    let args = ["grains", "import", "prism.obj", "--out", "grains", "--shape", "angular"];
    place.run(&[&args[..], &["--unit-um", "100", "--deviation", "0"]].concat(), 0);
    let about = place.json("grains/prism.json");
    assert_eq!(about["made_from"]["triangles"], 20);
    let stated = about["diameter_um"].as_f64().expect("a number");
    assert!((stated / (6.0 * 3e6 / PI).cbrt() - 1.0).abs() < 1e-9, "{stated}");
}

/// The next of six corners, counted from 1.
fn next(corner: usize) -> usize {
    corner % 6 + 1
}

#[test]
fn a_scan_that_is_no_body_is_refused_with_its_place() {
    let place = Place::new();
    let mut scan = Scan::new();
    let import = |file: &str| {
        let args = ["grains", "import", file, "--out", "grains", "--shape", "angular"];
        place.refused(&args, 3)
    };
    place.write("inside_out.ply", {
        for face in &mut scan.faces {
            face.swap(0, 1);
        }
        scan.ply("ascii")
    });
    assert!(import("inside_out.ply").contains("its faces point inward"));
    place.write("open.stl", {
        scan.faces.pop();
        scan.binary_stl()
    });
    assert!(import("open.stl").contains("it is open"));
    scan.faces[3][1] = 1_000_000;
    place.write("corner.ply", scan.ply("binary_little_endian"));
    assert!(import("corner.ply").contains("corner that is not in the file"));
    place.write("cut.ply", &scan.ply("binary_little_endian")[..5000]);
    let said = import("cut.ply");
    assert!(said.contains("its element vertex cannot be read: "), "{said}");
    assert!(said.contains("mend the mesh in Blender or in the program that wrote it"), "{said}");
    assert!(said.lines().all(|line| !line.contains("\\n")), "{said}");
    place.write("picture.ply", b"\x89PNG\r\n\x1a\n");
    assert!(import("picture.ply").contains("it is no .ply file"));
    for content in ["", "hello\n"] {
        place.write("empty.stl", content);
        assert!(import("empty.stl").contains("it is no .stl file"));
    }
    place.write("scan.step", "");
    assert!(import("scan.step").contains("a .stl, .ply or .obj file"));
    assert!(!place.path("grains").exists(), "nothing is written of what is refused");
}

#[test]
fn a_scan_goes_through_to_a_signature() {
    let Some(blender) = a_blender() else { return };
    let place = Place::new();
    place.write("pebble.ply", Scan::new().ply("binary_little_endian"));
    let args = ["grains", "import", "pebble.ply", "--out", "grains", "--shape", "angular"];
    place.run(&[&args[..], &["--unit-um", "1000"]].concat(), 0);
    let scene = shipped("small.json");
    let args = ["pipeline", "--scene", &scene, "--out", "r", "--grains", "grains", "--tolerance"];
    let more = ["0.05", "--packings", "1", "--range", "9-11", "--step", "2"];
    let said = place.run_with(&blender, &[&args[..], &more].concat());
    assert!(said.contains("emissivity"), "{said}");
    let drop = place.json("r/drop.json");
    let pebble = &drop["prototypes"][0];
    assert_eq!(pebble["shape"], "pebble");
    let filled = pebble["convexity"].as_f64().expect("a number");
    assert!((0.85..0.98).contains(&filled), "the bites are still there: {filled}");
}
