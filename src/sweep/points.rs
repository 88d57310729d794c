//! The points of a study.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde_json::Value;

use super::study::{Axis, FACETS, MOST_POINTS, Method, Sample, Study, StudyError, facets};
use crate::scene::{Change, Scene, SceneGeometry};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::random::{Points as Sequence, Purpose, Sampler, Source};

/// A place on an axis.
#[derive(Debug, Clone)]
pub struct Coordinate {
    /// Its value in the results: a number, a text, or other JSON.
    pub value: Value,
    changes: Vec<Change>,
}

/// A dimension of a study: an axis, or all axes that are sampled together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dimension {
    /// Its name: the axis's, or `sample`.
    pub name: String,
    /// The axes.
    pub axes: Vec<usize>,
    /// How many places it has.
    pub len: usize,
}

/// All points of a study, row by row: the last dimension is the fastest.
pub struct Points {
    /// The dimensions.
    pub dimensions: Vec<Dimension>,
    /// The places on each axis.
    pub axes: Vec<Vec<Coordinate>>,
    base: Scene,
    set: Vec<Change>,
    file: PathBuf,
}

impl Points {
    /// Of a study.
    ///
    /// # Errors
    /// Its scene cannot be read, an axis has one value twice, or there are too many points.
    pub fn of(study: &Study) -> Result<Self, Error> {
        let wrong = |place: String, problem: String| {
            StudyError::from(FileError::wrong_at(&study.file, place, problem))
        };
        // Before any of them takes memory.
        if study.points().is_none_or(|n| n > MOST_POINTS) {
            let problem = format!("they make more than {MOST_POINTS} points");
            return Err(wrong("axes".into(), problem).into());
        }
        let number = study.axes.iter().filter(|axis| axis.is_sampled()).count();
        let sample = study.sample.map_or_else(Vec::new, |sample| sampled(sample, number));
        let mut dimensions: Vec<Dimension> = Vec::new();
        let mut axes = Vec::new();
        let mut samples = sample.iter();
        for (i, axis) in study.axes.iter().enumerate() {
            let places = if axis.is_sampled() {
                let shares = samples.next().expect("one for each sampled axis");
                let range = axis.range.expect("a sampled axis has one");
                numbers(axis, shares.iter().map(|&share| range.at(share)))
            } else {
                listed(axis)
            };
            let places = places.map_err(|problem| wrong(format!("axes[{i}]"), problem))?;
            let twice = if axis.is_sampled() { None } else { listed_twice(&places) };
            if let Some(value) = twice {
                let key = if axis.values.is_some() { "values" } else { "range" };
                return Err(
                    wrong(format!("axes[{i}].{key}"), format!("{value} is there twice")).into()
                );
            }
            let len = places.len();
            axes.push(places);
            let together = dimensions.iter_mut().find(|d| axis.is_sampled() && d.name == SAMPLE);
            if let Some(dimension) = together {
                dimension.axes.push(i);
                continue;
            }
            let name = if axis.is_sampled() { SAMPLE } else { &axis.name };
            dimensions.push(Dimension { name: name.to_owned(), axes: vec![i], len });
        }
        let base = study.scene()?;
        Ok(Self { dimensions, axes, base, set: study.set.clone(), file: study.file.clone() })
    }

    /// How many there are: at least one.
    #[allow(clippy::len_without_is_empty, reason = "an axis without a value is refused")]
    pub fn len(&self) -> usize {
        self.dimensions.iter().map(|dimension| dimension.len).product()
    }

    /// The place of a point on each axis.
    pub fn coordinates(&self, point: usize) -> Vec<&Coordinate> {
        let mut rest = point;
        let mut places = vec![0; self.axes.len()];
        for dimension in self.dimensions.iter().rev() {
            for &axis in &dimension.axes {
                places[axis] = rest % dimension.len;
            }
            rest /= dimension.len;
        }
        self.axes.iter().zip(places).map(|(axis, place)| &axis[place]).collect()
    }

