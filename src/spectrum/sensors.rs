//! Sensors by name, with nominal bands from the literature, and sensors by files of responses.
//!
//! Nominal bands are boxes or Gaussian curves by centre and width. They stand in for measured
//! responses, which a file gives.

use std::path::Path;

use super::SpectrumError;
use super::format::wavelength_unit;
use super::resample::Response;
use crate::support::file_error::FileError;
use crate::support::text;

/// A sensor: its bands in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Its name, or that of the file.
    pub name: String,
    /// Where its bands come from.
    pub source: String,
    /// The bands.
    pub bands: Vec<SensorBand>,
}

/// A band of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorBand {
    /// Its name: for known sensors the number by which its users call it.
    pub name: String,
    /// Its response.
    pub response: Response,
}

/// A sensor as the literature gives it.
struct Nominal {
    name: &'static str,
    source: &'static str,
    bands: Bands,
}

enum Bands {
    /// Constant responses: name, least and greatest wavelength, um.
    Boxes(&'static [(&'static str, f64, f64)]),
    /// Constant responses: name, centre and full width at half maximum, um.
    Widths(&'static [(&'static str, f64, f64)]),
    /// Gaussian responses whose centres are equally spaced.
    Grid { number: u32, first_um: f64, last_um: f64 },
}

/// The sensors that are known.
const KNOWN: [Nominal; 7] = [
    Nominal {
        name: "aster",
        source: "Yamaguchi et al., IEEE Trans. Geosci. Remote Sens. 36, 1062 (1998)",
        bands: Bands::Boxes(&[
            ("10", 8.125, 8.475),
            ("11", 8.475, 8.825),
            ("12", 8.925, 9.275),
            ("13", 10.25, 10.95),
            ("14", 10.95, 11.65),
        ]),
    },
    Nominal {
        name: "ecostress",
        source: "ECOSTRESS Level-2 land surface temperature and emissivity, algorithm description \
                 (Jet Propulsion Laboratory)",
        bands: Bands::Widths(&[
            ("1", 8.29, 0.354),
            ("2", 8.78, 0.310),
            ("3", 9.20, 0.396),
            ("4", 10.49, 0.410),
            ("5", 12.09, 0.611),
        ]),
    },
    Nominal {
        name: "landsat-tirs",
        source: "Landsat 8 Data Users Handbook (U.S. Geological Survey)",
        bands: Bands::Boxes(&[("10", 10.6, 11.19), ("11", 11.5, 12.51)]),
    },
    Nominal {
        name: "modis",
        source: "Barnes et al., IEEE Trans. Geosci. Remote Sens. 36, 1088 (1998)",
        bands: Bands::Boxes(&[
            ("29", 8.4, 8.7),
            ("30", 9.58, 9.88),
            ("31", 10.78, 11.28),
            ("32", 11.77, 12.27),
        ]),
    },
    Nominal {
        name: "master",
        source: "Hook et al., Remote Sens. Environ. 76, 93 (2001), rounded",
        bands: Bands::Widths(&[
            ("41", 7.76, 0.37),
            ("42", 8.17, 0.43),
            ("43", 8.63, 0.35),
            ("44", 9.09, 0.42),
            ("45", 9.70, 0.41),
            ("46", 10.12, 0.40),
            ("47", 10.63, 0.59),
            ("48", 11.33, 0.65),
            ("49", 12.12, 0.49),
            ("50", 12.88, 0.46),
        ]),
    },
    Nominal {
        name: "hytes",
        source: "Johnson et al., IEEE Aerospace Conference (2011): 256 channels over 7.5 to 12 um",
        bands: Bands::Grid { number: 256, first_um: 7.5, last_um: 12.0 },
    },
    Nominal {
        name: "sebass",
        source: "Hackwell et al., Proc. SPIE 2819, 102 (1996): 128 channels over 7.57 to 13.52 um",
        bands: Bands::Grid { number: 128, first_um: 7.57, last_um: 13.52 },
    },
];

/// The names of the sensors that are known.
pub fn names() -> [&'static str; 7] {
    KNOWN.each_ref().map(|known| known.name)
}

