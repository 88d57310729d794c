//! The bounds of a recipe: what is refused before Blender starts. `soilsig schema scene` has the
//! same bounds, of each value by itself.

use std::collections::HashMap;

use super::check::{Checked, at_most, need, positive, within};
use super::packing::{
    Cover, Drop, FineClass, Fines, Form, FromLibrary, GrainClass, Packing, ShapeSource,
};
use super::{FARTHEST_UM, Material, known};

/// Most grains of a class, and most fines on one.
pub(super) const MOST: u32 = 100_000;

/// Most ribs at the sides of a fracture.
pub(super) const MOST_RIBS: u8 = 2;

/// Largest seed: up to it every program that reads JSON has the same number.
pub(super) const MOST_SEED: u64 = 1 << 53;

/// Most dressed grains modelled of a class.
pub(super) const MOST_VARIANTS: u32 = 1000;

/// Most layers of fines.
pub(super) const MOST_LAYERS: u32 = 100;

/// Most steps of the solver within a frame: Blender takes no more.
pub(super) const MOST_SUBSTEPS: u32 = 32_767;

/// Most iterations within a step: Blender takes no more.
pub(super) const MOST_ITERATIONS: u32 = 1000;

/// Most frames of a drop.
pub(super) const MOST_FRAMES: u32 = 100_000;

/// Least proportion of a stretched shape.
pub(super) const LEAST_FORM: f64 = 0.1;

/// Longest name of a class or of a grain: Blender cuts longer ones off.
const LONGEST_NAME: usize = 40;

/// The pattern of a class's name. White space and `#` would break the .obj.
pub(super) const NAME: &str = r"^[^\s#]{1,40}$";

/// The pattern of the name of a grain, which is that of its files.
pub(super) const GRAIN_NAME: &str = "^[A-Za-z0-9_-]{1,40}$";

/// A key's place in the scene file.
fn at(key: &str) -> String {
    format!("geometry.packing.{key}")
}

impl Packing {
    /// What is wrong with it, in a scene of these materials.
    pub(super) fn check(&self, materials: &[Material]) -> Checked {
        at_most(self.seed, MOST_SEED, &at("seed"))?;
        within(self.variants, 1..=MOST_VARIANTS, &at("variants"))?;
        for (place, shape, ribs) in self.shapes() {
            self.check_shape(&place, shape, ribs)?;
        }
        for (i, grain) in self.grains.iter().enumerate() {
            self.check_grain(grain, i, materials)?;
        }
        for (i, fine) in self.fines.iter().enumerate() {
            check_fine(fine, i, materials)?;
        }
        let shares: f64 = self.fines.iter().map(|fine| fine.share).sum();
        need(self.fines.is_empty() || (shares - 1.0).abs() < 1e-6, &at("fines"), || {
            format!("the shares make {shares}, not 1")
        })?;
        need(self.grains.iter().any(|grain| grain.count > 0), &at("grains"), || {
            "there is no grain to drop".into()
        })?;
        self.check_names()?;
        within(self.dust.layers, 1..=MOST_LAYERS, &at("dust.layers"))?;
        within(self.dust.overlap, 0.0..=1.0, &at("dust.overlap"))?;
        known(materials, &self.floor_material, &at("floor_material"))?;
        self.check_tray()?;
        self.drop.check()
    }

    fn check_shape(&self, place: &str, shape: &ShapeSource, ribs: Option<u8>) -> Checked {
        let ribs_at = at(&format!("{place}.ribs"));
        if let ShapeSource::Library(FromLibrary { library }) = shape {
            need(self.library.is_some(), &at("library"), || {
                format!("is not given, and {place}.shape asks for grains of it")
            })?;
            let shape_at = at(&format!("{place}.shape"));
            need(!library.is_empty(), &shape_at, || "names no grain".into())?;
            for name in library {
                let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
                let will_do = is_short(name) && name.chars().all(is_plain);
                need(will_do, &shape_at, || {
                    format!(
                        "{name:?} cannot name a grain: use 1 to {LONGEST_NAME} letters, digits, _ \
                         and -"
                    )
                })?;
            }
            need(ribs.is_none(), &ribs_at, || {
                "grains of the library are not modelled: leave it out".into()
            })?;
        }
        if let ShapeSource::Form(Form { elongation, flatness, sphericity, .. }) = shape {
            let of = [("elongation", Some(*elongation)), ("flatness", Some(*flatness))];
            for (key, value) in of.into_iter().chain([("sphericity", *sphericity)]) {
                let shape_at = at(&format!("{place}.shape.{key}"));
                within(value.unwrap_or(1.0), LEAST_FORM..=1.0, &shape_at)?;
            }
        }
        at_most(ribs.unwrap_or(0), MOST_RIBS, &ribs_at)
    }

