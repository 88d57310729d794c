use super::*;

#[test]
fn units_are_known_however_a_heading_writes_them() {
    use Unit::{
        Angstrom, Electronvolt, Metre, Micrometre, Nanometre, PerMetre, PerMicrometre, Terahertz,
        Wavenumber,
    };
    for (text, unit) in [
        ("wavelength_um", Micrometre),
        ("Wavelength (\u{b5}m)", Micrometre),
        ("Wellenl\u{e4}nge [\u{3bc}m]", Micrometre),
        ("Wavelength ($\\mu$m)", Micrometre),
        ("microns", Micrometre),
        ("X Units: Wavelength (micrometers)", Micrometre),
        ("Wavelength, nm", Nanometre),
        ("wavelength/nm", Nanometre),
        ("wavelength nm", Nanometre),
        ("WL_NM", Nanometre),
        ("Wavelength.nm.", Nanometre),
        ("nanom\u{e8}tres", Nanometre),
        ("Wavelength (\u{c5})", Angstrom),
        ("wavelength [m]", Metre),
        ("Wavenumber", Wavenumber),
        ("Wave number", Wavenumber),
        ("cm-1", Wavenumber),
        ("Wavenumber (cm^-1)", Wavenumber),
        ("Wellenzahl / cm\u{207b}\u{b9}", Wavenumber),
        ("1/CM", Wavenumber),
        ("Wavenumber..cm.1.", Wavenumber),
        ("wavenumber (m-1)", PerMetre),
        ("wavenumber [1/\u{b5}m]", PerMicrometre),
        ("Frequency (THz)", Terahertz),
        ("Energy (eV)", Electronvolt),
    ] {
        assert_eq!(Unit::named(text), Some(unit), "{text}");
    }
    for text in ["Wavelength", "furlongs", "W/m2/sr", "band", "(cm)"] {
        assert!(!matches!(column(text), Column::Wavelength(Some(_))), "{text}");
    }
    assert!((Unit::Terahertz.um(29.979_245_8) - 10.0).abs() < 1e-12);
    assert!((Unit::Electronvolt.um(0.123_984_198_433_200_26) - 10.0).abs() < 1e-12);
}

#[test]
fn columns_are_known_by_their_headings() {
    use Quantity::{Emissivity, EmissivityPercent, Reflectance, ReflectancePercent};
    for (quantity, texts) in [
        (
            Emissivity,
            &[
                "emissivity",
                "eps",
                "\u{3b5}",
                "Emissivit\u{e4}t",
                "emisividad",
                "spectral \
              emittance",
                "absorptance",
                "em_emissivity",
            ][..],
        ),
        (EmissivityPercent, &["Emissivity (%)", "emissivity_pct", "Emissivit\u{e9} (%)"]),
        (
            Reflectance,
            &[
                "R",
                "Refl.",
                "Albedo",
                "DHR",
                "reflectance",
                "Reflectence",
                "Reflexionsgrad",
                "R\u{e9}flectance",
                "Reflektanz",
                "hemispherical reflectance factor",
            ],
        ),
        (ReflectancePercent, &["%R", "R (%)", "Reflectance, %", "percent reflectance"]),
    ] {
        for text in texts {
            let said = Column::Values(Said::Quantity(quantity));
            assert_eq!(column(text), said, "{text}");
        }
    }
    for text in ["%T", "Transm.", "Transmittance", "TRAN", "Durchl\u{e4}ssigkeit", "T (%)"] {
        assert_eq!(column(text), Column::Values(Said::Transmission), "{text}");
    }
    for text in ["Absorbance", "Abs.", "ABS", "absorption coefficient", "extinction"] {
        assert_eq!(column(text), Column::Values(Said::Absorbance), "{text}");
    }
    for text in [
        "T",
        "A",
        "value",
        "quartz",
        "Kubelka-Munk",
        "e",
        "y",
        "band",
        "index",
        "wavelength (in)",
        "",
    ] {
        assert_eq!(column(text), Column::Unknown, "{text}");
    }
    for text in [
        "log(1/R)",
        "1-R",
        "1 - emissivity",
        "emissivity - 0.9",
        "0.5*emissivity",
        "reflectance/pi",
        "R2",
        "reflectance dB",
        "reflected radiance",
        "continuum removed reflectance",
        "single scattering albedo",
        "emissivity from reflectance",
        "d reflectance ratio",
        "non-emissivity",
        "not emissivity",
        "emissivity deficit",
        "half emissivity",
        "alpha emissivity",
        "emissivity quality",
        "emissivity range",
        "emissivity \u{b1}",
        "EmissivityRank",
    ] {
        assert_eq!(column(text), Column::Values(Said::Unclear), "{text}");
    }
    assert_eq!(column("EmissivityError"), Column::Errors);
    assert_eq!(column("emissivitystd"), Column::Values(Said::Unclear));
    assert_eq!(column("Std.Dev. of reflectance"), Column::Errors);
    assert_eq!(column("Wavelength"), Column::Wavelength(None));
    assert_eq!(column("longueur d'onde (nm)"), Column::Wavelength(Some(Unit::Nanometre)));
    assert_eq!(column("radiance (W/m2/sr/um)"), Column::Values(Said::Unclear));
}

#[test]
fn prose_is_read_without_symbols_and_percent_only_beside_the_quantity() {
    let quantity = |quantity| Some(Said::Quantity(quantity));
    assert_eq!(said("T. R. Abs measured it", false), None);
    assert_eq!(
        said("reflectance of sand with 5 % moisture", false),
        quantity(Quantity::Reflectance)
    );
    for text in ["Reflectance in percent", "reflectance (%)", "% reflectance"] {
        assert_eq!(said(text, false), quantity(Quantity::ReflectancePercent), "{text}");
    }
}
