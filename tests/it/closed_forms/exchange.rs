//! Two surfaces that close on each other, one of them too cold to glow.

use super::bodies::{Shell, concentric_spheres, parallel_plates};
use super::estimate::{View, assert_is, radiosity};

const NADIR: View = View::From { zenith_deg: 0.0 };

/// The first plate emits e1 of a black body's 1: J1 = e1 / (1 - (1 - e1)(1 - e2)), J2 = (1 - e2)
/// J1.
#[test]
fn parallel_plates_of_two_temperatures() {
    for (e1, e2, j1, j2) in
        [(0.8, 0.4, 0.909_090_91, 0.545_454_55), (0.37, 0.75, 0.439_169_14, 0.109_792_28)]
    {
        let bed = parallel_plates();
        // The lower plate is looked at; material 0.
        let hot = radiosity(&bed, NADIR, &[1.0 - e1, 1.0 - e2], &[1.0, 0.0]);
        assert_is(hot, j1, "hot plate");
        let cold = radiosity(&bed, NADIR, &[1.0 - e2, 1.0 - e1], &[0.0, 1.0]);
        assert_is(cold, j2, "cold plate");
    }
}

/// The inner sphere emits e1 of a black body's 1 and sees the outer one only, which sees it with
/// the ratio q of their areas, and itself with the rest.
#[test]
fn concentric_spheres_of_two_temperatures() {
    for (q, e1, e2, j1, j2) in [
        (0.25, 0.8, 0.5, 0.833_333_33, 0.166_666_67),
        (0.25, 0.5, 0.37, 0.587_743_73, 0.175_487_47),
    ] {
        let of = |seen| {
            radiosity(&concentric_spheres(q, seen), NADIR, &[1.0 - e1, 1.0 - e2], &[1.0, 0.0])
        };
        assert_is(of(Shell::Inner), j1, "inner sphere");
        assert_is(of(Shell::Outer), j2, "outer sphere");
    }
}
