//! `soilsig spectra`: what spectra there are, what they hold, and other formats for them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::{ChartFormat, file_of, print, range, spectrum_source, usage};
use crate::draw::plot::{self, Chart, Curve};
use crate::scene::{Grid, SpectrumSource};
use crate::spectrum::features::features;
use crate::spectrum::format::{self, Format, Reading};
use crate::spectrum::resample::{Response, resampling_error};
use crate::spectrum::{self, Quantity, Spectrum, SpectrumError};
use crate::support::error::Error;
use crate::support::output;

/// Lists, shows, plots, converts and checks spectra
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// The shipped spectra
    List,
    /// What a spectrum is, what it holds, and its features
    Show(Input),
    /// A chart of one spectrum or several
    Plot {
        #[command(flatten)]
        input: Input,
        /// Chart to write: a .svg or .png file
        #[arg(long, short, value_name = "FILE")]
        out: PathBuf,
    },
    /// Writes spectra in another format or on other wavelengths, and says what that costs
    Convert(Convert),
    /// Reads files as a scene would, and says what is in them and what speaks against it
    Check(Input),
}

/// The spectra, and how files of them are read.
#[derive(clap::Args)]
struct Input {
    /// A shipped spectrum's name, fresnel:CONSTANTS, inverted: before a powder's, or a file: ECOSTRESS or ASTER
    /// text, USGS splib07 text, ENVI .sli, DIRSIG .ems, two columns of text
    #[arg(required = true, value_name = "SPECTRUM")]
    spectra: Vec<String>,
    /// Only the spectrum of this name, of a file that holds several
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// What the values are, where the file does not say
    #[arg(long, value_name = "QUANTITY")]
    quantity: Option<Quantity>,
    /// The file of wavelengths that belongs to USGS text
    #[arg(long, value_name = "FILE")]
    wavelengths: Option<PathBuf>,
    /// Only these wavelengths, um
    #[arg(long, value_name = "FROM-TO", value_parser = range)]
    range: Option<(f64, f64)>,
}

#[derive(clap::Args)]
struct Convert {
    #[command(flatten)]
    input: Input,
    /// File to write: .csv (one spectrum), .sli with its .hdr, or .ems
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Wavelengths at this distance, um; files keep their own without it, others have 0.01
    #[arg(long, value_name = "UM")]
    step: Option<f64>,
    /// Means over bands with a triangular slit of this full width at half maximum, um
    #[arg(long, value_name = "UM", requires = "step", value_parser = width)]
    width: Option<f64>,
    /// Means over the bands of a sensor: response functions, two columns (um, response) each
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["step", "width"])]
    response: Vec<PathBuf>,
}

fn width(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("it must be above 0".into()),
    }
}

pub fn run(args: &Args) -> Result<(), Error> {
    match &args.what {
        What::List => list(),
        What::Show(input) => show(input),
        What::Plot { input, out } => chart(input, out),
        What::Convert(convert) => convert.run(),
        What::Check(input) => check(input),
    }
}

impl Input {
    /// Reads all, with a margin around the range, um.
    fn read(&self, margin_um: f64) -> Result<Vec<Spectrum>, Error> {
        let mut all = Vec::new();
        for text in &self.spectra {
            all.extend(self.read_one(text, margin_um)?);
        }
        Ok(all)
    }

    fn read_one(&self, text: &str, margin_um: f64) -> Result<Vec<Spectrum>, Error> {
        let source = spectrum_source(text);
        let SpectrumSource::File(path) = &source else {
            return Ok(vec![Spectrum::resolve(&source, Path::new(""))?]);
        };
        let reading = Reading {
            quantity: self.quantity,
            wavelengths: self.wavelengths.clone(),
            range_um: self.range.map(|(from, to)| [from - margin_um, to + margin_um]),
            is_response: false,
        };
        let mut spectra = format::read(path, &reading)?;
        if let Some(name) = &self.name {
            let names: Vec<String> = spectra.iter().filter_map(|s| s.name.clone()).collect();
            spectra.retain(|spectrum| spectrum.name.as_deref() == Some(name));
            if spectra.is_empty() {
                usage(&format!("{text} holds no spectrum {name:?}, but {}", names.join(", ")));
            }
        }
        Ok(spectra.into_iter().map(Spectrum::Tabulated).collect())
    }
}

