//! Closest hits per second of soilsig and of Embree's single rays, one thread each. The rays are
//! those of paths through a settled bed of dusty grains. `benches/embree/run.sh` starts it.

#![allow(clippy::disallowed_methods, reason = "no result depends on it")]

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::Command;

use glam::{DVec3, Vec3};
use nix::time::{ClockId, clock_gettime};
use soilsig::geometry::{Bed, ingest};
use soilsig::scene::Scene;
use soilsig::support::random::{Purpose, Source};
use soilsig::tracer::bvh::{Accelerator, Hit};

/// Paths whose rays are traced; about ten rays each.
const PATHS: u64 = 100_000;
/// Most rays of a path.
const LONGEST: usize = 128;
/// Runs of each, in turn.
const RUNS: usize = 5;
/// The distance of a ray's start from its facet, um: more than the rounding of single precision,
/// which is all that Embree has, in a bed of some millimetres.
const OFF_UM: f64 = 0.01;

/// A ray in single precision relative to the middle of the domain, so that both trace the same.
struct Ray {
    origin: Vec3,
    direction: Vec3,
    t_max: f32,
}

struct Bench {
    bed: Bed,
    accelerator: Accelerator,
    middle: DVec3,
}

fn main() -> io::Result<()> {
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    let (Some(scene), Some(embree)) = (arguments.next(), arguments.next()) else {
        println!("benches/embree/run.sh gives this a placed scene and the program to compare with");
        return Ok(());
    };
    let path = Path::new(&scene);
    let bed = ingest::load(&Scene::read(path).expect("a scene")).expect("sound meshes");
    let (resident, started) = (resident_bytes()?, cpu_seconds());
    let accelerator = Accelerator::new(&bed);
    let built = (resident_bytes()? - resident, cpu_seconds() - started);
    let middle = (bed.domain.min_um + bed.domain.max_um) / 2.0;
    let bench = Bench { bed, accelerator, middle };
    let rays: Vec<Ray> = (0..PATHS).flat_map(|number| bench.path(number)).collect();
    let folder = tempfile::tempdir()?;
    let dump = folder.path().join("scene");
    bench.write(&rays, BufWriter::new(File::create(&dump)?))?;

    let mut rates = [Vec::new(), Vec::new(), Vec::new()];
    let mut said = [[0.0; 5]; 2];
    for _ in 0..RUNS {
        let started = cpu_seconds();
        let hits = rays.iter().filter(|ray| bench.closest(ray).is_some()).count();
        rates[0].push(rays.len() as f64 / (cpu_seconds() - started));
        for (i, kind) in ["fast", "robust"].iter().enumerate() {
            let output = Command::new(&embree).arg(&dump).arg(kind).output()?;
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let text = String::from_utf8(output.stdout).expect("UTF-8");
            let numbers: Vec<f64> =
                text.split_whitespace().map(|n| n.parse().expect("a number")).collect();
            said[i] = numbers.try_into().expect("five numbers");
            rates[i + 1].push(said[i][0]);
            assert!((said[i][1] - hits as f64).abs() < 1e-4 * hits as f64, "{hits} hits, {text}");
        }
    }

    println!(
        "{} rays of {PATHS} paths; {} placements, {} triangles by instances",
        rays.len(),
        bench.bed.placements.len(),
        bench.bed.triangles()
    );
    println!(
        "| closest hits, one thread | M rays/s, median | range | ratio to Embree fast | other hit than ours | tree, MB | built, CPU s |"
    );
    println!("|---|---|---|---|---|---|---|");
    for rates in &mut rates {
        rates.sort_by(f64::total_cmp);
    }
    let embree = rates[1][RUNS / 2];
    let names = ["soilsig", "Embree, fast", "Embree, robust"];
    for (i, (name, rates)) in names.iter().zip(&rates).enumerate() {
        let (other, (bytes, seconds)) = match i {
            0 => (0.0, built),
            _ => (said[i - 1][2], (said[i - 1][3], said[i - 1][4])),
        };
        println!(
            "| {name} | {:.3} | {:.3}-{:.3} | {:.3} | {:.1e} | {:.1} | {seconds:.2} |",
            rates[RUNS / 2] / 1e6,
            rates[0] / 1e6,
            rates[RUNS - 1] / 1e6,
            rates[RUNS / 2] / embree,
            other / rays.len() as f64,
            bytes / 1e6
        );
    }
    Ok(())
}

