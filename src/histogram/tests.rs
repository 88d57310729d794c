use super::kept::PARTS;
use super::*;
use crate::support::statistics::{T_95, quantile_95};

fn state(hits: &[u16]) -> State {
    hits.into()
}

fn histogram(kept: Kept, escaped: Vec<Counted>, given_up: Vec<Counted>) -> Histogram {
    Histogram { kept, parts: PARTS, escaped, given_up, rouletted: Vec::new() }
}

#[test]
fn a_path_may_be_given_up_before_its_first_hit_but_does_not_escape_before_it() {
    let kept = Kept { order: true, ..Kept::PLAIN };
    let nowhere = vec![(state(&[]), vec![(0, PARTS as i64)])];
    let given_up = histogram(kept, Vec::new(), nowhere.clone());
    assert_eq!(given_up.check(1, GROUPS), Ok(()));
    assert_eq!(given_up.weight(&[0.5]).mean, 0.5);
    assert!(histogram(kept, nowhere, Vec::new()).check(1, GROUPS).is_err());
}

/// The keys [1, 2, 5] of a state and [1, 2] of a shorter one are neighbours.
#[test]
fn states_that_others_begin_with_are_counted_whole() {
    let keys: [&[u16]; 4] = [&[1, 1], &[1, 2, 5], &[1, 2], &[1, 3]];
    let counts = keys.iter().map(|key| (state(key), 5)).collect();
    let whole = vec![(state(&[1]), vec![(1, 5), (2, 5), (3, 5)]), (state(&[1, 2]), vec![(5, 5)])];
    assert_eq!(grouped(&counts), whole);
}

#[test]
fn the_mean_and_its_error_are_those_of_twins() {
    // Twins of 2 and 6 paths in fifths; facets of rho .5 and .2.
    let escaped =
        vec![(state(&[0, 1]), vec![(0, 4), (1, 20)]), (state(&[1, 0]), vec![(0, 6), (1, 6)])];
    let histogram = histogram(Kept::PLAIN, escaped, vec![(state(&[2, 0]), vec![(1, 4)])]);
    let weight = histogram.weight(&[0.5, 0.2]);
    let sums: [f64; 2] = [4.0 * 0.2 + 6.0 * 0.5, 20.0 * 0.2 + 6.0 * 0.5 + 4.0 * 0.125];
    let mean = (sums[0] + sums[1]) / 40.0;
    assert!((weight.mean - mean).abs() < 1e-15);
    let differ = (sums[0] - 10.0 * mean) - (sums[1] - 30.0 * mean);
    let unsure = quantile_95(2) / T_95;
    assert!((weight.standard_error - differ.abs() / 40.0 * unsure).abs() < 1e-14);
    assert!((weight.trapped - 4.0 * 0.125 / 40.0).abs() < 1e-15);
    assert_eq!((histogram.paths(), histogram.paths_given_up()), (8.0, 0.8));
}

/// Each cell of the view has another brightness and as many paths: both nets find the same, and the
/// mean is exact.
#[test]
fn a_difference_between_cells_is_no_noise() {
    let counts = |n: i64| (0..GROUPS as u16).map(|g| (g, n * i64::from(1 + g / 2))).collect();
    let rest = (0..GROUPS as u16).map(|g| (g, 100 - i64::from(1 + g / 2))).collect();
    let escaped = vec![(state(&[1]), counts(1)), (state(&[2]), rest)];
    let mut histogram = histogram(Kept::PLAIN, escaped, Vec::new());
    assert_eq!(histogram.weight(&[0.5]).standard_error, 0.0);
    histogram.escaped[0].1[6].1 += 1;
    histogram.escaped[1].1[6].1 -= 1;
    let expected = 0.25 / (100.0 * GROUPS as f64);
    assert!((histogram.weight(&[0.5]).standard_error - expected).abs() < 1e-15);
}

