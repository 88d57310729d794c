use super::format::Reading;
use super::*;

fn csv(content: &str) -> Result<Tabulated, SpectrumError> {
    let file = tempfile::NamedTempFile::new().expect("temporary file");
    std::fs::write(file.path(), content).expect("written");
    format::read_one(file.path(), &Reading::default())
}

#[test]
fn a_csv_spectrum_is_read_in_either_order_and_interpolated() {
    for content in ["um,eps\n8,0.2\n10,0.6\n", "10, 0.6\n8, 0.2\n"] {
        let spectrum = Spectrum::Tabulated(csv(content).expect("a spectrum"));
        assert!((spectrum.emissivity(9.0).expect("in range") - 0.4).abs() < 1e-15);
        assert!(spectrum.emissivity(10.0).is_ok());
    }
}

#[test]
fn what_is_wrong_in_a_csv_spectrum_is_named_with_its_line() {
    for (content, line, part) in [
        ("8,0.2\n9,NaN\n", "", "at least two"),
        ("8,0.2\n9,35\n", "line 2", "within 0 to 1"),
        ("8,0.2\nx,0.3\n", "line 2", "not two numbers"),
        ("8,0.2\n9,0.3,1\n", "line 2", "3 columns"),
        ("8,0.2\n8,0.3\n", "line 2", "twice"),
        ("-8,0.2\n8,0.3\n", "line 1", "not a valid wavelength"),
        ("um,eps\n8,0.2\n", "", "at least two"),
    ] {
        let error = csv(content).expect_err("it is refused").to_string();
        assert!(error.contains(line) && error.contains(part), "{content:?}: {error}");
    }
}

#[test]
fn outside_its_range_a_spectrum_is_an_error() {
    let spectrum = Spectrum::builtin("quartz_fine").expect("shipped");
    assert!(spectrum.emissivity(7.3).is_ok() && spectrum.emissivity(14.0).is_ok());
    for um in [7.299, 14.001, f64::NAN] {
        assert!(matches!(spectrum.emissivity(um), Err(SpectrumError::Range(_))), "{um}");
    }
}

#[test]
fn only_fresnel_facets_reflect_by_angle_and_their_emissivity_is_hemispherical() {
    let fresnel = Spectrum::fresnel("quartz").expect("shipped");
    let at = |cosine| fresnel.reflectance_at(9.0, cosine).expect("in range");
    assert!(fresnel.is_angular() && at(0.0) > at(0.5) && at(0.5) > at(1.0));
    let mean = crate::spectrum::optics::hemispherical_mean(at);
    assert!((fresnel.emissivity(9.0).expect("in range") + mean - 1.0).abs() < 1e-12);
    for um in [6.99, 14.01] {
        for outside in [fresnel.emissivity(um), fresnel.reflectance_at(um, 1.0)] {
            assert!(matches!(outside, Err(SpectrumError::Range(_))), "{um}");
        }
    }
    let constant = Spectrum::Constant(0.25);
    assert!(!constant.is_angular());
    assert_eq!(constant.reflectance_at(9.0, 0.1).expect("no bound"), 0.75);
    assert!(matches!(Spectrum::fresnel("basalt"), Err(SpectrumError::Unknown { .. })));
}

#[test]
fn a_stored_spectrum_reads_back_the_same() {
    let tabulated = csv("8,0.2\n10,0.6\n").expect("a spectrum");
    let fine = Spectrum::builtin("quartz_fine").expect("shipped");
    for spectrum in [
        Spectrum::Constant(0.3),
        Spectrum::builtin("quartz_coarse").expect("shipped"),
        Spectrum::Tabulated(tabulated),
        Spectrum::fresnel("quartz").expect("shipped"),
        Spectrum::Mix(Mix::new(vec![(0.25, Spectrum::Constant(0.5)), (0.75, fine)])),
        Spectrum::of_crystal(Crystal {
            title: "half".into(),
            ..crystal("quartz_zeidler").expect("shipped").clone()
        }),
    ] {
        let text = serde_json::to_string(&spectrum).expect("JSON");
        assert_eq!(serde_json::from_str::<Spectrum>(&text).expect("the same JSON"), spectrum);
    }
}