fn list() -> Result<(), Error> {
    let mut text = String::new();
    for shipped in spectrum::all() {
        let name = match &shipped {
            Spectrum::Fresnel(constants, _) => format!("fresnel:{constants}"),
            _ => shipped.name().to_owned(),
        };
        let _ = writeln!(text, "{name:<32}{}", what_it_is(&shipped));
    }
    print(&text)
}

/// What a spectrum is and how far it goes, in one line.
fn what_it_is(spectrum: &Spectrum) -> String {
    match spectrum {
        Spectrum::Constant(value) => format!("{value} at every wavelength"),
        Spectrum::Builtin(_, form) => {
            let p = &form.parameters;
            format!(
                "{}; {} numbers fitted, RMS {} ({} on a sample not fitted), {}-{} um",
                p.title,
                p.fitted.len(),
                p.rms,
                p.rms_other_sample,
                p.range_um[0],
                p.range_um[1]
            )
        }
        Spectrum::Fresnel(_, crystal) => format!(
            "{}; specular facets, nothing fitted, {}-{} um",
            crystal.title, crystal.range_um[0], crystal.range_um[1]
        ),
        Spectrum::Tabulated(points) => {
            let [from, to] = points.range_um();
            format!("{} points, {from}-{to} um", points.wavelength_um.len())
        }
        Spectrum::Inverted(powder, _) => {
            format!("facets of a bed that has: {}", what_it_is(powder))
        }
    }
}

fn describe(spectrum: &Spectrum) -> String {
    let mut text = format!("{}\n  {}\n", spectrum.name(), what_it_is(spectrum));
    match spectrum {
        Spectrum::Builtin(_, form) => {
            let _ = writeln!(text, "  source: {}", form.parameters.citation);
        }
        Spectrum::Fresnel(_, crystal) => {
            let _ = writeln!(text, "  source: {}", crystal.citation);
            text += "  what follows is the hemispherical emissivity of one facet\n";
        }
        Spectrum::Tabulated(points) => {
            let _ = writeln!(text, "  file: {}", points.file);
            for [from, to] in &points.gaps_um {
                let _ = writeln!(text, "  no values between {from} and {to} um");
            }
            for warning in &points.warnings {
                let _ = writeln!(text, "  warning: {warning}");
            }
        }
        Spectrum::Inverted(_, pure_bed) => {
            let _ = writeln!(
                text,
                "  pure bed: {}, standard error {:.4}",
                pure_bed.title, pure_bed.standard_error
            );
        }
        Spectrum::Constant(_) => {}
    }
    text
}

fn show(input: &Input) -> Result<(), Error> {
    let mut text = String::new();
    for spectrum in input.read(0.0)? {
        text += &describe(&spectrum);
        let um = wavelengths(&spectrum, input.range)?;
        let emissivity = format::sampled(&spectrum, &um)?;
        let found = features(&um, &emissivity);
        for (what, mean) in [
            ("mean over 8-9.5 um", found.mean_8_to_9p5_um),
            ("mean over 10-12 um", found.mean_10_to_12_um),
        ] {
            if let Some(mean) = mean {
                let _ = writeln!(text, "  {what}: {mean:.4}");
            }
        }
        for extremum in found.extrema() {
            let _ = writeln!(
                text,
                "  extremum of quartz: {:.4} at {:.3} um",
                extremum.emissivity, extremum.wavelength_um
            );
        }
    }
    print(&text)
}

fn chart(input: &Input, out: &Path) -> Result<(), Error> {
    let format = ChartFormat::of(out);
    let Drawn { curves, mut caption, credit } =
        drawn(&input.spectra, &input.read(0.0)?, input.range)?;
    caption.extend(credit);
    let title = "Emissivity".into();
    let hatched_um = Vec::new();
    let svg = plot::emissivity_svg(&Chart { title, caption, curves, hatched_um })?;
    format.write(&svg, out)
}