/// Two paths of one hit, and one of two hits that stands for another that was ended.
#[test]
fn rouletted_paths_bring_nothing_and_are_counted() {
    let escaped = vec![(state(&[1]), vec![(0, 1), (1, 1)]), (state(&[2]), vec![(1, 2)])];
    let histogram = Histogram {
        parts: 1,
        rouletted: vec![(0, 1), (1, -1)],
        ..histogram(Kept::PLAIN, escaped, Vec::new())
    };
    assert_eq!(histogram.paths(), 4.0);
    let sources = Sources { reflectance: &[0.5], l_blackbody: &[8.0], l_sky: &[2.0] };
    let (weight, radiance) = histogram.seen(sources);
    assert_eq!(weight.mean, (2.0 * 0.5 + 2.0 * 0.25) / 4.0);
    // Of four paths two reflect a half and two a quarter, of which one never came back.
    assert_eq!(radiance.l_reflected.mean, 0.375 * 2.0);
    assert_eq!(radiance.l_emitted.mean, 0.625 * 8.0);
}

#[test]
fn one_net_tells_nothing_of_the_spread() {
    let escaped = vec![(state(&[1]), vec![(3, 1000)])];
    assert_eq!(histogram(Kept::PLAIN, escaped, vec![]).weight(&[0.5]).standard_error, 0.5);
}

/// Two paths by hand: over the first material into the sky's second bin; over the first, the
/// second, and the first again into its first bin.
#[test]
fn radiance_is_emitted_and_reflected_in_the_order_of_hits() {
    let kept = Kept { order: true, zeniths: 2, ..Kept::PLAIN };
    let escaped = vec![(state(&[0, 1]), vec![(0, 1)]), (state(&[0, 1, 0, 0]), vec![(1, 1)])];
    let (rho, l, sky) = ([0.5, 0.2], [10.0, 20.0], [1.0, 3.0]);
    let sources = Sources { reflectance: &rho, l_blackbody: &l, l_sky: &sky };
    let (_, radiance) = histogram(kept, escaped, Vec::new()).seen(sources);
    let first = [0.5 * 10.0, 0.5 * 3.0];
    let second = [0.5 * 10.0 + 0.5 * 0.8 * 20.0 + 0.5 * 0.2 * 0.5 * 10.0, 0.5 * 0.2 * 0.5 * 1.0];
    assert!((radiance.l_emitted.mean - f64::midpoint(first[0], second[0])).abs() < 1e-14);
    assert!((radiance.l_reflected.mean - f64::midpoint(first[1], second[1])).abs() < 1e-14);
    let sum = radiance.l_emitted.mean + radiance.l_reflected.mean;
    assert!((radiance.l_target.mean - sum).abs() < 1e-14);
}

#[test]
fn the_rest_of_a_path_given_up_is_in_the_mean_and_left_open() {
    for order in [true, false] {
        let kept = Kept { order, ..Kept::PLAIN };
        let given_up = vec![(state(&[u16::from(!order)]), vec![(0, 1), (1, 1)])];
        let sources = Sources { reflectance: &[0.5], l_blackbody: &[8.0], l_sky: &[12.0] };
        let (_, radiance) = histogram(kept, Vec::new(), given_up).seen(sources);
        // Emitted: 4. To come: half of 8 if all is facets, to half of 12 if all is sky.
        let both = |mean: Mean| (mean.mean, mean.trapped);
        assert_eq!(both(radiance.l_target), (4.0 + 5.0, 1.0));
        assert_eq!(both(radiance.l_emitted), (4.0 + 2.0, 2.0));
        assert_eq!(both(radiance.l_reflected), (3.0, 3.0));
    }
}

