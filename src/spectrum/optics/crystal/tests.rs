use super::*;
use crate::spectrum::crystal;

fn normal(axis: &Axis, um: f64) -> f64 {
    unpolarised_reflectance(axis.dielectric(um), 1.0)
}

#[test]
fn the_oscillators_of_quartz_have_their_known_christiansen_points_and_maxima() {
    let quartz = crystal("quartz_spitzer_kleinman").expect("shipped");
    let [(_, ordinary), (_, extraordinary)] = quartz.axes.each()[..] else { panic!("two") };
    for (axis, christiansen_um, maxima_um) in
        [(ordinary, 7.355, &[8.475, 8.985, 12.495][..]), (extraordinary, 7.350, &[12.805][..])]
    {
        let [below, above] = [-0.003, 0.003].map(|by| axis.index(christiansen_um + by).re - 1.0);
        assert!(below * above < 0.0, "n - 1 changes its sign");
        for &um in maxima_um {
            assert!(normal(axis, um) > normal(axis, um - 0.01), "{um}");
            assert!(normal(axis, um) > normal(axis, um + 0.01), "{um}");
        }
    }
    let dip = |um| normal(ordinary, um);
    assert!(dip(8.615) < dip(8.6) && dip(8.615) < dip(8.63));
}

#[test]
fn a_four_parameter_factor_is_one_at_no_splitting_and_follows_lyddane_sachs_teller() {
    let factor = Factor {
        to_per_cm: 1065.0,
        to_damping_per_cm: 7.0,
        lo_per_cm: 1226.0,
        lo_damping_per_cm: 7.0,
    };
    let none = Factor { lo_per_cm: 1065.0, ..factor };
    let axis = |factors| Axis { eps_inf: 2.0, factors, oscillators: vec![], table: None };
    assert!((axis(vec![none]).dielectric(9.0) - 2.0).norm() < 1e-14);
    let still = axis(vec![factor]).dielectric(1e7).re;
    assert!((still - 2.0 * (1226.0_f64 / 1065.0).powi(2)).abs() < 1e-9);
}

#[test]
fn the_constants_recovered_from_the_tables_of_zeidler_posch_and_mutschke_return_their_rows() {
    // Astron. Astrophys. 553, A81 (2013), natural quartz at 300 K: wavenumber in cm-1, n, k.
    // Those of 1333 and 910 are among the rows that the parameters were recovered from, the
    // others are not.
    let quartz = crystal("quartz_zeidler").expect("shipped");
    let [(_, ordinary), (_, extraordinary)] = quartz.axes.each()[..] else { panic!("two") };
    for (axis, rows) in [
        (
            ordinary,
            [
                (1333.0, 0.9732, 0.0186),
                (1226.0, 0.1986, 0.2056),
                (1162.0, 0.4078, 1.3848),
                (1156.0, 0.3451, 1.062),
                (1087.0, 0.345, 3.6185),
                (793.0, 3.2099, 1.3172),
            ],
        ),
        (
            extraordinary,
            [
                (1333.0, 0.9321, 0.0248),
                (1239.0, 0.256, 0.2261),
                (1162.0, 0.1394, 1.408),
                (1156.0, 0.1486, 1.5125),
                (1087.0, 1.3143, 4.5093),
                (910.0, 2.027, 0.0164),
            ],
        ),
    ] {
        for (wavenumber, n, k) in rows {
            let index = axis.index(1e4 / wavenumber);
            assert!(
                (index - Complex64::new(n, k)).norm() < 3e-4,
                "{wavenumber}: {index}, table {n} {k}"
            );
        }
    }
}

#[test]
fn the_sets_of_quartz_agree_where_no_resonance_is_near_and_conserve_energy() {
    let [a, b, c] = ["quartz", "quartz_zeidler", "quartz_spitzer_kleinman"]
        .map(|name| crystal(name).expect("shipped"));
    for um in [10.0, 10.5, 11.0, 11.5] {
        let [a, b, c] = [a, b, c].map(|set| set.reflectance(um, 1.0));
        assert!((a - b).abs() < 0.015 && (a - c).abs() < 0.015, "{um}: {a} {b} {c}");
    }
    for quartz in [a, b, c] {
        for um in (700..=1400).map(|i| f64::from(i) / 100.0) {
            for (_, axis) in quartz.axes.each() {
                assert!(axis.dielectric(um).im > 0.0, "gain at {um} um");
            }
            let of = |cosine| quartz.reflectance(um, cosine);
            assert!((0..=64).map(|i| of(f64::from(i) / 64.0)).all(|r| (0.0..=1.0).contains(&r)));
            assert!((of(0.0) - 1.0).abs() < 1e-12);
        }
    }
}