/// Spectra as a chart shows them.
pub(super) struct Drawn {
    pub curves: Vec<Curve>,
    /// A line for each.
    pub caption: Vec<String>,
    /// What the library asks for, if one is of a library.
    pub credit: Option<String>,
}

/// The curves of spectra, and of which words they were given by.
pub(super) fn drawn(
    given: &[String],
    spectra: &[Spectrum],
    range_um: Option<(f64, f64)>,
) -> Result<Drawn, Error> {
    let mut drawn = Drawn { curves: Vec::new(), caption: Vec::new(), credit: None };
    for spectrum in spectra {
        let wavelength_um = wavelengths(spectrum, range_um)?;
        let emissivity = format::sampled(spectrum, &wavelength_um)?;
        let half_width = vec![0.0; emissivity.len()];
        let label = spectrum.name().into();
        drawn.curves.push(Curve { label, wavelength_um, emissivity, half_width });
        drawn.caption.push(match spectrum {
            Spectrum::Fresnel(..) => format!("{spectrum}: hemispherical emissivity of one facet."),
            _ => format!("{spectrum}."),
        });
    }
    let of_library = |text: &String| match spectrum_source(text) {
        SpectrumSource::File(path) => Format::of(&path).is_ok_and(|of| of == Format::Ecostress),
        _ => false,
    };
    drawn.credit = given.iter().any(of_library).then(|| format::ECOSTRESS_CREDIT.into());
    Ok(drawn)
}

/// A file's own wavelengths within a range, else every 10 nm of it.
fn wavelengths(spectrum: &Spectrum, range: Option<(f64, f64)>) -> Result<Vec<f64>, SpectrumError> {
    if let (Spectrum::Tabulated(points), None) = (spectrum, range) {
        return Ok(points.wavelength_um.clone());
    }
    let (from, to) =
        range.unwrap_or_else(|| spectrum.range_um().map_or(Grid::PAPER.range_um(), Into::into));
    if let Spectrum::Tabulated(points) = spectrum {
        let within = |um: &f64| (from..=to).contains(um);
        let inside: Vec<f64> = points.wavelength_um.iter().copied().filter(within).collect();
        if !inside.is_empty() {
            return Ok(inside);
        }
    }
    spectrum.covers([from, to])?;
    Ok(Grid::new(from, to, 0.01).unwrap_or_else(|problem| usage(&problem)).wavelengths_um())
}

fn check(input: &Input) -> Result<(), Error> {
    let mut text = String::new();
    for given in &input.spectra {
        let spectra = match input.read_one(given, 0.0) {
            Ok(spectra) => spectra,
            Err(error) => {
                // What was found before stands.
                print(&text)?;
                return Err(error);
            }
        };
        if let SpectrumSource::File(path) = spectrum_source(given) {
            let _ = writeln!(text, "{given}: {}", Format::of(&path)?.name());
        }
        for spectrum in &spectra {
            text += &describe(spectrum);
            if let Spectrum::Tabulated(points) = spectrum
                && let Some((error, um)) = points.sampling_error(points.range_um())
            {
                let _ = writeln!(
                    text,
                    "  straight lines between its points miss it by about {error:.1e}, the most near {um} um"
                );
            }
        }
    }
    print(&text)
}

impl Convert {
    fn run(&self) -> Result<(), Error> {
        let files = self.input.spectra.iter().filter_map(|text| file_of(text));
        let files = files.chain(self.response.iter().map(PathBuf::as_path));
        let read = files.flat_map(format::files);
        output::keeps(read, [self.out.clone(), self.out.with_extension("hdr")])?;
        let spectra = self.input.read(self.width.unwrap_or(0.0))?;
        for spectrum in &spectra {
            if let Spectrum::Tabulated(points) = spectrum {
                for warning in &points.warnings {
                    eprintln!("warning: {}: {warning}", points.file);
                }
            }
        }
        let (wavelength_um, curves) = if self.response.is_empty() {
            self.on_grid(&spectra)?
        } else {
            self.in_bands(&spectra)?
        };
        let names = spectra.iter().map(|spectrum| spectrum.name().to_owned());
        format::write(&self.out, &wavelength_um, &names.zip(curves).collect::<Vec<_>>())
    }

