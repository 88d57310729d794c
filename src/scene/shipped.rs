//! The shipped scenes, by their cover with fines, and scenes with any other cover.

use std::path::Path;

use crate::scene::{Cover, Fines, Packing, Scene, SceneGeometry};

/// The shipped scenes, from most to least covered: the order of the paper's Fig. 6.
pub const COVERAGES: [(&str, &str); 4] = [
    ("full", include_str!("../../scenes/full.json")),
    ("less", include_str!("../../scenes/less.json")),
    ("sparse", include_str!("../../scenes/sparse.json")),
    ("bare", include_str!("../../scenes/bare.json")),
];

/// The text of a shipped scene.
pub fn text(name: &str) -> Option<&'static str> {
    COVERAGES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The scene of a coverage: a shipped one's name, or a share from 0 to 1.
pub fn named(coverage: &str) -> Option<Scene> {
    let scene = match text(coverage) {
        Some(_) => shipped(coverage),
        None => with_cover(coverage.parse().ok().filter(|share| (0.0..=1.0).contains(share))?),
    };
    Some(Scene { file: format!("scenes/{coverage}.json").into(), ..scene })
}

/// The sparse scene with another number of fines: they cover a share, 0 to 1, of the grains'
/// silhouettes. The tray is the same for every share, so that a study of cover changes nothing
/// else. A share of 0 gives the bare scene, whose smaller tray makes its bed about as deep.
pub fn with_cover(share: f64) -> Scene {
    if share == 0.0 {
        return shipped("bare");
    }
    let mut scene = shipped("sparse");
    scene.name = format!("cover_{share}");
    scene.description =
        Some(format!("Quartz grains covered with fines to {share} of their silhouettes"));
    let packing = packing(&mut scene);
    for class in &mut packing.grains {
        class.fines = Fines::Cover(Cover { silhouette: share });
    }
    scene
}

fn shipped(name: &str) -> Scene {
    let text = text(name).expect("a shipped scene");
    Scene::parse(text, Path::new(name)).expect("shipped scenes are valid")
}

fn packing(scene: &mut Scene) -> &mut Packing {
    match &mut scene.geometry {
        SceneGeometry::Packing(packing) => packing,
        SceneGeometry::Placed(_) => unreachable!("the shipped coverages are packings"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_class_gets_the_share_and_the_tray_stays() {
        assert_eq!(with_cover(0.0), shipped("bare"));
        for share in [0.05, 0.2, 0.4, 0.6, 1.0] {
            let mut scene = with_cover(share);
            let text = serde_json::to_string(&scene).expect("plain data");
            assert_eq!(Scene::parse(&text, &scene.file).expect("sound"), scene);
            let tray = packing(&mut shipped("sparse")).tray_um;
            let packing = packing(&mut scene);
            assert_eq!(packing.tray_um, tray, "{share}");
            assert_eq!(packing.fines.len(), 2);
            let wanted = Fines::Cover(Cover { silhouette: share });
            assert!(packing.grains.iter().all(|class| class.fines == wanted), "{share}");
        }
    }
}
