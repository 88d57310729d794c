//! A cache of stages' results, by the content of their inputs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::support::error::{Error, Failure, Status};
use crate::support::output::{self, OutputError};

/// The cache cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the cache: {0}")]
pub struct CacheError(pub OutputError);

impl Failure for CacheError {
    fn hint(&self) -> Option<String> {
        Some("name another folder in SOILSIG_CACHE, or use --no-cache".into())
    }

    fn status(&self) -> Status {
        Status::Files
    }
}

/// A folder with one subfolder per result.
#[derive(Debug, Clone)]
pub struct Cache {
    root: PathBuf,
    /// Where known Blenders are noted.
    blenders: PathBuf,
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
        Self::new(root)
    }

    /// A cache in its own folder.
    pub fn new(root: PathBuf) -> Self {
        Self { blenders: root.clone(), root }
    }

    /// A cache for other results that shares the known Blenders.
    #[must_use]
    pub fn other_results(&self, root: PathBuf) -> Self {
        Self { root, blenders: self.blenders.clone() }
    }

    /// The folder in which known Blenders are noted.
    pub fn blenders(&self) -> &Path {
        &self.blenders
    }

    /// The folder of all results.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// A stage's result for these inputs, if it exists and agrees with its manifest. A damaged one
    /// is removed.
    pub fn look(&self, name: &str, inputs: &impl Serialize) -> Result<Option<Made>, Error> {
        let folder = self.place(name, inputs);
        if !folder.is_dir() {
            return Ok(None);
        }
        if let Some(files) = intact(&folder) {
            return Ok(Some(Made { folder, files, cached: true }));
        }
        std::fs::remove_dir_all(&folder).map_err(failed(&folder))?;
        Ok(None)
    }

    /// A stage's result for these inputs. If it does not exist, `make` fills a temporary folder,
    /// which gets a manifest and then its own name.
    pub fn stage(
        &self,
        name: &str,
        inputs: &impl Serialize,
        make: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<Made, Error> {
        if let Some(made) = self.look(name, inputs)? {
            return Ok(made);
        }
        let folder = self.place(name, inputs);
        let scratch = self.scratch()?;
        make(scratch.path())?;
        let files = output::list(scratch.path()).map_err(CacheError)?;
        let sum = |file: &String| {
            output::sha256_hex(&scratch.path().join(file)).map(|sum| (file.clone(), sum))
        };
        let manifest: BTreeMap<_, _> =
            files.iter().map(sum).collect::<Result<_, _>>().map_err(CacheError)?;
        let text = serde_json::to_vec(&manifest).expect("plain data");
        output::bytes(&scratch.path().join(MANIFEST), &text).map_err(CacheError)?;
        if let Err(error) = std::fs::rename(scratch.path(), &folder) {
            // Another run was first; its result is the same.
            if intact(&folder).is_none() {
                return Err(failed(&folder)(error));
            }
        }
        Ok(Made { folder, files, cached: false })
    }

    /// A folder for work in progress, on the same disk. It is removed when dropped.
    pub fn scratch(&self) -> Result<tempfile::TempDir, Error> {
        output::folder(&self.root).map_err(CacheError)?;
        let folder = tempfile::Builder::new().prefix(".making-").tempdir_in(&self.root);
        folder.map_err(failed(&self.root))
    }

    fn place(&self, name: &str, inputs: &impl Serialize) -> PathBuf {
        let text = serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), inputs)).expect("plain data");
        self.root.join(format!("{name}-{}", output::hex(&Sha256::digest(text)[..16])))
    }
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> Error + use<> {
    let path = path.to_owned();
    move |source| CacheError(OutputError { path, source }).into()
}

const MANIFEST: &str = "manifest.json";

/// The result of a stage.
#[derive(Debug)]
pub struct Made {
    /// Its folder.
    pub folder: PathBuf,
    /// Its files.
    pub files: Vec<String>,
    /// Whether it existed already.
    pub cached: bool,
}

/// The files of a result, if they agree with its manifest.
fn intact(folder: &Path) -> Option<Vec<String>> {
    let text = std::fs::read(folder.join(MANIFEST)).ok()?;
    let manifest: BTreeMap<String, String> = serde_json::from_slice(&text).ok()?;
    let agrees = |(file, sum): (&String, &String)| {
        output::sha256_hex(&folder.join(file)).is_ok_and(|now| now == *sum)
    };
    manifest.iter().all(agrees).then(|| manifest.into_keys().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::monitor::Interrupted;

    #[test]
    fn a_damaged_result_is_made_anew() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = Cache::new(folder.path().join("cache"));
        let run = || {
            let made = cache.stage("s", &1, |at| Ok(output::bytes(&at.join("file"), b"whole")?));
            made.expect("made")
        };
        assert!(!run().cached);
        let made = run();
        assert!(made.cached && made.files == ["file"]);
        std::fs::write(made.folder.join("file"), b"torn").expect("written");
        assert!(!run().cached, "a changed file");
        std::fs::remove_file(run().folder.join("file")).expect("removed");
        assert!(!run().cached, "a missing file");
        assert_eq!(std::fs::read(run().folder.join("file")).expect("there"), b"whole");
    }

    #[test]
    fn a_result_that_could_not_be_made_is_not_there() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = Cache::new(folder.path().to_owned());
        let failed = cache.stage("s", &1, |at| {
            output::bytes(&at.join("file"), b"half")?;
            Err(Interrupted.into())
        });
        assert!(failed.is_err());
        assert_eq!(output::list(folder.path()).expect("a folder"), [""; 0]);
    }
}
