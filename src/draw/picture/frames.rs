//! The recorded drop: `frames.json`, which `soilsig pipeline` writes beside `scene.json`.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::source::PictureError;
use crate::support::file_error::FileError;

/// Version of the file, the value of `soilsig_frames`.
const FORMAT: u32 = 1;
/// Greatest valid coordinate, um.
const FARTHEST_UM: f64 = 1e9;
/// Most panels of a strip.
pub const MOST_PANELS: usize = 24;

/// The places of the grains at some times of the drop.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Frames {
    soilsig_frames: u32,
    /// Inner width and breadth of the tray, from the origin, um.
    pub tray_um: [f64; 2],
    /// Prototype of each grain.
    pub prototypes: Vec<String>,
    /// From the release to the rest.
    pub frames: Vec<Frame>,
}

/// One moment.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Frame {
    /// Time since the release for real grains, s.
    pub time_s: f64,
    /// Transform of each grain, as in a scene's instances.
    pub transforms: Vec<[f64; 12]>,
}

impl Frames {
    /// Reads the file and checks it against the prototypes of its scene.
    pub fn read(path: &Path, known: &[&str]) -> Result<Self, PictureError> {
        let text = fs::read_to_string(path).map_err(FileError::read(path))?;
        let again = "run the pipeline again: it writes the version that this program reads";
        let frames: Self = serde_json::from_str(&text)
            .map_err(|error| FileError::wrong(path, error.to_string()).with_hint(again))?;
        let wrong = |(place, problem)| FileError::wrong_at(path, place, problem).with_hint(again);
        frames.check(known).map_err(wrong)?;
        Ok(frames)
    }

    /// Returns the place and the problem of what is wrong.
    fn check(&self, known: &[&str]) -> Result<(), (String, String)> {
        let wrong = |place: &str, problem: String| Err((place.to_owned(), problem));
        if self.soilsig_frames != FORMAT {
            let problem = format!("version {} is not known", self.soilsig_frames);
            return wrong("soilsig_frames", problem);
        }
        if !self.tray_um.iter().all(|side| side.is_finite() && *side > 0.0) {
            return wrong("tray_um", "both sides must be above 0".into());
        }
        if let Some(name) = self.prototypes.iter().find(|name| !known.contains(&name.as_str())) {
            return wrong("prototypes", format!("the scene beside it has no prototype {name:?}"));
        }
        if self.frames.is_empty() || self.prototypes.is_empty() {
            return wrong("frames", "there must be at least one frame and one grain".into());
        }
        for (i, frame) in self.frames.iter().enumerate() {
            let mut numbers = frame.transforms.iter().flatten();
            if numbers.any(|x| x.abs() > FARTHEST_UM) {
                return wrong(&format!("frames[{i}]"), "a number is beyond a kilometre".into());
            }
            let (places, grains) = (frame.transforms.len(), self.prototypes.len());
            if places != grains {
                let place = format!("frames[{i}].transforms");
                return wrong(&place, format!("{places} places for {grains} grains"));
            }
        }
        Ok(())
    }

    /// Chooses frames from the first to the last, in which the grains sink by equal steps. In a
    /// shorter record the last frame is repeated.
    pub fn chosen(&self, panels: usize) -> Vec<&Frame> {
        let last = self.frames.len() - 1;
        let heights: Vec<f64> = self.frames.iter().map(Frame::height_um).collect();
        let mut chosen = vec![0];
        for panel in 1..panels - 1 {
            let share = panel as f64 / (panels - 1) as f64;
            let wanted = heights[0] + share * (heights[last] - heights[0]);
            let off = |i: &usize| (heights[*i] - wanted).abs();
            let from = (chosen[panel - 1] + 1).min(last);
            // Enough frames must be left for the other panels.
            let to = (last + panel + 1).saturating_sub(panels).max(from);
            chosen.extend((from..=to).min_by(|i, j| off(i).total_cmp(&off(j))));
        }
        chosen.push(last);
        chosen.into_iter().map(|i| &self.frames[i]).collect()
    }
}

impl Frame {
    /// Mean height of the grains.
    fn height_um(&self) -> f64 {
        self.transforms.iter().map(|t| t[11]).sum::<f64>() / self.transforms.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_show_equal_steps_down_and_no_frame_twice() {
        let frame = |i: i32| {
            let mut place = [0.0; 12];
            place[11] = 100.0 - f64::from((i * i).min(100));
            Frame { time_s: f64::from(i), transforms: vec![place] }
        };
        let prototypes = vec!["grain".into()];
        let frames = (0..24).map(frame).collect();
        let record = Frames { soilsig_frames: FORMAT, tray_um: [1.0; 2], prototypes, frames };
        let times = |panels| record.chosen(panels).iter().map(|f| f.time_s).collect::<Vec<_>>();
        assert_eq!(times(2), [0.0, 23.0]);
        assert_eq!(times(5), [0.0, 5.0, 7.0, 9.0, 23.0]);
        assert!((2..=24).all(|n| times(n).windows(2).all(|pair| pair[0] < pair[1])));
        assert_eq!(times(24).len(), 24);
    }
}
