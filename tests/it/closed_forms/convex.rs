//! A convex body in the open: no path comes back to it.

use std::f64::consts::FRAC_PI_4;

use soilsig::histogram::kept::Kept;
use soilsig::histogram::tally::Tally;
use soilsig::support::random::Purpose;
use soilsig::tracer::Tracer;
use soilsig::tracer::rules::{Facet, TracingRules};

use super::bodies::ball;

const PATHS: u64 = 200_000;

fn trace(zenith_deg: f64) -> Tally {
    let rules = TracingRules::of_facets(Kept::PLAIN, vec![Facet::LAMBERTIAN; 2]);
    let tracer = Tracer::new(ball(zenith_deg));
    tracer.trace(&rules, 1, Purpose::Result, 0..PATHS, &|_| Ok(())).expect("not interrupted")
}

/// So every path hits it once: its emissivity is that of its facets, to the last digit.
#[test]
fn a_convex_body_has_the_emissivity_of_its_facets() {
    let tally = trace(0.0);
    assert_eq!((tally.hits, tally.by_group.given_up.len()), (PATHS - tally.missed, 0));
    // The bounding rectangle is wider than the disc by 1 - pi / 4.
    let missed = tally.missed as f64 / PATHS as f64;
    assert!((missed - (1.0 - FRAC_PI_4)).abs() < 0.005, "{missed}");
}

/// A body in the open is seen whole from any side: of a ball whose eastern half is of one material,
/// (1 + sin z) / 2 is seen from the east at zenith z.
#[test]
fn an_oblique_view_sees_the_whole_body() {
    for zenith_deg in [0.0, 45.0, 60.0_f64] {
        let tally = trace(zenith_deg);
        let met = (PATHS - tally.missed) as f64;
        let east = tally.first_hits[1] as f64 / met;
        let exact = f64::midpoint(1.0, zenith_deg.to_radians().sin());
        let error = (exact * (1.0 - exact) / met).sqrt();
        assert!((east - exact).abs() < 4.0 * error + 1e-4, "{zenith_deg}: {east}, exact {exact}");
    }
}
