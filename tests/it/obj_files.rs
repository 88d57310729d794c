//! .obj files as programs write them: the same surface is read whatever its text looks like, and
//! what cannot be read is refused by name.

use insta::assert_snapshot;
use soilsig::geometry::Bed;
use soilsig::geometry::ingest::IngestError;
use soilsig::support::error::Failure;

use crate::support::{
    PIT_CORNERS, Place, XorShift, area, facets, load, message, pit_lines, scene_of,
};

const PROTOTYPE: &str = r#"{"name": "m", "file": "m.obj"}"#;

fn bed(content: impl AsRef<[u8]>) -> Result<Bed, IngestError> {
    load(&[("m.obj", content.as_ref())], PROTOTYPE)
}

fn read(content: impl AsRef<[u8]>) -> Bed {
    let content = content.as_ref();
    bed(content).unwrap_or_else(|error| panic!("{error}:\n{}", String::from_utf8_lossy(content)))
}

fn pit() -> String {
    pit_lines().join("\n") + "\n"
}

/// Ten triangles in every case, the same to the last one.
fn assert_is_pit(content: impl AsRef<[u8]>, why: &str) {
    let content = content.as_ref();
    let found = bed(content).unwrap_or_else(|error| panic!("{why}: {error}"));
    assert_eq!(facets(&found, 1.0), facets(&read(pit()), 1.0), "{why}");
    assert_eq!(found.triangles(), 10, "{why}");
}

#[test]
fn a_pit_is_read_in_every_encoding_and_with_every_line_end() {
    let text = format!("# K\u{f6}rner, 5 \u{b5}m\n{}", pit());
    let latin_1: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let units = |mark: &str| (mark.to_owned() + &text).encode_utf16().collect::<Vec<_>>();
    let little = |mark| units(mark).into_iter().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let big = |mark| units(mark).into_iter().flat_map(u16::to_be_bytes).collect::<Vec<u8>>();
    assert_is_pit(&latin_1, "Latin-1");
    for mark in ["", "\u{feff}"] {
        assert_is_pit(mark.to_owned() + &text, "UTF-8");
        assert_is_pit(mark.to_owned() + &pit(), "a vertex in the first line");
        assert_is_pit(little(mark), "UTF-16");
        assert_is_pit(big(mark), "UTF-16, big end first");
    }
    for end in ["\r", "\r\n", "\n\n", "\n\r"] {
        assert_is_pit(text.replace('\n', end), end);
    }
    let joined = pit().replace("usemtl", "\u{feff}usemtl");
    assert_is_pit(joined, "two files with marks, joined");
    assert_is_pit(pit().trim_end(), "no line end in the last line");
}

