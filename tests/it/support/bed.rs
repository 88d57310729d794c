//! One small bed by each Blender, dropped once for all tests that only look at it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use serde_json::Value;

use super::place::{Place, shipped};

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
        type Cell = Arc<OnceLock<Arc<SmallBed>>>;
        static BEDS: Mutex<BTreeMap<PathBuf, Cell>> = Mutex::new(BTreeMap::new());
        let cell = {
            let mut beds = BEDS.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(beds.entry(blender.to_owned()).or_default())
        };
        Arc::clone(cell.get_or_init(|| Arc::new(Self::dropped(blender))))
    }

    fn dropped(blender: &Path) -> Self {
        let place = Place::in_folder(&folder());
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

/// A folder that outlives this process, since nothing drops what is static; those of earlier ones
/// go.
fn folder() -> PathBuf {
    let all = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for entry in fs::read_dir(all).expect("Cargo made it").flatten() {
        let name = entry.file_name().into_string().unwrap_or_default();
        let process = name.strip_prefix("bed-").and_then(|name| name.split('-').next());
        if process.is_some_and(|id| !Path::new("/proc").join(id).exists()) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
    let name = format!("bed-{}-", process::id());
    tempfile::Builder::new().prefix(&name).tempdir_in(all).expect("a folder").keep()
}