    fn check_grain(&self, grain: &GrainClass, number: usize, materials: &[Material]) -> Checked {
        let at = |key: &str| at(&format!("grains[{number}].{key}"));
        check_name(&grain.name, &at("name"))?;
        positive(grain.diameter_um, &at("diameter_um"))?;
        known(materials, &grain.material, &at("material"))?;
        at_most(grain.count, MOST, &at("count"))?;
        match grain.fines {
            Fines::Count(count) => at_most(count, MOST, &at("fines"))?,
            Fines::Cover(Cover { silhouette }) => {
                within(silhouette, 0.0..=1.0, &at("fines.silhouette"))?;
            }
        }
        let shares = &grain.fine_shares;
        let sum: f64 = shares.values().sum();
        need(shares.is_empty() || (sum - 1.0).abs() < 1e-6, &at("fine_shares"), || {
            format!("the shares make {sum}, not 1")
        })?;
        for (name, share) in shares {
            let place = at(&format!("fine_shares.{name}"));
            within(*share, 0.0..=1.0, &place)?;
            need(self.fines.iter().any(|fine| fine.name == *name), &place, || {
                "there is no class of fines of this name".into()
            })?;
        }
        need(grain.fines.is_none() || !self.fines.is_empty(), &self::at("fines"), || {
            format!("{} wants fines, but there is no class of them", grain.name)
        })
    }

    /// No class may be called as another is, nor as a dressed grain of another.
    fn check_names(&self) -> Checked {
        let grains = self.grains.iter().map(|class| &class.name);
        let fines = self.fines.iter().map(|class| &class.name);
        let mut taken = HashMap::new();
        for (class, name) in grains.chain(fines).enumerate() {
            need(taken.insert(name.clone(), class).is_none(), &at("grains"), || {
                format!("the name {name:?} stands twice")
            })?;
        }
        for (class, grain) in self.grains.iter().enumerate() {
            for variant in 0..self.variants_of(grain) {
                let name = format!("{}_{variant}", grain.name);
                let other = *taken.entry(name.clone()).or_insert(class);
                need(other == class, &at("grains"), || {
                    format!(
                        "{name:?} names a class, and a dressed grain of the class {:?}: rename one",
                        grain.name
                    )
                })?;
            }
        }
        Ok(())
    }

    /// How many dressed grains are modelled of a class: grains of the library in turn, each of them
    /// as often, but no more than are dropped.
    fn variants_of(&self, grain: &GrainClass) -> u32 {
        let names = match &grain.shape {
            ShapeSource::Library(FromLibrary { library }) => library.len() as u32,
            ShapeSource::Modelled(_) | ShapeSource::Form(_) => 1,
        };
        (self.variants.div_ceil(names).saturating_mul(names)).min(grain.count)
    }

    fn check_tray(&self) -> Checked {
        need(self.crop_um >= 0.0, &at("crop_um"), || "must not be negative".into())?;
        let dropped = self.grains.iter().filter(|grain| grain.count > 0);
        let widest = dropped.map(|grain| grain.diameter_um).fold(0.0, f64::max);
        for length in self.tray_um {
            positive(length, &at("tray_um"))?;
            need(length < FARTHEST_UM, &at("tray_um"), || format!("{length} um is too long"))?;
            need(length >= widest, &at("tray_um"), || {
                format!("{length} um is less than the diameter of a grain, {widest} um")
            })?;
            need(length > 2.0 * self.crop_um, &at("crop_um"), || {
                format!("a rim of {} um leaves nothing of a tray of {length} um", self.crop_um)
            })?;
        }
        Ok(())
    }
}

impl Drop {
    fn check(&self) -> Checked {
        within(self.substeps, 1..=MOST_SUBSTEPS, &at("drop.substeps"))?;
        within(self.iterations, 1..=MOST_ITERATIONS, &at("drop.iterations"))?;
        within(self.max_frames, 1..=MOST_FRAMES, &at("drop.max_frames"))?;
        positive(self.scale, &at("drop.scale"))?;
        positive(self.gravity, &at("drop.gravity"))?;
        need(self.margin.is_finite() && self.margin >= 0.0, &at("drop.margin"), || {
            "must not be negative".into()
        })
    }
}

fn check_fine(fine: &FineClass, number: usize, materials: &[Material]) -> Checked {
    let at = |key: &str| at(&format!("fines[{number}].{key}"));
    check_name(&fine.name, &at("name"))?;
    positive(fine.diameter_um, &at("diameter_um"))?;
    known(materials, &fine.material, &at("material"))?;
    within(fine.share, 0.0..=1.0, &at("share"))
}

