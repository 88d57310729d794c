//! The words that labels are made of, in the languages of the field.

pub(super) const WAVELENGTHS: &str = "\
    wavelength wavelengths wave wl wvl wvls wav lambda lam \u{3bb} wellenlange wellenlangen \
    wellenlaenge longueur longitud lunghezza comprimento \
    wavl wavelen wvlen wlen";
pub(super) const WAVENUMBERS: [&str; 4] = ["wavenumber", "wellenzahl", "kayser", "wavenum"];
/// Words beside a wavelength that say nothing of its unit.
pub(super) const NEUTRAL: &str = "\
    nu \u{3bd} x s d of in the de di onde onda ondes air vacuum band channel centre center \
    central mean axis units unit frequency energy photon";

pub(super) const EMISSIVITY: [&str; 9] = [
    "emissivi",
    "emisivi",
    "emissiti",
    "emittan",
    "absorptan",
    "epsilon",
    "emmissi",
    "emisivit",
    "emissionsgrad",
];
pub(super) const EMISSIVITY_SYMBOLS: &str = "emiss emis eps \u{3b5} \u{3f5} varepsilon";
pub(super) const REFLECTANCE: [&str; 14] = [
    "reflectan",
    "reflectiv",
    "reflectiviti",
    "reflektivit",
    "reflexionsgrad",
    "riflettivi",
    "reflectio",
    "reflecten",
    "reflectie",
    "refletan",
    "reflekt",
    "reflex",
    "riflett",
    "albedo",
];
pub(super) const REFLECTANCE_SYMBOLS: &str = "refl r dhr hdr drf hdrf hhr dhrf rho \u{3c1}";
pub(super) const TRANSMISSION: [&str; 5] =
    ["transm", "transitt", "trasm", "durchlass", "transparen"];
pub(super) const TRANSMISSION_SYMBOLS: &str = "tran trans tau";
pub(super) const ABSORBANCE: [&str; 4] = ["absorb", "absorpti", "extinc", "extinktion"];
pub(super) const ABSORBANCE_SYMBOLS: &str = "abs od";
/// Words that make another quantity of emissivity or reflectance.
pub(super) const OTHER: &str = "\
    anomaly arb arbitrary atr attenuated brdf change coefficient complement complementary \
    contrast counts cr delta depth difference digital gradient hull imaginary inverse inverted \
    ln log log10 loss minus negative noise offset phase plus product pseudo ratio reciprocal \
    rescaled residual rms root scaled scattering shifted slope snr sqrt squared sr stacked sum \
    times variance";
/// Beginnings of such words.
pub(super) const OTHERS: [&str; 10] = [
    "continuum",
    "cumulativ",
    "deriv",
    "detrend",
    "integrated",
    "kubelka",
    "munk",
    "normalis",
    "normaliz",
    "removed",
];
/// Other quantities that a line of prose may name.
pub(super) const FOREIGN: [&str; 7] = [
    "dielectric",
    "imaginary",
    "optical constant",
    "optical depth",
    "optical thickness",
    "permittivity",
    "refractive",
];
/// Words that deny what stands behind them.
pub(super) const DENIALS: &str = "non not no un anti without kein keine";
/// Words that may stand beside a quantity in a label. All others may change it.
pub(super) const BESIDE: &str = "\
    apparent absolute average avg band biconical bidirectional channel conical data dh diffuse \
    dimensionless dir directional effective em facet factor fraction fractional h hd hem \
    hemispherical hemispherique hemispherisch hemispherischer in lab laboratory lambda \
    measured mean median nadir normal relative smoothed spectral spectrale spectrum spektral \
    spektrale spektraler espectral spettrale surface the thermal tir to total unit unitless \
    units value values wl y \u{3bb}";
/// Words of what was measured.
pub(super) const SAMPLES: &str = "\
    albite alunite andesite anorthite basalt calcite clay coarse corundum desert dolomite dry dune \
    feldspar fine fines forsterite glass grain grains granite gypsum hematite ice kaolinite \
    limestone loam medium mineral montmorillonite olivine plagioclase powder pyroxene quartz \
    quartzite regolith rock sample sand sandstone sandy silica silt snow soil vegetation water wet";
pub(super) const ERRORS: &str =
    "std stdev stddev sd sigma error errors err uncertainty unc deviation se";
