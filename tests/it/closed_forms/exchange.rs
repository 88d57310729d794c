//! Two surfaces that close on each other, one of them too cold to glow.

use super::bodies::{Shell, concentric_spheres, parallel_plates};
use super::estimate::{View, assert_is, radiosities};

const NADIR: View = View::From { zenith_deg: 0.0 };

/// The first plate emits e1 of a black body's 1: J1 = e1 / (1 - (1 - e1)(1 - e2)), J2 = (1 - e2)
/// J1.
#[test]
fn parallel_plates_of_two_temperatures() {
    let cases = [(0.8, 0.4, 0.909_090_91, 0.545_454_55), (0.37, 0.75, 0.439_169_14, 0.109_792_28)];
    // The lower plate is looked at; material 0.
    let hot = cases.map(|(e1, e2, ..)| [[1.0 - e1, 1.0 - e2], [1.0, 0.0]]);
    let cold = cases.map(|(e1, e2, ..)| [[1.0 - e2, 1.0 - e1], [0.0, 1.0]]);
    let found = radiosities(&parallel_plates(), NADIR, [hot[0], hot[1], cold[0], cold[1]]);
    for (i, (_, _, j1, j2)) in cases.into_iter().enumerate() {
        assert_is(found[i], j1, "hot plate");
        assert_is(found[i + 2], j2, "cold plate");
    }
}

/// The inner sphere emits e1 of a black body's 1 and sees the outer one only, which sees it with
/// the ratio q of their areas, and itself with the rest.
#[test]
fn concentric_spheres_of_two_temperatures() {
    let cases = [(0.8, 0.5, 0.833_333_33, 0.166_666_67), (0.5, 0.37, 0.587_743_73, 0.175_487_47)];
    let of = |shell| {
        let sets = cases.map(|(e1, e2, ..)| [[1.0 - e1, 1.0 - e2], [1.0, 0.0]]);
        radiosities(&concentric_spheres(0.25, shell), NADIR, sets)
    };
    let (inner, outer) = (of(Shell::Inner), of(Shell::Outer));
    for (i, (_, _, j1, j2)) in cases.into_iter().enumerate() {
        assert_is(inner[i], j1, "inner sphere");
        assert_is(outer[i], j2, "outer sphere");
    }
}