fn check_name(name: &str, place: &str) -> Checked {
    let breaks = |c: char| c.is_whitespace() || c.is_control() || c == '#';
    need(is_short(name) && !name.contains(breaks), place, || {
        format!("{name:?} is not 1 to {LONGEST_NAME} characters without white space or '#'")
    })
}

fn is_short(name: &str) -> bool {
    (1..=LONGEST_NAME).contains(&name.chars().count())
}

#[cfg(test)]
mod tests {
    use crate::support::file_error::FileError;
    use std::path::Path;

    use serde_json::{Value, json};

    use crate::scene::{Scene, SceneError};

    /// The sparse scene with some values below its packing changed, named by JSON pointers.
    fn with(changes: &[(&str, Value)]) -> Value {
        let text = include_str!("../../scenes/sparse.json");
        let mut scene: Value = serde_json::from_str(text).expect("JSON");
        for (pointer, value) in changes {
            let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
            match scene["geometry"]["packing"].pointer_mut(parent).expect("it is there") {
                Value::Array(list) => list[key.parse::<usize>().expect("a place")] = value.clone(),
                parent => parent[key] = value.clone(),
            }
        }
        scene
    }

    /// Place and problem of what is refused.
    fn refusal(scene: &Value) -> Option<(String, String)> {
        match Scene::parse(&scene.to_string(), Path::new("scene.json")) {
            Ok(_) => None,
            Err(SceneError::File(FileError::Wrong { place: Some(place), problem, .. })) => {
                Some((place.into(), problem.into()))
            }
            Err(error) => panic!("{error}"),
        }
    }

    fn assert_refused(changes: &[(&str, Value)], place: &str, words: &str) {
        let (found, problem) =
            refusal(&with(changes)).unwrap_or_else(|| panic!("{changes:?} passes"));
        assert_eq!(found, format!("geometry.packing.{place}"), "{problem}");
        assert!(problem.contains(words), "{problem}");
    }

    #[test]
    fn every_value_is_taken_up_to_its_bounds_and_refused_beyond_here_and_by_the_schema() {
        let schema = serde_json::to_value(schemars::schema_for!(Scene)).expect("plain data");
        let validator = jsonschema::validator_for(&schema).expect("a schema");
        let long = "x".repeat(40);
        let longer = json!("x".repeat(41));
        let own = |name: &str| json!({"library": [name]});
        let form = |elongation: f64, flatness: f64| json!({"elongation": elongation, "flatness": flatness});
        for (pointer, taken, refused) in [
            ("/seed", vec![json!(0), json!(1_u64 << 53)], vec![json!((1_u64 << 53) + 1)]),
            ("/variants", vec![json!(1), json!(1000)], vec![json!(0), json!(1001)]),
            ("/tray_um/0", vec![json!(9e8)], vec![json!(-1), json!(1.1e9)]),
            ("/crop_um", vec![json!(0)], vec![json!(-1)]),
            (
                "/grains/0/name",
                vec![json!(long), json!("µ")],
                vec![longer.clone(), json!(""), json!("a b"), json!("a#b"), json!("a\tb")],
            ),
            ("/fines/1/name", vec![json!(long)], vec![longer, json!("a b")]),
            ("/grains/0/diameter_um", vec![json!(0.001)], vec![json!(0), json!(-1)]),
            ("/fines/0/diameter_um", vec![json!(0.001)], vec![json!(0), json!(-1)]),
            ("/grains/0/ribs", vec![json!(0), json!(2)], vec![json!(3)]),
            ("/fines/0/ribs", vec![json!(0), json!(2)], vec![json!(3)]),
            ("/grains/0/count", vec![json!(0), json!(100_000)], vec![json!(100_001)]),
            ("/grains/0/fines", vec![json!(0), json!(100_000)], vec![json!(100_001)]),
            (
                "/grains/0/fines",
                vec![json!({"silhouette": 0}), json!({"silhouette": 1})],
                vec![json!({"silhouette": -0.1}), json!({"silhouette": 1.1})],
            ),
            ("/fines/0/share", vec![json!(0.8)], vec![json!(-0.1), json!(1.1)]),
            ("/dust/layers", vec![json!(1), json!(100)], vec![json!(0), json!(101)]),
            ("/dust/overlap", vec![json!(0), json!(1)], vec![json!(-0.1), json!(1.1)]),
            ("/drop/substeps", vec![json!(1), json!(32_767)], vec![json!(0), json!(32_768)]),
            ("/drop/iterations", vec![json!(1), json!(1000)], vec![json!(0), json!(1001)]),
            ("/drop/max_frames", vec![json!(1), json!(100_000)], vec![json!(0), json!(100_001)]),
            ("/drop/scale", vec![json!(0.001)], vec![json!(0), json!(-1)]),
            ("/drop/gravity", vec![json!(0.001)], vec![json!(0), json!(-1)]),
            ("/drop/margin", vec![json!(0)], vec![json!(-0.1)]),
            (
                "/grains/0/shape",
                vec![own("a_stone-1"), own(&long), form(0.1, 1.0), form(1.0, 0.1)],
                vec![
                    own("a stone"),
                    own("å"),
                    own(""),
                    own("a/b"),
                    json!({"library": []}),
                    form(0.09, 1.0),
                    form(1.0, 1.1),
                ],
            ),
        ] {
            let change =
                |value: &Value| with(&[("/library", json!("grains")), (pointer, value.clone())]);
            for value in &taken {
                let scene = change(value);
                assert_eq!(refusal(&scene), None, "{pointer} {value}");
                assert!(validator.is_valid(&scene), "{pointer} {value}");
            }
            for value in &refused {
                let scene = change(value);
                let (place, problem) =
                    refusal(&scene).unwrap_or_else(|| panic!("{pointer} {value} passes"));
                let named = pointer.trim_start_matches('/').replace("/0", "[0]");
                let named = named.replace("/1", "[1]").replace('/', ".");
                let place = place.trim_start_matches("geometry.packing.");
                assert!(
                    named.starts_with(place) || place.starts_with(&named),
                    "{named}: {place}: {problem}"
                );
                assert!(!validator.is_valid(&scene), "{pointer} {value}");
            }
        }
    }

