//! Radiance of quartz under a sky with lines, and the noise of a sensor.

use std::f64::consts::TAU;

use soilsig::radiometry::{Measured, l_target, planck};

/// Made-up lines of a humid sky: centres by a fixed rule, crowded where water vapour (below 8 um,
/// above 12), ozone (9.4 to 9.9) and carbon dioxide (above 13) have theirs; air at 280 K.
pub fn l_sky(um: f64) -> f64 {
    let mut depth = 0.08 * (um / 10.0).powi(2);
    for line in 0..220_u32 {
        let (a, b) = (part(line, 0.618_034), part(line, 0.754_878));
        let (centre, strength) = match line % 4 {
            0 => (7.2 + 0.9 * a, 1.2),
            1 => (12.0 + 2.1 * a, 0.8),
            2 => (9.4 + 0.5 * a, 0.5),
            _ => (7.2 + 6.9 * a, 0.15),
        };
        let width = 0.012;
        depth += strength * b * width * width / ((um - centre).powi(2) + width * width);
    }
    planck(um, 280.0) * -(-depth).exp_m1()
}

fn part(number: u32, step: f64) -> f64 {
    (f64::from(number) * step).fract()
}

/// Normally distributed numbers, the same for the same seed (splitmix64 and Box-Muller).
pub struct Noise(pub u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

/// What a spectrometer measures of a target of these emissivities, with noise as a difference in
/// temperature (NEdT), K.
pub fn measured(
    emissivity: &[(f64, f64)],
    temperature_k: f64,
    l_sky: impl Fn(f64) -> f64,
    nedt_k: f64,
    noise: &mut Noise,
) -> Vec<Measured> {
    let band = |&(um, e): &(f64, f64)| {
        let l_downwelling = l_sky(um);
        let l = l_target(e * planck(um, temperature_k), (1.0 - e) * l_downwelling);
        let nedl = planck(um, temperature_k + nedt_k) - planck(um, temperature_k);
        Measured::at_sensor(um, [l + nedl * noise.normal(), nedl], l_downwelling, None)
    };
    emissivity.iter().map(band).collect()
}
