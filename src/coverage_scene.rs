//! A scene for any cover with fines, from the shipped ones.

use std::path::Path;

use crate::pipeline::COVERAGES;
use crate::scene::{Cover, Fines, Packing, Scene, SceneGeometry};

/// The share of the grains' silhouettes that is fines in each shipped scene, mean over classes, as the drop
/// reports it.
const SHARES: [(&str, f64); 4] = [("full", 0.92), ("less", 0.75), ("sparse", 0.63), ("bare", 0.0)];

/// The scene whose grains have this share, 0 to 1, of their silhouettes covered with fines: the shipped scene
/// of the nearest share, so that the tray suits the bulk of its grains, with the fines of the dusted ones. 0 is
/// the bare scene itself.
pub fn scene_for(share: f64) -> Scene {
    let (nearest, _) = SHARES
        .into_iter()
        .min_by(|a, b| (a.1 - share).abs().total_cmp(&(b.1 - share).abs()))
        .expect("there are some");
    if share == 0.0 {
        return shipped(nearest);
    }
    let mut scene = shipped(nearest);
    scene.name = format!("cover_{share}");
    scene.description =
        Some(format!("Quartz grains covered with fines to {share} of their silhouettes"));
    let fines = packing(&mut shipped("sparse")).fines.clone();
    let packing = packing(&mut scene);
    packing.fines = fines;
    for class in &mut packing.grains {
        class.fines = Fines::Cover(Cover { silhouette: share });
    }
    scene
}

fn shipped(name: &str) -> Scene {
    let (_, text) = COVERAGES.iter().find(|(known, _)| *known == name).expect("a shipped scene");
    Scene::parse(text, Path::new(name)).expect("shipped scenes are sound")
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
    fn every_shipped_coverage_has_a_share() {
        let names = |pairs: &mut dyn Iterator<Item = &'static str>| pairs.collect::<Vec<_>>();
        assert_eq!(
            names(&mut SHARES.iter().map(|(name, _)| *name)),
            names(&mut COVERAGES.iter().map(|(name, _)| *name))
        );
    }

    #[test]
    fn a_share_is_asked_of_every_class_in_a_tray_that_suits_it() {
        assert_eq!(scene_for(0.0), shipped("bare"));
        for (share, like) in [(0.05, "bare"), (0.6, "sparse"), (0.85, "less"), (1.0, "full")] {
            let mut scene = scene_for(share);
            let text = serde_json::to_string(&scene).expect("plain data");
            assert_eq!(Scene::parse(&text, Path::new("scene")).expect("sound"), scene);
            let tray = packing(&mut shipped(like)).tray_um;
            let packing = packing(&mut scene);
            assert_eq!(packing.tray_um, tray, "{share}");
            assert_eq!(packing.fines.len(), 2);
            let wanted = Fines::Cover(Cover { silhouette: share });
            assert!(packing.grains.iter().all(|class| class.fines == wanted), "{share}");
        }
    }
}