/// Each way to record a path, in many bands at once, against each path by itself.
#[test]
fn every_kind_of_histogram_is_evaluated_path_by_path() {
    let kinds = [
        Kept::PLAIN,
        Kept { zeniths: 3, ..Kept::PLAIN },
        Kept { cosines: 4, ..Kept::PLAIN },
        Kept { order: true, cosines: 4, zeniths: 3, ..Kept::PLAIN },
    ];
    for kept in kinds {
        let hits = |number: u16| -> Vec<u16> {
            if kept.lists() {
                (0..=number % 5).map(|i| (i * number + number) % (2 * kept.cosines)).collect()
            } else {
                vec![1 + number % 3, number % 2 * 70]
            }
        };
        let escaped = (0..30).map(|number| {
            let bin = (kept.zeniths > 1).then_some(number % 3);
            (hits(number).into_iter().chain(bin).collect(), vec![(number % 7, 3)])
        });
        let given_up = (30..34).map(|number| (hits(number).into(), vec![(number % 9, 2)]));
        let mut histogram = histogram(kept, escaped.collect(), given_up.collect());
        histogram.rouletted = if kept.order { vec![] } else { vec![(3, -4), (9, 6)] };
        let band = |lane: usize| {
            let um = 8.0 + 0.1 * lane as f64;
            let symbols = 2 * kept.cosines;
            let rho: Vec<f64> =
                (0..symbols).map(|s| 0.1 + 0.1 * um / (f64::from(s) + 1.0)).collect();
            let l = 9.0 - um / 4.0;
            let sky: Vec<f64> = (0..kept.zeniths).map(|bin| 1.0 + 0.2 * f64::from(bin)).collect();
            (rho, vec![l, if kept.order { 5.0 } else { l }], sky)
        };
        let bands: Vec<_> = (0..LANES).map(band).collect();
        let sources =
            |(reflectance, l_blackbody, l_sky)| Sources { reflectance, l_blackbody, l_sky };
        let of = |lane: usize| sources((&*bands[lane].0, &*bands[lane].1, &*bands[lane].2));
        let evaluator = Evaluator::<LANES>::new(kept, std::array::from_fn(of));
        let seen = evaluator.evaluate(&histogram, &histogram.met());
        for (lane, seen) in seen.iter().enumerate() {
            let Sources { reflectance: rho, l_blackbody: l, l_sky } = of(lane);
            // What the hits of a path emit, and the weight that is left.
            let follow = |hits: &[u16]| {
                let symbols: Vec<usize> = if kept.lists() {
                    hits.iter().map(|&symbol| symbol.into()).collect()
                } else {
                    let times = |(m, &n): (usize, &u16)| std::iter::repeat_n(m, n.into());
                    hits.iter().enumerate().flat_map(times).collect()
                };
                symbols.into_iter().fold((0.0, 1.0), |(sum, weight), symbol| {
                    let l = l[symbol / usize::from(kept.cosines)];
                    (sum + weight * (1.0 - rho[symbol]) * l, weight * rho[symbol])
                })
            };
            let (mut weights, mut target, mut paths) = (0.0, 0.0, 2.0);
            for (state, counts) in &histogram.escaped {
                let (hits, bin) = kept.split(state);
                let (own, weight) = follow(hits);
                paths += counts[0].1 as f64;
                weights += counts[0].1 as f64 * weight;
                target += counts[0].1 as f64 * (own + weight * l_sky[bin]);
            }
            for (state, counts) in &histogram.given_up {
                let (own, weight) = follow(state);
                let middle = |l: &[f64]| f64::midpoint(l[0], l[l.len() - 1]);
                paths += counts[0].1 as f64;
                weights += counts[0].1 as f64 * weight / 2.0;
                target += counts[0].1 as f64 * (own + weight * (middle(l) + middle(l_sky)) / 2.0);
            }
            if kept.order {
                paths -= 2.0;
            } else {
                target += 2.0 * l[0];
            }
            let met = histogram.met();
            assert!((seen.weight.mean(&met, 1.0).mean - weights / paths).abs() < 1e-12, "{kept:?}");
            assert!((seen.l_target.mean(&met, 9.0).mean - target / paths).abs() < 1e-12);
            let (weight, radiance) = histogram.seen(of(lane));
            assert_eq!(weight, seen.weight.mean(&met, 1.0), "one band by itself");
            assert_eq!(radiance.l_target, seen.l_target.mean(&met, of(lane).brightest()));
        }
    }
}