    /// The scene of a point, with the seed of one of its beds.
    ///
    /// # Errors
    /// The scene has no such key, or the value does not fit: named with the point.
    pub fn scene(&self, point: usize, seed: u64) -> Result<Scene, Error> {
        let of_axes = self.coordinates(point).into_iter().flat_map(|place| &place.changes);
        let changes: Vec<Change> = self.set.iter().chain(of_axes).cloned().collect();
        let (of_facets, changes): (Vec<_>, Vec<_>) =
            changes.into_iter().partition(|change| change.key() == FACETS);
        let mut scene = self.base.clone().changed(&changes)?;
        if let Some(change) = of_facets.last() {
            let facets = facets(change.value()).map_err(|problem| {
                StudyError::from(FileError::wrong_at(&self.file, FACETS, problem))
            })?;
            facets.apply(&mut scene);
        }
        scene.seed = seed;
        if let SceneGeometry::Packing(packing) = &mut scene.geometry {
            packing.seed = seed;
        }
        Ok(scene)
    }
}

/// Name of the dimension of axes that are sampled together.
const SAMPLE: &str = "sample";

fn numbers(axis: &Axis, values: impl Iterator<Item = Value>) -> Result<Vec<Coordinate>, String> {
    let place = |value: Value| {
        let changes = axis.key.all().iter().map(|key| Change::to(key, value.clone()));
        Ok(Coordinate { changes: changes.collect::<Result<_, String>>()?, value })
    };
    values.map(place).collect()
}

/// The places on an axis that is not sampled.
fn listed(axis: &Axis) -> Result<Vec<Coordinate>, String> {
    if let Some(cases) = &axis.cases {
        let place = |case: &super::study::Case| Coordinate {
            value: Value::from(&*case.name),
            changes: case.set.clone(),
        };
        return Ok(cases.iter().map(place).collect());
    }
    if let Some(values) = &axis.values {
        return numbers(axis, values.iter().cloned());
    }
    let range = axis.range.expect("a checked axis has one of the three");
    let number = range.number.expect("it is not sampled");
    numbers(axis, (0..number).map(|i| range.at(i as f64 / (number - 1) as f64)))
}

/// The first value that an axis lists twice: 1 and 1.0 are the same number.
fn listed_twice(places: &[Coordinate]) -> Option<&Value> {
    let mut seen = BTreeSet::new();
    let text = |value: &Value| value.as_f64().map_or_else(|| value.to_string(), |n| n.to_string());
    places.iter().map(|place| &place.value).find(|value| !seen.insert(text(value)))
}

/// For each of some ranges the shares, 0 to 1, of all points.
fn sampled(sample: Sample, ranges: usize) -> Vec<Vec<f64>> {
    let Sample { method, points, seed } = sample;
    let mut shares = vec![Vec::with_capacity(points); ranges];
    match method {
        Method::Sobol => {
            // Paths take turns between two sequences: those of even number are one.
            let sequence = Sequence::new(seed, Purpose::Study, Sampler::Even);
            let first = sequence.of(0, 2 * points as u64).filter(|(net, _)| *net == 0);
            for (_, mut point) in first {
                for pair in shares.chunks_mut(2) {
                    for (axis, share) in pair.iter_mut().zip(point.pair()) {
                        axis.push(share);
                    }
                }
            }
        }
        Method::LatinHypercube => {
            let source = Source::new(seed, Purpose::Study);
            for (axis, shares) in shares.iter_mut().enumerate() {
                let mut stream = source.stream(axis as u64);
                // Each part of the range gets one point, in an order drawn at random.
                let mut parts: Vec<usize> = (0..points).collect();
                for i in (1..points).rev() {
                    let [share, _] = stream.pair();
                    parts.swap(i, (share * (i + 1) as f64) as usize);
                }
                let place = |part: usize| (part as f64 + stream.pair()[0]) / points as f64;
                *shares = parts.into_iter().map(place).collect();
            }
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_every_range_has_one_point() {
        for method in [Method::Sobol, Method::LatinHypercube] {
            let shares = sampled(Sample { method, points: 64, seed: 5 }, 5);
            assert_eq!(shares.len(), 5);
            for axis in &shares {
                let mut parts: Vec<usize> = axis.iter().map(|x| (x * 64.0) as usize).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..64).collect::<Vec<_>>(), "{method:?}");
            }
            assert_ne!(shares[0], shares[1]);
            assert_ne!(shares, sampled(Sample { method, points: 64, seed: 6 }, 5));
        }
    }
}