/// Changes the lines of the pit that begin with a word.
fn with(word: &str, change: impl Fn(&str) -> String) -> String {
    let is_it = |line: &str| line.split(' ').next() == Some(word);
    let changed = |line: String| if is_it(&line) { change(&line) } else { line };
    pit_lines().into_iter().map(changed).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn a_pit_is_read_through_comments_continued_lines_and_white_space() {
    for word in ["v", "f", "usemtl"] {
        let of = |change: &dyn Fn(&str) -> String| with(word, change);
        assert_is_pit(of(&|line| format!("{line} # wall 7")), word);
        assert_is_pit(of(&|line| format!("{line}\t#7")), word);
        assert_is_pit(of(&|line| format!("  {line}  ")), word);
        assert_is_pit(of(&|line| line.replace(' ', "\t")), word);
        assert_is_pit(of(&|line| line.replace(' ', "   \u{a0}")), word);
        assert_is_pit(of(&|line| line.replace(' ', " \\\n")), word);
        assert_is_pit(of(&|line| line.replace(' ', " \\ \r\n\t")), word);
        assert_is_pit(of(&|line| format!("# {line} \\\n{line}")), "a comment is one line");
        assert_is_pit(of(&|line| format!("mtllib C:\\a b\\\n{line}")), "a path is one line");
    }
    assert_is_pit(with("f", |line| format!("{line}#glued")), "glued to the last number");
    assert_is_pit(with("v", |line| format!("{line}#glued")), "glued to the last number");
    assert_is_pit(with("v", str::to_uppercase), "capital letters");
    assert_is_pit(with("f", |line| line.replace('f', "fo")), "the older word for a face");
    assert_is_pit(pit() + "f 5 6 \\", "nothing goes on after the last line");
}

#[test]
fn what_is_no_surface_is_passed_over() {
    let more = "v -0.5 -0.5 1.2\nv 1.6 -0.5 1.2\nv 0.5 1.9 1.2\n";
    for other in ["l 9 10 11", "l 9 10 11 9", "l 9/1 10/1", "p 9 10 11", "p 9", "f 9 10", "f 9"] {
        assert_is_pit(pit() + more + other + "\n", other);
        assert_is_pit(pit() + "o other\n" + more + other + "\n", other);
    }
    for other in ["s off", "s 1", "lod 2", "g", "vp 0 1", "curv 0 1 9 10", "cstype bspline", "end"]
    {
        assert_is_pit(format!("{other}\n{}", pit()), other);
    }
}

#[test]
fn colours_and_weights_of_vertices_are_no_coordinates() {
    for colour in [" 0.4 0.5 0.1", " 120 130 140 255", " 2", " 1 0.4 0.5 0.1", " red"] {
        assert_is_pit(with("v", |line| line.to_owned() + colour), colour);
    }
    let painted = pit() + "o painted\nv 5 0 0 1 0 0\nv 6 0 0 1 0 0\nv 6 1 0 1 0 0\nf 9 10 11\n";
    assert_eq!(read(painted).triangles(), 11);
    let some = with("v", |line| {
        if line.ends_with('1') { line.to_owned() } else { format!("{line} 0.1 0.2 0.3") }
    });
    assert_is_pit(some, "colours of some vertices");
}

#[test]
fn corners_count_from_either_end() {
    let lines = pit_lines();
    let numbered = |line: &String| {
        let index =
            |word: &str| word.parse::<i64>().map_or(word.to_owned(), |i| (i - 9).to_string());
        line.split(' ').map(index).collect::<Vec<_>>().join(" ")
    };
    let (vertices, faces) = lines.split_at(9);
    let faces: Vec<String> = faces.iter().map(numbered).collect();
    assert_is_pit([vertices, &faces[..]].concat().join("\n"), "from the end");
}

#[test]
fn normals_and_texture_coordinates_that_are_missing_or_broken_do_no_harm() {
    let corner = |add: &str, line: &str| {
        let corners = line.split(' ').skip(1).map(|corner| format!(" {corner}{add}"));
        format!("f{}", corners.collect::<String>())
    };
    for add in ["//1", "/1/1", "/1", "//7", "/9/9", "//-1", "//-9", "/x/y", "//0", "/"] {
        for head in ["", "vn 0 0 1\n", "vt 0 0\nvn 0 0 1\n", "vt 0\nvn nan 0 1\n", "vn\n"] {
            let text = head.to_owned() + &with("f", |line| corner(add, line));
            assert_is_pit(&text, &format!("{head:?}, {add}"));
        }
    }
    // A normal along each wall is no reason to call the mesh coarse: none is 90 degrees off.
    for broken in ["vn nan nan nan", "vn 0 0 0", "vn 1.#IND 1.#QNAN 0", "vn"] {
        let text = format!("{broken}\n") + &with("f", |line| corner("//1", line));
        assert_eq!(read(text).meshes[0].quality.curved, 0.0, "{broken}");
    }
    // Of two faces one has a normal, 60 degrees off.
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0.866025404 0 0.5\nusemtl rock\n";
    for faces in ["f 1//1 2//1 3//1\nf 1 3 4\n", "f 1 3 4\nf 1//1 2//1 3//1\n"] {
        let curved = read(square.to_owned() + faces).meshes[0].quality.curved;
        assert!((curved - 0.5).abs() < 1e-6, "{curved}: {faces}");
    }
}

/// Every way to write a file that leaves the surface as it is, a few at a time, by chance.
#[test]
fn any_mixture_of_harmless_changes_leaves_the_same_facets() {
    let mut random = XorShift(20);
    let mut chance = move |of: f64| random.next() < of;
    for trial in 0..400 {
        let mut text = String::new();
        if chance(0.5) {
            text += "vt 0.5 0.5\nvn 0 0 1\n";
        }
        for line in pit_lines() {
            let words: Vec<&str> = line.split(' ').collect();
            if chance(0.2) {
                text += "# v 1 2 3 \\\n";
            }
            if chance(0.2) {
                text += "l 1 2 3\np 1\n\n";
            }
            let mut line = String::new();
            for (i, word) in words.iter().enumerate() {
                if i > 0 {
                    line += if chance(0.2) { " \\\n" } else { " " };
                }
                if chance(0.1) && i > 0 {
                    line += "\t";
                }
                line += word;
                if words[0] == "f" && i > 0 && chance(0.3) {
                    line += if chance(0.5) { "/1/1" } else { "//-1" };
                }
            }
            if words[0] == "v" && chance(0.3) {
                line += " 0.1 0.2 0.3";
            }
            if chance(0.2) {
                line += " # 4 5 6";
            }
            text += &(line + "\n");
        }
        if chance(0.3) {
            text = text.replace('\n', if chance(0.5) { "\r" } else { "\r\n" });
        }
        let mut bytes = text.into_bytes();
        if chance(0.3) {
            bytes.splice(0..0, [0xef, 0xbb, 0xbf]);
        }
        assert_is_pit(&bytes, &format!("{trial}: {}", String::from_utf8_lossy(&bytes)));
    }
}

/// A scene of these materials and an .obj file whose faces have the name.
fn material_of(
    usemtl: &str,
    materials: &[&str],
    instead: Option<&str>,
) -> Result<Bed, IngestError> {
    let spectrum = r#""spectrum": {"constant": 0.5}"#;
    let materials = materials.iter().map(|name| format!(r#"{{"name": "{name}", {spectrum}}}"#));
    let materials = materials.collect::<Vec<_>>().join(", ");
    let prototype = match instead {
        None => PROTOTYPE.to_owned(),
        Some(name) => format!(r#"{{"name": "m", "file": "m.obj", "material": "{name}"}}"#),
    };
    let rock = format!(r#"{{"name": "rock", {spectrum}}}"#);
    let scene = scene_of(&prototype).replace(&rock, &materials);
    let text = pit().replace("usemtl rock", usemtl);
    crate::support::load_scene(&[("m.obj", text.as_bytes())], &scene)
}

#[test]
fn a_material_is_found_by_its_name_with_or_without_a_comment() {
    for (usemtl, materials, index) in [
        ("usemtl rock # the tray", &["sand", "rock"][..], 1),
        ("usemtl rock #tray", &["rock"], 0),
        ("usemtl\trock\t", &["rock"], 0),
        ("usemtl Class #2", &["Class #1", "Class #2"], 1),
        ("usemtl Class #2", &["Class", "Class #2"], 1),
        ("usemtl Class #2 # the second", &["Class #2"], 0),
        ("usemtl #2", &["#2"], 0),
        ("usemtl a#b", &["a", "a#b"], 1),
        ("usemtl red sand", &["red", "red sand"], 1),
        ("USEMTL rock", &["rock"], 0),
    ] {
        let found = material_of(usemtl, materials, None);
        let found = found.unwrap_or_else(|error| panic!("{usemtl}: {error}"));
        assert!(found.meshes[0].materials.iter().all(|&of| of == index), "{usemtl}");
    }
    let latin_1: Vec<u8> = pit().replace("rock", "K\u{f6}rner").chars().map(|c| c as u8).collect();
    let scene = scene_of(PROTOTYPE).replace("rock", "K\u{f6}rner");
    let found = crate::support::load_scene(&[("m.obj", &latin_1)], &scene).expect("Latin-1");
    assert_eq!(found.triangles(), 10);
}

#[test]
fn faces_without_a_material_take_that_of_the_prototype() {
    let mut told = String::new();
    for usemtl in ["usemtl", "usemtl ", "usemtl # none", ""] {
        assert_eq!(material_of(usemtl, &["rock"], Some("rock")).expect(usemtl).triangles(), 10);
        let error = material_of(usemtl, &["rock"], None).expect_err("no material");
        told += &message(&error, error.hint());
    }
    // An empty slot does not keep the material before it.
    let slot = pit().replace("f 2 6", "usemtl\nf 2 6");
    let error = bed(slot).expect_err("no material");
    told += &message(&error, error.hint());
    assert_snapshot!(told);
}

#[test]
fn an_object_is_found_by_its_name_with_or_without_a_comment() {
    let named = |line: &str| {
        format!("{}\n{line}\n", &pit_lines()[..8].join("\n"))
            + &pit_lines()[8..].join("\n")
            + "\no other\nf 1 2 3\n"
    };
    for (line, object) in [
        ("o\tpit", "pit"),
        ("  o pit  ", "pit"),
        ("o pit # the first", "pit"),
        ("o pit #1", "pit #1"),
        ("o pit #1", "pit"),
        ("o\tpit\ng\twalls", "pit"),
        ("O pit", "pit"),
    ] {
        let prototype = format!(r#"{{"name": "m", "file": "m.obj", "object": "{object}"}}"#);
        let found = load(&[("m.obj", named(line).as_bytes())], &prototype);
        let found = found.unwrap_or_else(|error| panic!("{line}: {error}"));
        assert_eq!(found.triangles(), 10, "{line}");
    }
}

/// A polygon through these points of a plane, as the only face.
fn polygon(points: &[[f64; 2]]) -> String {
    let vertices: String = points.iter().map(|[x, y]| format!("v {x} {y} {}\n", 2.0 * x)).collect();
    let corners: String = (1..=points.len()).map(|i| format!(" {i}")).collect();
    format!("{vertices}usemtl rock\nf{corners}\n")
}

#[test]
fn concave_polygons_are_cut_into_triangles_that_cover_them_alone() {
    let star = |i: usize| {
        let (radius, angle) = (if i.is_multiple_of(2) { 2.0 } else { 0.7 }, i as f64 * 0.3);
        [radius * f64::cos(angle), radius * f64::sin(angle)]
    };
    let star: Vec<[f64; 2]> = (0..20).map(star).collect();
    let ell = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    // A square with a square hole, joined by a seam.
    let ring = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ];
    for (points, triangles) in [(&ell[..], 4), (&star, 18), (&ring, 8)] {
        for start in 0..points.len() {
            for reversed in [false, true] {
                let mut points = points.to_vec();
                points.rotate_left(start);
                let shoelace: f64 = (0..points.len())
                    .map(|i| (points[i], points[(i + 1) % points.len()]))
                    .map(|([ax, ay], [bx, by])| (ax * by - bx * ay) / 2.0)
                    .sum();
                if reversed {
                    points.reverse();
                }
                let found = read(polygon(&points));
                // The plane rises by 2 along x.
                let wanted = shoelace * f64::sqrt(5.0);
                assert!((area(&found, 1.0) / wanted - 1.0).abs() < 2e-3, "{start} {points:?}");
                assert_eq!(found.triangles(), triangles, "{start} {points:?}");
                let up = facets(&found, 1.0).iter().all(|[a, b, c]| {
                    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0
                });
                let down = facets(&found, 1.0).iter().all(|[a, b, c]| {
                    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0
                });
                assert!(if reversed { down } else { up }, "all face as the polygon does");
            }
        }
    }
}

#[test]
fn polygons_that_cross_themselves_are_refused() {
    for bow_tie in [
        [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
        [[0.0, 0.0], [3.0, 1.0], [3.0, 0.0], [0.0, 2.0]],
    ] {
        let error = bed(polygon(&bow_tie)).expect_err("a bow tie");
        assert!(error.to_string().contains("crosses itself"), "{error}");
    }
}

#[test]
fn a_corner_on_a_side_in_six_decimals_is_read() {
    let with_corner = |corner: &str| {
        pit().replace("usemtl", &format!("v {corner}\nusemtl")).replace("f 1 2 3 4", "f 1 9 2 3 4")
    };
    for y in ["0.000001", "0.000000", "-0.000001", "0.0000003"] {
        for x in ["0.333333", "0.5", "0.999999"] {
            let found = read(with_corner(&format!("{x} {y} 0.000000")));
            assert!((area(&found, 1.0) - 5.0).abs() < 1e-6, "{x} {y}");
        }
    }
    // Such corners make no facet too fine to be warned of.
    for y in ["0.000001", "-0.000001"] {
        let quality = &read(with_corner(&format!("0.333333 {y} 0"))).meshes[0].quality;
        assert_eq!((quality.facets, quality.too_fine), (11, 0), "{y}");
    }
}

/// A cube whose faces have these corners on their sides.
fn cube(faces: [&str; 6], more: &str) -> String {
    let vertices: String = PIT_CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces: String = faces.iter().map(|face| format!("f {face}\n")).collect();
    format!("{vertices}{more}usemtl rock\n{faces}")
}

#[test]
fn a_corner_within_a_side_leaves_a_solid_closed() {
    let plain = ["1 4 3 2", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8", "5 6 7 8"];
    assert!(read(cube(plain, "")).meshes[0].closed);
    // Corner 9 lies on the edge from 1 to 2, corner 10 on the one from 2 to 3.
    let more = "v 0.4 0 0\nv 1 0.3 0\n";
    let with_corners = ["1 4 3 10 2 9", "1 9 2 6 5", "2 10 3 7 6", "3 4 8 7", "4 1 5 8", "5 6 7 8"];
    let solid = read(cube(with_corners, more));
    assert!(solid.meshes[0].closed, "{:?}", solid.meshes[0].quality);
    assert!((area(&solid, 1.0) - 6.0).abs() < 1e-6);
}

#[test]
fn faces_without_area_are_left_out() {
    for face in ["1 1 1 1", "1 2 2 1", "1 2 1 2", "1 1 2", "1 9 10 2", "1 9 2 10", "1 9 10 9 2"] {
        let more = "v 0.333333 0.000001 0.000000\nv 0.666667 0 0.000001\nusemtl";
        let text = pit().replacen("usemtl", more, 1) + &format!("f {face}\n");
        let found = read(&text);
        assert!((area(&found, 1.0) - 5.0).abs() < 1e-5, "{face}");
    }
    for face in ["1 1 1 1", "1 2 2 1", "1 1 2"] {
        assert_is_pit(pit() + &format!("f {face}\n"), face);
    }
}

/// A sheet over a grid of n by n squares, each bent a little, as lines of a .obj file.
fn sheet(n: usize) -> (String, Vec<[usize; 4]>) {
    let height = |x: usize, y: usize| f64::sin(1.7 * x as f64 + 0.3) * f64::cos(2.3 * y as f64);
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y)));
    let vertices =
        points.map(|(x, y)| format!("v {x} {y} {}\n", 0.2 * height(x, y))).collect::<String>();
    let squares = (0..n).flat_map(|y| (0..n).map(move |x| x + 1 + y * (n + 1)));
    (vertices, squares.map(|first| [first, first + 1, first + n + 2, first + n + 1]).collect())
}

#[test]
fn a_sheet_drawn_from_both_sides_is_no_solid() {
    let both = |[a, b, c, d]: [usize; 4], back: bool| {
        let reverse = if back { format!("f {d} {c} {b} {a}\n") } else { String::new() };
        format!("f {a} {b} {c} {d}\n{reverse}")
    };
    for n in [2, 5, 20] {
        let (vertices, squares) = sheet(n);
        let faces: String = squares.iter().map(|&square| both(square, true)).collect();
        let found = read(format!("{vertices}usemtl rock\n{faces}"));
        assert_eq!(found.meshes[0].quality.open_edges, 0, "its edges are in pairs");
        assert!(!found.meshes[0].closed, "{n}");
    }
    let (vertices, squares) = sheet(2);
    let copies: String = squares
        .iter()
        .map(|&[a, b, c, d]| {
            both([a, b, c, d], false) + &format!("f {} {} {} {}\n", d + 9, c + 9, b + 9, a + 9)
        })
        .collect();
    let found = read(format!("{vertices}{vertices}usemtl rock\n{copies}"));
    assert!(!found.meshes[0].closed, "the back has vertices of its own");
    let double = pit() + "f 4 3 2 1\nf 2 6 5 1\nf 3 7 6 2\nf 4 8 7 3\nf 1 5 8 4\n";
    assert!(!read(double).meshes[0].closed);
}

#[test]
fn thin_flakes_and_touching_bodies_stay_solids() {
    let faces = ["1 4 3 2", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8", "5 6 7 8"];
    for thickness in ["0.1", "0.001", "0.00001"] {
        let flake = cube(faces, "").replace(" 1\n", &format!(" {thickness}\n"));
        let flake = flake.replace("f 1 4 3 2", "f 1 4 3 2 ");
        assert!(read(flake).meshes[0].closed, "{thickness}");
    }
    // Two by two by two cubes of one mesh: they share corners, edges and faces.
    let mut text = String::new();
    for i in 0..8 {
        let shift = [i & 1, i >> 1 & 1, i >> 2];
        for corner in PIT_CORNERS {
            let [x, y, z] = [0, 1, 2].map(|axis| corner[axis] + shift[axis] as f32);
            text += &format!("v {x} {y} {z}\n");
        }
    }
    text += "usemtl rock\n";
    for i in 0..8 {
        for face in faces {
            let corners = face.split(' ').map(|c| c.parse::<usize>().expect("a number") + 8 * i);
            text += &corners.fold("f".to_owned(), |line, corner| format!("{line} {corner}"));
            text += "\n";
        }
    }
    assert!(read(text).meshes[0].closed);
}

#[test]
fn what_cannot_be_read_of_an_obj_file_is_refused_by_name() {
    let mut told = String::new();
    let wrap = pit().replace("f 1 2 3 4", "f 1 2 3\n4");
    for content in [
        pit() + "cstype bezier\nsurf 0 1 0 1 1 2 3 4\n",
        pit() + "call walls.obj\n",
        wrap,
        pit().replace("v 1 1 1", "v1 1 1"),
        pit().replace("v 1 1 1", "v-1 1 1"),
        pit().replace("v 1 1 1", "v 1,0 1,0 1,0"),
        pit().replace("v 1 1 1", "v 1.#QNAN 1 1"),
        pit().replace("v 1 1 1", "v 1e400 1 1"),
        pit().replace("v 1 1 1", "v 1 1"),
        pit().replace("v 0 0 1", "v 0 0 \\\n 1").replace("f 3 7 8 4", "f 3 7 8 44"),
        pit().replace("f 3 7 8 4", "f 3 7 8 -9"),
        pit().replace("f 3 7 8 4", "f 3,7,8,4"),
    ] {
        let error = bed(&content).expect_err(&content);
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}

/// The number that a user comes for, out of a file with many of the traits at once.
#[test]
fn a_pit_has_its_emissivity_whatever_its_text_looks_like() {
    let mut lines = pit_lines();
    for line in &mut lines {
        *line = line.replace(' ', "\t") + " # 1 2 3";
    }
    let text = format!("\u{feff}{}\r l 1 2 3 4\r", lines.join("\r"));
    for content in [pit(), text] {
        let place = Place::new();
        place.write("m.obj", content);
        let prototype = r#"{"name": "m", "file": "m.obj", "unit_um": 1000}"#;
        place.write("scene.json", scene_of(prototype));
        place.run(&["trace", "scene.json", "--out", "table.json"], 0);
        let (curve, _) = place.run(&["signature", "table.json", "--range", "9-9"], 0);
        let line = curve.lines().last().expect("a band");
        let emissivity: f64 =
            line.split(',').nth(1).and_then(|e| e.parse().ok()).expect("a number");
        assert!((emissivity - 0.8454).abs() < 0.0023, "{line}");
    }
}