    #[test]
    fn a_recipe_that_contradicts_itself_is_refused() {
        assert_refused(&[("/tray_um/1", json!(852))], "tray_um", "diameter of a grain, 853 um");
        assert_eq!(refusal(&with(&[("/tray_um/1", json!(1201))])), None);
        assert_refused(&[("/tray_um/1", json!(1200))], "crop_um", "leaves nothing");
        assert_refused(&[("/fines", json!([]))], "fines", "grain_500 wants fines");
        assert_refused(&[("/fines/0/share", json!(0.7))], "fines", "not 1");
        let shares = |of: Value| [("/grains/0/fine_shares", of)];
        assert_eq!(refusal(&with(&shares(json!({"fine_35": 1})))), None);
        assert_refused(&shares(json!({"fine_35": 0.5})), "grains[0].fine_shares", "not 1");
        assert_refused(&shares(json!({"loam": 1})), "grains[0].fine_shares.loam", "no class");
        let none = ["/grains/0/count", "/grains/1/count", "/grains/2/count"];
        assert_refused(&none.map(|pointer| (pointer, json!(0))), "grains", "no grain to drop");
        assert_refused(&[("/grains", json!([]))], "grains", "no grain to drop");
        assert_refused(&[("/grains/1/material", json!("clay"))], "grains[1].material", "clay");
        assert_refused(&[("/fines/1/material", json!("clay"))], "fines[1].material", "clay");
        assert_refused(&[("/floor_material", json!("clay"))], "floor_material", "clay");
        let own = json!({"library": ["stone"]});
        assert_refused(&[("/grains/0/shape", own.clone())], "library", "is not given");
        let changes =
            [("/library", json!("grains")), ("/grains/0/shape", own), ("/grains/0/ribs", json!(1))];
        assert_refused(&changes, "grains[0].ribs", "leave it out");
    }

    /// Two dressed grains of each class are modelled, `grain_500_0` and `grain_500_1`.
    #[test]
    fn no_two_names_are_alike_nor_a_class_s_and_a_dressed_grain_s() {
        for pointer in ["/grains/1/name", "/fines/0/name"] {
            assert_refused(&[(pointer, json!("grain_500"))], "grains", "stands twice");
            let dressed = json!("grain_500_1");
            assert_refused(&[(pointer, dressed.clone())], "grains", "a dressed grain of the class");
            assert_eq!(refusal(&with(&[(pointer, json!("grain_500_2"))])), None);
            let one = [(pointer, dressed.clone()), ("/grains/0/count", json!(1))];
            assert_eq!(refusal(&with(&one)), None, "a single grain has one variant");
            // Three grains of the library, each of them modelled as often: three of them.
            let own = json!({"library": ["a", "b", "c"]});
            let three = [
                (pointer, json!("grain_500_2")),
                ("/library", json!("grains")),
                ("/grains/0/shape", own),
            ];
            assert_refused(&three, "grains", "a dressed grain of the class");
        }
    }
}
