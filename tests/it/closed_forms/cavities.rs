//! Spheres and cylinders that are open at the top.

use super::bodies::{Seen, cylinder, sphere};
use super::estimate::{View, assert_is, emissivities};

const NADIR: View = View::From { zenith_deg: 0.0 };
const HEMISPHERE: View = View::HemisphereOfRound;

/// e / (e (1 - s) + s), along every ray, for an opening that is a share s of the sphere.
#[test]
fn a_spherical_cavity() {
    for (open, views_deg, exact) in [
        (0.5, &[0.0][..], [0.666_666_67, 0.540_145_99]),
        (0.25, &[0.0, 40.0], [0.8, 0.701_421_80]),
        (0.1, &[0.0], [0.909_090_91, 0.854_503_46]),
        (0.01, &[0.0, 40.0], [0.990_099_01, 0.983_258_04]),
    ] {
        let bed = sphere(open, 0.0, Seen::Centre);
        for &zenith_deg in views_deg {
            let reflectances = [vec![0.5, 0.5, 0.0], vec![0.63, 0.63, 0.0]];
            let means = emissivities(&bed, View::From { zenith_deg }, &reflectances);
            for (mean, exact) in means.into_iter().zip(exact) {
                assert_is(mean, exact, &format!("open {open}, from {zenith_deg} degrees"));
            }
        }
    }
}

/// Irradiation H = (a1 e1 + a2 e2) / (1 - a1 (1 - e1) - a2 (1 - e2)) and radiosities Ji = ei + (1 -
/// ei) H for shares a1, a2 of the sphere's area. Every part of the sphere sees the opening alike,
/// so their mean by area is what leaves it.
#[test]
fn a_spherical_cavity_of_two_materials() {
    for ([a1, a2], [e1, e2], [j1, j2, mean]) in [
        ([0.5, 0.4], [0.4, 0.8], [0.903_225_81, 0.967_741_94, 0.931_899_64]),
        ([0.45, 0.45], [0.37, 0.75], [0.895_695_36, 0.958_609_27, 0.927_152_32]),
    ] {
        let [rho1, rho2] = [1.0 - e1, 1.0 - e2];
        let of = |lower, reflectance: [f64; 2], seen, view| {
            let [upper, lowest] = reflectance;
            emissivities(&sphere(0.1, lower, seen), view, &[vec![upper, lowest, 0.0]])[0]
        };
        // The lower part is what the nadir view looks at.
        assert_is(of(a1, [rho2, rho1], Seen::Centre, NADIR), j1, "first material");
        assert_is(of(a2, [rho1, rho2], Seen::Centre, NADIR), j2, "second material");
        assert_is(of(a2, [rho1, rho2], Seen::Opening, HEMISPHERE), mean, "mean over the opening");
    }
}

/// Hemispherical emissivity and radiosity of the bottom's centre, for these emissivities.
#[test]
fn a_cylindrical_cavity() {
    for (depth, emissivity, exact, centre) in [
        (0.5, &[0.5, 0.9][..], &[0.656_949, 0.943_482][..], &[0.569_348, 0.919_101][..]),
        (1.0, &[0.5, 0.9], &[0.742_386, 0.961_870], &[0.687_774, 0.948_231]),
        (2.0, &[0.5], &[0.808_299], &[0.839_427]),
        (4.0, &[0.5], &[0.832_943], &[0.946_030]),
    ] {
        let reflectances: Vec<Vec<f64>> = emissivity.iter().map(|e| vec![1.0 - e, 0.0]).collect();
        for (seen, view, exact) in
            [(Seen::Opening, HEMISPHERE, exact), (Seen::Centre, NADIR, centre)]
        {
            let means = emissivities(&cylinder(depth, seen), view, &reflectances);
            for (mean, exact) in means.into_iter().zip(exact) {
                assert_is(mean, *exact, &format!("depth {depth}"));
            }
        }
    }
}