    /// By point or by slit.
    fn on_grid(&self, spectra: &[Spectrum]) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let um = match self.step {
            Some(step) => self.grid(spectra, step),
            None => wavelengths(&spectra[0], self.input.range)?,
        };
        let mut curves = Vec::new();
        for spectrum in spectra {
            if self.step.is_none()
                && let Spectrum::Tabulated(points) = spectrum
            {
                if wavelengths(spectrum, self.input.range)? != um {
                    usage(
                        "the spectra have different wavelengths: give them common ones by --step",
                    );
                }
                // No format that is written can say that values are missing.
                let within = |gap: &&[f64; 2]| um[0] < gap[1] && gap[0] < um[um.len() - 1];
                if let Some(&gap_um) = points.gaps_um.iter().find(within) {
                    let needed_um = f64::midpoint(gap_um[0], gap_um[1]);
                    let of = points.file.clone();
                    return Err(SpectrumError::Gap { of, needed_um, gap_um }.into());
                }
            }
            let at_points = format::sampled(spectrum, &um)?;
            let curve = match self.width {
                None => at_points,
                Some(width) => {
                    let bands = um.iter().map(|&um| Response::triangle(um, width));
                    let means = bands
                        .map(|band| band.band_mean(spectrum))
                        .collect::<Result<Vec<f64>, _>>()?;
                    say_what_bands_differ(spectrum, &um, &means)?;
                    means
                }
            };
            if self.step.is_some() && um.len() > 1 {
                let error = resampling_error(spectrum, &um, &curve)?;
                eprintln!(
                    "{}: resampling error RMS {:.2e}, largest {:+.2e} at {} um",
                    spectrum.name(),
                    error.rms,
                    error.largest,
                    error.at_um
                );
            }
            curves.push(curve);
        }
        Ok((um, curves))
    }

    /// The range, else what all spectra hold, less the reach of a slit at both ends.
    fn grid(&self, spectra: &[Spectrum], step: f64) -> Vec<f64> {
        let margin = self.width.unwrap_or(0.0);
        let (from, to) = self.input.range.unwrap_or_else(|| {
            let ranges = spectra.iter().filter_map(Spectrum::range_um);
            let [from, to] = ranges
                .reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])])
                .map_or(Grid::PAPER.range_um().into(), |[from, to]| [from + margin, to - margin]);
            ((from / step).ceil() * step, to)
        });
        Grid::new(from, to, step).unwrap_or_else(|problem| usage(&problem)).wavelengths_um()
    }

    /// By the bands of a sensor, at their centroids.
    fn in_bands(&self, spectra: &[Spectrum]) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let mut bands: Vec<Response> =
            self.response.iter().map(|path| Response::read(path)).collect::<Result<_, _>>()?;
        bands.sort_by(|a, b| a.centre_um().total_cmp(&b.centre_um()));
        let um: Vec<f64> = bands.iter().map(Response::centre_um).collect();
        let mut curves = Vec::new();
        for spectrum in spectra {
            let means =
                bands.iter().map(|b| b.band_mean(spectrum)).collect::<Result<Vec<_>, _>>()?;
            say_what_bands_differ(spectrum, &um, &means)?;
            curves.push(means);
        }
        Ok((um, curves))
    }
}

fn say_what_bands_differ(
    spectrum: &Spectrum,
    um: &[f64],
    means: &[f64],
) -> Result<(), SpectrumError> {
    let points = format::sampled(spectrum, um)?;
    let differences = means.iter().zip(&points).map(|(mean, point)| mean - point);
    let largest = differences.zip(um).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    if let Some((difference, um)) = largest {
        eprintln!(
            "{}: a band's mean differs from the value at its centre by {difference:+.2e} at most, at \
             {um} um",
            spectrum.name()
        );
    }
    Ok(())
}
