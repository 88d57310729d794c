//! Pictures of beds and grains, drawn without a graphics card.
//!
//! | part | module |
//! |---|---|
//! | parallel projections | `camera` |
//! | which triangle is seen where | `visible` |
//! | what stands before the camera, what it sees | `stage` |
//! | sun, sky and shadows | `light` |

mod camera;
mod light;
mod stage;
mod visible;

use std::path::Path;

use glam::DVec3;

use crate::error::Error;
use crate::geometry::Bed;
use crate::output;
use crate::tracer::Footprint;
use camera::Camera;
use light::Lights;
use stage::Stage;

/// Pixels along the longer side.
const LONGER_SIDE: f64 = 640.0;
/// Colours of the materials in their order, and again from the first: pale dust, amber grain, grey
/// floor first, since shipped scenes have them so.
const COLOURS: [[f32; 3]; 6] = [
    [0.93, 0.88, 0.78],
    [0.76, 0.52, 0.27],
    [0.35, 0.36, 0.40],
    [0.45, 0.62, 0.55],
    [0.55, 0.50, 0.72],
    [0.80, 0.45, 0.45],
];
const BACKGROUND: [f32; 3] = [0.12, 0.15, 0.20];

/// Draws the sensor's view of a bed as a PNG file.
pub fn write(bed: &Bed, path: &Path) -> Result<(), Error> {
    let t = std::time::Instant::now();
    let Footprint { corner, right, up } = Footprint::new(&bed.domain, bed.to_sensor);
    let camera = Camera { corner, right, up, to_eye: bed.to_sensor };
    let [dx, dy] = camera.size_um();
    let pixel_um = dx.max(dy) / LONGER_SIDE;
    let size = [dx, dy].map(|um| ((um / pixel_um).round() as usize).max(1));
    let stage = Stage::of_sensor(bed);
    let pieces = stage.look(&camera, size, 2)?;
    eprintln!("look {:?} {}", t.elapsed(), pieces.len());
    let n: usize = std::env::var("N").map(|n| n.parse().unwrap()).unwrap_or(15);
    let lights = Lights::new(DVec3::new(-0.5, 0.35, 0.75).normalize(), n);
    let light = lights.on(&pieces, &stage, pixel_um)?;
    eprintln!("light {:?}", t.elapsed());
    let mut rgb = vec![[0f32; 3]; size[0] * size[1]];
    let mut left = vec![1f32; size[0] * size[1]];
    for (piece, light) in pieces.iter().zip(light) {
        let colour = COLOURS[usize::from(piece.material) % COLOURS.len()];
        for c in 0..3 {
            rgb[piece.pixel][c] += piece.share * (light * colour[c].powf(2.2)).min(1.0);
        }
        left[piece.pixel] -= piece.share;
    }
    let bytes: Vec<u8> = rgb
        .iter()
        .zip(&left)
        .flat_map(|(p, &l)| {
            let mut q = [0u8; 3];
            for c in 0..3 {
                q[c] = (255.0 * (p[c] + l.max(0.0) * BACKGROUND[c].powf(2.2)).powf(1.0 / 2.2))
                    .round() as u8
            }
            q
        })
        .collect();
    eprintln!("shade {:?}", t.elapsed());
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&bytes));
    written.expect("writing to memory does not fail");
    eprintln!("png {:?}", t.elapsed());
    output::bytes(path, &file)?;
    Ok(())
}