impl Sensor {
    /// A known sensor, or one whose responses are in a file.
    ///
    /// # Errors
    /// A file that cannot be used; a name that is neither known nor a file's.
    pub fn find(text: &str) -> Result<Self, SpectrumError> {
        let is = |known: &&Nominal| known.name.eq_ignore_ascii_case(text);
        match KNOWN.iter().find(is) {
            Some(known) => Ok(known.sensor()),
            None if text.contains(['.', '/']) => Self::read(Path::new(text)),
            None => Err(SpectrumError::Unknown {
                kind: "sensor",
                name: text.into(),
                known: names().into(),
            }),
        }
    }

    /// Reads responses from a CSV file: a column of wavelengths and one for each band, with the
    /// bands' names in the heading.
    ///
    /// # Errors
    /// No heading, no band, a field that is no number, wavelengths that do not ascend, a response
    /// that is below 0, not finite or 0 everywhere.
    pub fn read(path: &Path) -> Result<Self, SpectrumError> {
        let wrong = |problem: String| {
            FileError::wrong(path, problem).with_hint(
                "write a heading, wavelength_um,NAME,NAME, then a row for each wavelength",
            )
        };
        let text = text::read(path)?;
        let lines = (1..).zip(text.lines().map(str::trim));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let fields = |line: &'_ str| -> Vec<String> {
            line.split([',', ';', '\t']).map(|field| field.trim().to_owned()).collect()
        };
        let heading = fields(lines.next().ok_or_else(|| wrong("the file is empty".into()))?.1);
        if heading.len() < 2 || heading.iter().all(|field| field.parse::<f64>().is_ok()) {
            return Err(
                wrong("the first line is not a heading of two or more columns".into()).into()
            );
        }
        let unit = wavelength_unit(&heading[0]).ok_or_else(|| {
            wrong(format!("{:?} names no wavelength in a known unit", heading[0]))
        })?;
        // The name of a band may hold its wavelength.
        let is_other = |name: &&String| {
            wavelength_unit(name).is_some() && !name.contains(|c: char| c.is_ascii_digit())
        };
        if let Some(other) = heading[1..].iter().find(is_other) {
            return Err(wrong(format!("{other:?} is another column of wavelengths")).into());
        }
        let mut rows: Vec<(f64, Vec<f64>)> = Vec::new();
        for (number, line) in lines {
            let in_line = |problem: String| FileError::wrong_in_line(path, number, problem);
            let fields = fields(line);
            if fields.len() != heading.len() {
                let (has, needed) = (fields.len(), heading.len());
                return Err(in_line(format!("{has} fields, but the heading has {needed}")).into());
            }
            let number = |field: &String| {
                let number = field.parse::<f64>().ok().filter(|number| number.is_finite());
                number.ok_or_else(|| in_line(format!("{field:?} is not a number")))
            };
            let numbers: Vec<f64> = fields.iter().map(number).collect::<Result<_, _>>()?;
            if let Some(below) = numbers[1..].iter().find(|response| **response < 0.0) {
                return Err(in_line(format!("a response of {below} is below 0")).into());
            }
            rows.push((unit.um(numbers[0]), numbers[1..].to_vec()));
        }
        if rows.first().zip(rows.last()).is_some_and(|(first, last)| first.0 > last.0) {
            rows.reverse();
        }
        if rows.len() < 2 || !rows.windows(2).all(|pair| 0.0 < pair[0].0 && pair[0].0 < pair[1].0) {
            return Err(wrong("it needs two or more wavelengths that ascend".into()).into());
        }
        let band = |i: usize| {
            let name = heading[i + 1].clone();
            let points: Vec<_> = rows.iter().map(|(um, of)| (*um, of[i])).collect();
            let response = Response::of_points(&points);
            let response = response
                .ok_or_else(|| wrong(format!("the response of {name} is 0 at every wavelength")))?;
            Ok::<_, SpectrumError>(SensorBand { name, response })
        };
        let bands = (0..heading.len() - 1).map(band).collect::<Result<_, _>>()?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = stem.trim_end_matches(".srf").to_owned();
        Ok(Self { name, source: format!("responses in {}", path.display()), bands })
    }
}