impl Bench {
    /// The rays of one path from above: mirror sides, cosine-weighted scatter from every facet.
    fn path(&self, number: u64) -> Vec<Ray> {
        let mut random = Source::new(1, Purpose::Result).stream(number);
        let domain = &self.bed.domain;
        let (min, max) = (domain.min_um, domain.max_um);
        let [u, v] = random.pair();
        let mut origin = DVec3::new(u, v, 1.0) * (max - min) + min;
        let mut direction = -DVec3::Z;
        let mut rays = Vec::new();
        while rays.len() < LONGEST {
            let wall = DVec3::select(direction.cmpgt(DVec3::ZERO), max, min);
            let exits = (wall - origin) / direction;
            let exits = DVec3::select(direction.cmpeq(DVec3::ZERO), DVec3::INFINITY, exits);
            let t_max = exits.max(DVec3::ZERO).min_element();
            let ray = Ray {
                origin: (origin - self.middle).as_vec3(),
                direction: direction.as_vec3().normalize(),
                t_max: t_max as f32,
            };
            let hit = self.closest(&ray);
            rays.push(ray);
            if let Some(hit) = hit {
                let place = &self.bed.placements[hit.placement];
                let mesh = &self.bed.meshes[place.mesh];
                let [a, b, c] = mesh.triangles[hit.triangle]
                    .map(|i| place.to_scene.transform_point3(mesh.vertices[i as usize].as_dvec3()));
                let outward = (b - a).cross(c - a).normalize();
                let normal = if outward.dot(direction) > 0.0 { -outward } else { outward };
                origin += hit.t * direction + OFF_UM * normal;
                let [u, v] = random.pair();
                let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
                let (tangent, other) = normal.any_orthonormal_pair();
                direction = u.sqrt() * (cos * tangent + sin * other) + (1.0 - u).sqrt() * normal;
            } else {
                // The ray reaches the sky, passes the floor, or is reflected by a side.
                let axis = exits.min_position();
                if axis == 2 {
                    break;
                }
                origin += t_max * direction;
                direction[axis] = -direction[axis];
            }
        }
        rays
    }

    #[inline]
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let origin = ray.origin.as_dvec3() + self.middle;
        self.accelerator.closest(origin, ray.direction.as_dvec3().normalize(), ray.t_max.into())
    }

    /// The input of `closest_hits.c`.
    fn write(&self, rays: &[Ray], mut file: impl Write) -> io::Result<()> {
        let mut words =
            |words: &[u32]| words.iter().try_for_each(|word| file.write_all(&word.to_ne_bytes()));
        let Bed { meshes, placements, .. } = &self.bed;
        words(&[meshes.len() as u32, placements.len() as u32, rays.len() as u32])?;
        for mesh in meshes {
            words(&[mesh.vertices.len() as u32, mesh.triangles.len() as u32])?;
            words(bytemuck::cast_slice(&mesh.vertices))?;
            words(bytemuck::cast_slice(&mesh.triangles))?;
        }
        for place in placements {
            let mut to_scene = place.to_scene;
            to_scene.translation -= self.middle;
            words(&[place.mesh as u32])?;
            words(&to_scene.to_cols_array().map(|x| (x as f32).to_bits()))?;
        }
        for ray in rays {
            words(&ray.origin.to_array().map(f32::to_bits))?;
            words(&ray.direction.to_array().map(f32::to_bits))?;
            let hit = self.closest(ray);
            let (t, placement, triangle) = hit.map_or((0.0, u32::MAX, 0), |h| {
                (h.t as f32, h.placement as u32, h.triangle as u32)
            });
            words(&[ray.t_max.to_bits(), t.to_bits(), placement, triangle])?;
        }
        file.flush()
    }
}

fn cpu_seconds() -> f64 {
    let now = clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).expect("a clock");
    now.tv_sec() as f64 + 1e-9 * now.tv_nsec() as f64
}

fn resident_bytes() -> io::Result<f64> {
    let pages = std::fs::read_to_string("/proc/self/statm")?;
    Ok(4096.0 * pages.split(' ').nth(1).and_then(|n| n.parse::<f64>().ok()).expect("a number"))
}
