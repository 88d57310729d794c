//! One small bed by each Blender, dropped once for all tests that only look at it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use serde_json::Value;

use super::place::{Place, shipped};

/// What several tests look at, made once by each Blender.
pub struct OfBlenders<T>(Mutex<BTreeMap<PathBuf, Arc<OnceLock<Arc<T>>>>>);

impl<T> OfBlenders<T> {
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    pub fn of(&self, blender: &Path, make: impl FnOnce(&Path) -> T) -> Arc<T> {
        let cell = {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(all.entry(blender.to_owned()).or_default())
        };
        Arc::clone(cell.get_or_init(|| Arc::new(make(blender))))
    }
}

/// The shipped small recipe, run twice into `r`: the second time all of it comes from the cache.
pub struct SmallBed {
    /// Where it was run.
    pub place: Place,
    /// Blender as it was called: it writes a line into `starts` each time.
    pub blender: PathBuf,
    /// The record of the first run and that of the second.
    pub records: [Value; 2],
    /// How often Blender was started by then.
    pub starts: [usize; 2],
    /// The log of the first run.
    pub log: Vec<u8>,
}

/// The user's home of its two runs, empty before.
pub const HOME: &str = "home";

impl SmallBed {
    const ARGS: [&str; 5] = ["pipeline", "--out", "r", "--json", "--patch-obj"];

    /// The bed of this Blender.
    pub fn of(blender: &Path) -> Arc<Self> {
        static BEDS: OfBlenders<SmallBed> = OfBlenders::new();
        BEDS.of(blender, Self::dropped)
    }

    fn dropped(blender: &Path) -> Self {
        let place = Place::kept();
        let wrapper = place.counted(blender);
        let mut starts = [0; 2];
        let mut log = Vec::new();
        fs::create_dir(place.path(HOME)).expect("made");
        let scene = shipped("small.json");
        let records = [0, 1].map(|run| {
            let args = [&Self::ARGS[..], &["--scene", &scene]].concat();
            let mut command = place.soilsig_with(&wrapper, &args);
            let record = Place::ended(command.env("HOME", place.path(HOME)), 0).0;
            starts[run] = place.starts();
            if run == 0 {
                log = fs::read(place.path("r/blender.log")).expect("written");
            }
            serde_json::from_str(&record).expect("the record")
        });
        Self { place, blender: wrapper, records, starts, log }
    }
}
