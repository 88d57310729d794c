//! Results of stages, kept by the content of what they were made from.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::error::Error;
use crate::output::{self, OutputError};

/// A folder of results, one folder each.
#[derive(Debug, Clone)]
pub struct Cache {
    root: PathBuf,
}

impl Cache {
    /// The user's cache: `$SOILSIG_CACHE`, else `$XDG_CACHE_HOME/soilsig`, else `~/.cache/soilsig`,
    /// else a folder below the system's temporary one.
    pub fn of_user() -> Self {
        let var =
            |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let root = var("SOILSIG_CACHE")
            .or_else(|| var("XDG_CACHE_HOME").map(|folder| folder.join("soilsig")))
            .or_else(|| var("HOME").map(|home| home.join(".cache/soilsig")))
            .unwrap_or_else(|| std::env::temp_dir().join("soilsig-cache"));
        Self { root }
    }

    /// A cache in a folder of its own; in an empty one everything is made anew.
    pub fn new(root: PathBuf) -> Self {
        Self { root }
    }

    /// The folder of all results.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The folder of a stage's result for these inputs, and whether it was there already; if not,
    /// `make` fills it. It is filled beside its place and then renamed: a result that is there is
    /// whole.
    pub fn stage(
        &self,
        name: &str,
        inputs: &impl Serialize,
        make: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<(PathBuf, bool), Error> {
        let text = serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), inputs)).expect("plain data");
        let key = output::hex(&Sha256::digest(text)[..16]);
        let place = self.root.join(format!("{name}-{key}"));
        if place.is_dir() {
            return Ok((place, true));
        }
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| OutputError { path, source }
        };
        output::folder(&self.root)?;
        let beside = tempfile::Builder::new()
            .prefix(".making-")
            .tempdir_in(&self.root)
            .map_err(failed(&self.root))?;
        make(beside.path())?;
        if let Err(error) = std::fs::rename(beside.path(), &place) {
            // Another run may have come first: its result is as good.
            if !place.is_dir() {
                return Err(failed(&place)(error).into());
            }
        }
        Ok((place, false))
    }
}
