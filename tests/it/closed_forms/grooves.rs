//! Grooves without end: hemispherical emissivities from their integral equations.

use super::bodies::{rectangular_grooves, v_grooves};
use super::estimate::{View, assert_is, emissivities};

const EMISSIVITIES: [f64; 3] = [0.5, 0.75, 0.9];

fn reflectances() -> Vec<Vec<f64>> {
    EMISSIVITIES.iter().map(|e| vec![1.0 - e]).collect()
}

#[test]
fn v_shaped() {
    for (angle_deg, exact) in [
        (30.0, [0.748_913_0, 0.894_529_3, 0.961_275_2]),
        (60.0, [0.654_098_3, 0.847_811_0, 0.943_049_8]),
        (90.0, [0.582_864_4, 0.806_630_1, 0.925_820_9]),
        (120.0, [0.535_433_9, 0.775_516_3, 0.911_963_1]),
    ] {
        let means = emissivities(&v_grooves(angle_deg), View::HemisphereOfProfile, &reflectances());
        for ((mean, exact), e) in means.into_iter().zip(exact).zip(EMISSIVITIES) {
            assert_is(mean, exact, &format!("{angle_deg} degrees, e {e}"));
        }
    }
}

#[test]
fn rectangular() {
    for (depth, exact) in [
        (0.5, [0.658_501, 0.850_285, 0.943_968]),
        (1.0, [0.741_240, 0.893_623, 0.961_325]),
        (2.0, [0.807_931, 0.922_318, 0.971_829]),
    ] {
        let means =
            emissivities(&rectangular_grooves(depth), View::HemisphereOfProfile, &reflectances());
        for ((mean, exact), e) in means.into_iter().zip(exact).zip(EMISSIVITIES) {
            assert_is(mean, exact, &format!("depth {depth}, e {e}"));
        }
    }
}