impl Nominal {
    fn sensor(&self) -> Sensor {
        // Without rounding errors: a band may end where a spectrum does.
        let round = |um: f64| (um * 1e6).round() / 1e6;
        let boxed = |name: &str, from_um: f64, to_um: f64| SensorBand {
            name: name.into(),
            response: Response::boxed(round(from_um), round(to_um)),
        };
        let bands = match self.bands {
            Bands::Boxes(bands) => {
                bands.iter().map(|&(name, from, to)| boxed(name, from, to)).collect()
            }
            Bands::Widths(bands) => {
                let ends = |centre: f64, width: f64| (centre - width / 2.0, centre + width / 2.0);
                let of = |&(name, centre, width): &(&str, f64, f64)| {
                    let (from, to) = ends(centre, width);
                    boxed(name, from, to)
                };
                bands.iter().map(of).collect()
            }
            Bands::Grid { number, first_um, last_um } => {
                let step_um = (last_um - first_um) / f64::from(number - 1);
                let of = |i: u32| SensorBand {
                    name: (i + 1).to_string(),
                    response: Response::gaussian(first_um + step_um * f64::from(i), step_um),
                };
                (0..number).map(of).collect()
            }
        };
        Sensor { name: self.name.into(), source: format!("nominal, {}", self.source), bands }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sensors_have_their_bands_in_order_within_the_thermal_infrared() {
        for name in names() {
            let sensor = Sensor::find(name).expect("known");
            assert!(sensor.source.starts_with("nominal, "), "{name}");
            let centres: Vec<f64> =
                sensor.bands.iter().map(|band| band.response.centre_um()).collect();
            assert!(centres.is_sorted_by(|a, b| a < b), "{name}");
            assert!(centres.iter().all(|um| (7.4..13.6).contains(um)), "{name}");
        }
        let number = |name: &str| Sensor::find(name).expect("known").bands.len();
        assert_eq!(["aster", "landsat-tirs", "hytes", "sebass"].map(number), [5, 2, 256, 128]);
        let aster = Sensor::find("ASTER").expect("known");
        assert_eq!(aster.bands[3].name, "13");
        assert_eq!(aster.bands[3].response.span_um(), [10.25, 10.95]);
        let error = Sensor::find("asta").expect_err("unknown");
        assert_eq!(error.to_string(), "\"asta\" is not a shipped sensor");
    }

    #[test]
    fn responses_are_read_by_columns_and_what_is_wrong_is_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("mine.srf.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("written");
            Sensor::read(&path)
        };
        let text = "# measured\nwavelength_nm, A, B\n9000,1,0\n8500,1,0.5\n8000,0,1\n";
        let sensor = read(text).expect("sound");
        assert_eq!(sensor.name, "mine");
        let names: Vec<&str> = sensor.bands.iter().map(|band| &*band.name).collect();
        assert_eq!(names, ["A", "B"]);
        // A: a triangle of half the area beside a square.
        let centre = sensor.bands[0].response.centre_um();
        assert!((centre - (0.25 * (8.0 + 1.0 / 3.0) + 0.5 * 8.75) / 0.75).abs() < 1e-9, "{centre}");
        // The name of a band may hold its wavelength.
        assert_eq!(read("\u{3bb} (um),8.6 um\n8,1\n9,1\n").expect("sound").bands.len(), 1);
        for (text, words) in [
            ("", "the file is empty"),
            ("8,1\n9,1\n", "not a heading"),
            ("um,A\n8,1\n", "two or more wavelengths"),
            ("um,A\n8,1\n8,1\n", "ascend"),
            ("um,A\n8,1\n9,x\n", "line 3: \"x\" is not a number"),
            ("um,A\n8,1\n9\n", "line 3: 1 fields, but the heading has 2"),
            ("um,A\n8,1\n9,-1\n", "below 0"),
            ("um,A\n8,0\n9,0\n", "A is 0 at every wavelength"),
            ("band,A\n8,1\n9,1\n", "names no wavelength"),
            ("wavelength (cm),A\n8,1\n9,1\n", "names no wavelength"),
            ("um,nm,A\n8,8000,1\n9,9000,1\n", "another column of wavelengths"),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(error.contains(words), "{text:?}: {error}");
        }
    }
}
