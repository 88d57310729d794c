//! A pixel's histogram into its spectrum, in the bands of the image.

use super::bands::Bands;
use crate::histogram::kept::Kept;
use crate::histogram::{self, Histogram, LANES, Mean, Seen, Sums};
use crate::radiometry::Lit;

/// What an image's pixels are evaluated with.
pub(super) struct Evaluator<'a> {
    bands: &'a Bands,
    nodes: Vec<Node>,
    /// The nodes, so many at a time.
    lanes: Vec<histogram::Evaluator<LANES>>,
}

/// What lies before the sensor at one wavelength.
struct Node {
    transmittance: f64,
    l_path: f64,
    /// The greatest radiance at the sensor.
    brightest: f64,
}

/// A pixel's spectra.
pub(super) struct Spectra {
    /// Emissivity in each band.
    pub emissivity: Vec<Mean>,
    /// Radiance at the sensor in each band.
    pub l_sensor: Vec<Mean>,
}

impl<'a> Evaluator<'a> {
    /// For the nodes of the bands.
    pub(super) fn new(kept: Kept, lit: &[Lit], bands: &'a Bands) -> Self {
        let node = |lit: &Lit| {
            let l_path = lit.l_sensor(0.0);
            let brightest = lit.l_sensor(lit.sources().brightest());
            Node { transmittance: lit.l_sensor(1.0) - l_path, l_path, brightest }
        };
        let lanes = |lit: &[Lit]| {
            let of = |lane: usize| lit.get(lane).unwrap_or(&lit[0]).sources();
            histogram::Evaluator::new(kept, std::array::from_fn(of))
        };
        Self {
            bands,
            nodes: lit.iter().map(node).collect(),
            lanes: lit.chunks(LANES).map(lanes).collect(),
        }
    }

    /// The spectra of a pixel whose histogram is not empty.
    pub(super) fn spectra(&self, histogram: &Histogram) -> Spectra {
        let met = histogram.met();
        let seen: Vec<Seen> =
            self.lanes.iter().flat_map(|lanes| lanes.evaluate(histogram, &met)).collect();
        let in_band = |nodes: &Vec<(usize, f64)>| {
            let (mut weight, mut l, mut brightest) = (Sums::ZERO, Sums::ZERO, 0.0);
            for &(number, share) in nodes {
                let (node, seen) = (&self.nodes[number], &seen[number]);
                weight.add(&seen.weight, share, 0.0, &met);
                l.add(&seen.l_target, share * node.transmittance, share * node.l_path, &met);
                brightest += share * node.brightest;
            }
            let weight = weight.mean(&met, 1.0);
            (Mean { mean: 1.0 - weight.mean, ..weight }, l.mean(&met, brightest))
        };
        let (emissivity, l_sensor) = self.bands.weights.iter().map(in_band).unzip();
        Spectra { emissivity, l_sensor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Grid, Sensor, SensorBands};

    /// Bands of one wavelength as a bed is evaluated, and a wide one as their mean.
    #[test]
    fn a_pixel_is_evaluated_as_a_bed_is() {
        let lit = |um: f64| Lit {
            wavelength_um: um,
            reflectance: vec![0.1 + 0.05 * um, 0.3],
            l_blackbody_of: vec![9.0 - um / 4.0; 2],
            l_sky: vec![1.0 + 0.1 * um],
            l_blackbody: 9.0 - um / 4.0,
            l_downwelling: 0.0,
            path: Some((0.8, 0.5)),
        };
        let state = |number: u16| [1 + number % 3, number % 4].into();
        let counts = |number: u16| vec![(number % 7, 3), (7 + number % 9, i64::from(number) + 1)];
        let histogram = Histogram {
            kept: Kept::PLAIN,
            parts: 5,
            escaped: (0..30).map(|number| (state(number), counts(number))).collect(),
            given_up: vec![(state(31), counts(31))],
            rouletted: vec![(3, -4), (9, 6)],
        };
        let bands = vec![
            SensorBands::Grid { from_um: 8.0, to_um: 10.0, step_um: 0.1, fwhm_um: 0.02 },
            SensorBands::Box { centre_um: 9.0, width_um: 1.0 },
        ];
        let sensor = Sensor { pixels: [1, 1], bands: Some(bands), ..Sensor::default() };
        let bands = crate::products::image::bands::bands(Some(&sensor), "".as_ref(), &Grid::PAPER)
            .expect("bands");
        let lit: Vec<Lit> = bands.nodes_um.iter().map(|&um| lit(um)).collect();
        let spectra = Evaluator::new(Kept::PLAIN, &lit, &bands).spectra(&histogram);
        for (band, weights) in bands.weights.iter().enumerate() {
            let (mut emissivity, mut l, mut open) = (0.0, 0.0, 0.0);
            for &(node, share) in weights {
                let (of_node, radiance) = lit[node].seen(&histogram);
                emissivity += share * of_node.mean;
                l += share * lit[node].l_sensor(radiance.l_target.mean);
                open += share * 0.8 * radiance.l_target.trapped;
            }
            assert!((spectra.emissivity[band].mean - emissivity).abs() < 1e-12, "band {band}");
            assert!((spectra.l_sensor[band].mean - l).abs() < 1e-12);
            assert!((spectra.l_sensor[band].trapped - open).abs() < 1e-12);
        }
    }
}
