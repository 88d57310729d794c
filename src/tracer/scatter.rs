//! How a facet scatters a path: in one or several directions, independent of wavelength.

use glam::{DMat3, DVec2, DVec3};

use crate::histogram::kept::PARTS;
use crate::support::math;
use crate::tracer::field::Ray;
use crate::tracer::rules::Facet;

/// The scatter of a path at a facet.
pub(crate) struct Scatter {
    /// The incident ray.
    ray: Ray,
    point: DVec3,
    facet: Facet,
    /// The tangent, the bitangent and the normal.
    frame: DMat3,
    /// The first direction: a share of the specular part and of the disc below the normal, and the
    /// place on the circle.
    share: f64,
    on_circle: DVec2,
}

impl Scatter {
    pub(crate) fn new(
        ray: Ray,
        point: DVec3,
        facet: Facet,
        normal: DVec3,
        [share, turn]: [f64; 2],
    ) -> Self {
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let frame = DMat3::from_cols(tangent, bitangent, normal);
        // glam's own `from_angle` would call the system's sine.
        let (sin, cos) = math::sin_cos(std::f64::consts::TAU * turn);
        let on_circle = DVec2::new(cos, sin);
        Self { ray, point, facet, frame, share, on_circle }
    }

    /// The ray of a number below [`PARTS`]. The rays lie on a Fibonacci lattice in share and turn.
    pub(crate) fn ray(&self, number: u64) -> Ray {
        /// Cosine and sine of no, one and two fifths of a turn.
        const FIFTHS: [DVec2; 3] = [
            DVec2::new(1.0, 0.0),
            DVec2::new(0.309_016_994_374_947_45, 0.951_056_516_295_153_5),
            DVec2::new(-0.809_016_994_374_947_5, 0.587_785_252_292_473_1),
        ];
        const { assert!(PARTS == 5) };
        let share = self.share + number as f64 / PARTS as f64;
        let share = if share < 1.0 { share } else { share - 1.0 };
        let turn = match 2 * number % PARTS {
            fifths @ 0..3 => FIFTHS[fifths as usize],
            fifths => FIFTHS[(PARTS - fifths) as usize] * DVec2::new(1.0, -1.0),
        };
        let mut ray = self.ray;
        ray.origin = self.point;
        ray.direction = self.reflected(share, turn.rotate(self.on_circle));
        ray
    }

    /// A direction of the scatter. The share selects the specular or the Lambertian part; its rest
    /// serves the Lambertian part.
    fn reflected(&self, share: f64, on_circle: DVec2) -> DVec3 {
        let specular = self.facet.specular;
        if share < specular {
            let (direction, normal) = (self.ray.direction, self.frame.z_axis);
            return (direction - 2.0 * direction.dot(normal) * normal).normalize();
        }
        self.frame * cosine_direction((share - specular) / (1.0 - specular), on_circle)
    }
}

/// A direction about the z axis with density cos / pi, above a point of the disc below it. `share`
/// is the share of the disc nearer to the middle, below 1.
fn cosine_direction(share: f64, on_circle: DVec2) -> DVec3 {
    // The share is below 1, so the direction never lies in the surface.
    (share.sqrt() * on_circle).extend((1.0 - share).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Bed, Domain};
    use crate::scene::Sides;
    use crate::support::random::{Purpose, Source};
    use crate::tracer::field::Field;

    /// The five directions of a facet on the disc below the normal: the share of the disc nearer to
    /// its middle, and the share of a turn.
    fn on_disc(normal: DVec3, numbers: [f64; 2]) -> [[f64; 2]; PARTS as usize] {
        let bed = Bed {
            meshes: Vec::new(),
            placements: Vec::new(),
            repeated: 0,
            domain: Domain::new(DVec3::ZERO, DVec3::ONE, Sides::Open),
            to_sensor: DVec3::Z,
            materials: 1,
        };
        let ray = Field::new(&bed, Sides::Open).start([0.5; 2], || [0.0; 2]);
        let scatter = Scatter::new(ray, DVec3::ZERO, Facet::LAMBERTIAN, normal, numbers);
        let (right, up) = normal.any_orthonormal_pair();
        std::array::from_fn(|number| {
            let direction = scatter.ray(number as u64).direction;
            let across = DVec2::new(direction.dot(right), direction.dot(up));
            assert!((direction.length() - 1.0).abs() < 1e-12 && direction.dot(normal) > 0.0);
            let turn = across.to_angle() / std::f64::consts::TAU;
            [across.length_squared(), turn.rem_euclid(1.0)]
        })
    }

    /// The difference of two shares of a turn, from 0 to 1.
    fn onward(from: f64, to: f64) -> f64 {
        (to - from).rem_euclid(1.0)
    }

    /// A path goes on along the first direction in place of any that is blocked. That is right if
    /// all five are alike: from each the others lie as they lie from the first.
    #[test]
    fn the_five_directions_of_a_first_hit_are_alike() {
        let mut random = Source::new(1, Purpose::Result).stream(0);
        for _ in 0..100 {
            let ([share, turn], [z, around]) = (random.pair(), random.pair());
            let level = (1.0 - z * z).sqrt() * DVec2::from_angle(6.3 * around);
            let of = on_disc(level.extend(z), [share, turn]);
            let [shares, turns] = [0, 1].map(|axis| of.map(|at| at[axis]));
            assert!((shares[0] - share).abs() < 1e-9, "the first lies where the numbers say");
            assert!((onward(turn, turns[0] + 0.5) - 0.5).abs() < 1e-9);
            for from in 0..PARTS as usize {
                for step in 1..PARTS as usize {
                    let to = (from + step) % PARTS as usize;
                    for (of, fifths) in [(shares, step), (turns, 2 * step % PARTS as usize)] {
                        let (found, expected) = (onward(of[from], of[to]), fifths as f64 / 5.0);
                        assert!((found - expected).abs() < 1e-9, "{from} to {to}: {found}");
                    }
                }
            }
        }
    }
}
