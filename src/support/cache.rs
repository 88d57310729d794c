//! A cache of stages' results, by the content of their inputs.

use std::collections::BTreeMap;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::support::error::{Error, Failure, Status};
use crate::support::output::{self, OutputError};
use crate::support::scratch::Scratch;
use crate::support::trust;

/// The cache cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// A file of it cannot be read or written.
    #[error("the cache: {0}")]
    Output(#[from] OutputError),
    /// Others may have put files into it.
    #[error("the cache {} is not used: {doubt}", folder.display())]
    Doubted {
        /// Its folder.
        folder: PathBuf,
        /// What others may do.
        doubt: String,
    },
}

impl Failure for CacheError {
    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Output(OutputError { source, .. })
                if matches!(
                    source.kind(),
                    std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded
                ) =>
            {
                "its disk is full: free some space, name another folder in SOILSIG_CACHE, or use \
                 --no-cache"
            }
            Self::Output(_) => "name another folder in SOILSIG_CACHE, or use --no-cache",
            Self::Doubted { .. } => {
                "take the right to write from others (chmod go-w), name another folder in \
                 SOILSIG_CACHE, or use --no-cache"
            }
        }
        .into())
    }

    fn status(&self) -> Status {
        Status::Files
    }
}

/// A folder with one subfolder per result.
#[derive(Clone)]
pub struct Cache {
    root: PathBuf,
    /// Where known Blenders are noted.
    blenders: PathBuf,
    /// The folder of a user without a home, which goes with this value.
    _of_run: Option<Arc<Scratch>>,
    /// Whether others might write to it: not to a folder that this run made.
    is_to_be_checked: bool,
    /// Most bytes of all results.
    limit: u64,
    /// Bytes made since all results were counted; they are counted at the first result.
    made: Arc<AtomicU64>,
}

/// Most bytes of the cache, unless `SOILSIG_CACHE_SIZE` says otherwise.
const LIMIT: u64 = 20_000_000_000;

/// Results that were used within this time are not removed: a run may still read them.
const IN_USE: Duration = Duration::from_secs(3600);

/// A result in the cache.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The stage that made it.
    pub stage: String,
    /// Bytes of its files.
    pub bytes: u64,
    folder: PathBuf,
    used: SystemTime,
}

impl Cache {
    /// The user's cache: `$SOILSIG_CACHE`, else `$XDG_CACHE_HOME/soilsig`, else `~/.cache/soilsig`.
    /// Relative paths in the last two are ignored. Without any of them it lasts as long as the run.
    pub fn of_user() -> Self {
        let var =
            |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let absolute = |name| var(name).filter(|folder| folder.is_absolute());
        let root = var("SOILSIG_CACHE")
            .or_else(|| absolute("XDG_CACHE_HOME").map(|folder| folder.join("soilsig")))
            .or_else(|| absolute("HOME").map(|home| home.join(".cache/soilsig")));
        if let Some(root) = root {
            return Self::new(std::path::absolute(&root).unwrap_or(root));
        }
        // No guessable name among the temporary folders: others could be first there.
        match Scratch::temporary() {
            Ok(scratch) => {
                let cache = Self::of_run(scratch.path().to_owned());
                Self { _of_run: Some(Arc::new(scratch)), ..cache }
            }
            // The first use of it fails, and says so.
            Err(error) => Self::new(error.0.path),
        }
    }

    /// A cache in its own folder.
    pub fn new(root: PathBuf) -> Self {
        Self {
            blenders: root.clone(),
            root,
            _of_run: None,
            is_to_be_checked: true,
            limit: limit(),
            made: Arc::new(AtomicU64::new(u64::MAX)),
        }
    }

    /// A cache in a temporary folder of this run.
    pub fn of_run(root: PathBuf) -> Self {
        Self { is_to_be_checked: false, ..Self::new(root) }
    }

    /// A cache in a temporary folder of this run that shares the known Blenders.
    #[must_use]
    pub fn other_results(&self, root: PathBuf) -> Self {
        let made = Arc::new(AtomicU64::new(u64::MAX));
        Self { root, is_to_be_checked: false, made, ..self.clone() }
    }

    /// The folder in which known Blenders are noted.
    pub fn blenders(&self) -> &Path {
        &self.blenders
    }

    /// The folder of all results.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Makes the folder if it is not there, and refuses one that others may write to.
    fn open(&self) -> Result<(), CacheError> {
        let at = failed(&self.root);
        std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&self.root).map_err(at)?;
        if !self.is_to_be_checked {
            return Ok(());
        }
        match trust::doubt(&self.root).map_err(failed(&self.root))? {
            None => Ok(()),
            Some(doubt) => Err(CacheError::Doubted { folder: self.root.clone(), doubt }),
        }
    }

    /// A stage's result for these inputs, if it exists and agrees with its manifest. A damaged one
    /// is removed.
    pub fn look(&self, name: &str, inputs: &impl Serialize) -> Result<Option<Made>, Error> {
        self.open()?;
        let folder = self.place(name, inputs);
        if std::fs::symlink_metadata(&folder).is_err() {
            return Ok(None);
        }
        if let Some(files) = intact(&folder) {
            // Results that were not used for longest go first.
            let now = std::fs::File::open(folder.join(MANIFEST));
            let _ = now.and_then(|file| file.set_modified(SystemTime::now()));
            return Ok(Some(Made { folder, files, cached: true }));
        }
        // Another run may have been faster.
        let gone = |error: &std::io::Error| error.kind() == std::io::ErrorKind::NotFound;
        match std::fs::remove_dir_all(&folder) {
            Err(error) if !gone(&error) => Err(failed(&folder)(error).into()),
            _ => Ok(None),
        }
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
        make(scratch.path()).map_err(|error| in_cache(error, scratch.path()))?;
        let files = output::list(scratch.path()).map_err(CacheError::Output)?;
        let keep = || -> Result<(), OutputError> {
            let sum = |file: &String| {
                output::sha256_hex(&scratch.path().join(file)).map(|sum| (file.clone(), sum))
            };
            let manifest: BTreeMap<_, _> = files.iter().map(sum).collect::<Result<_, _>>()?;
            let text = serde_json::to_vec(&manifest).expect("plain data");
            output::scratch(&scratch.path().join(MANIFEST), &text)?;
            output::sync_all_in(scratch.path())
        };
        keep().map_err(CacheError::Output)?;
        match std::fs::rename(scratch.path(), &folder) {
            Ok(()) => output::sync_folder(&self.root).map_err(failed(&self.root))?,
            // Another run was first; its result is the same.
            Err(_) if intact(&folder).is_some() => {}
            Err(error) => return Err(failed(&folder)(error).into()),
        }
        self.keep_limit(&folder)?;
        Ok(Made { folder, files, cached: false })
    }

    /// Most bytes of all results.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// All results.
    pub fn entries(&self) -> Result<Vec<Entry>, Error> {
        if !self.root.is_dir() {
            return Ok(Vec::new());
        }
        self.open()?;
        let names = output::list(&self.root).map_err(CacheError::Output)?;
        let entry = |name: String| {
            let (stage, sum) = name.rsplit_once('-')?;
            let is_ours = !stage.starts_with('.')
                && sum.len() == 32
                && sum.bytes().all(|b| b.is_ascii_hexdigit());
            let folder = self.root.join(&name);
            let used = std::fs::metadata(folder.join(MANIFEST)).and_then(|file| file.modified());
            // Another process may have removed it.
            let (bytes, used) = (bytes_of(&folder)?, used.ok()?);
            is_ours.then(|| Entry { stage: stage.to_owned(), bytes, folder, used })
        };
        Ok(names.into_iter().filter_map(entry).collect())
    }

    /// Removes results, all of them or those of a stage; returns how many and their bytes.
    pub fn clear(&self, stage: Option<&str>) -> Result<(usize, u64), Error> {
        let is_meant = |entry: &Entry| stage.is_none_or(|stage| entry.stage == stage);
        let meant: Vec<Entry> = self.entries()?.into_iter().filter(is_meant).collect();
        for entry in &meant {
            self.remove(entry)?;
        }
        Ok((meant.len(), meant.iter().map(|entry| entry.bytes).sum()))
    }

    fn remove(&self, entry: &Entry) -> Result<(), Error> {
        // It loses its name at once, so that nobody finds half of it.
        let scratch = self.scratch()?;
        match std::fs::rename(&entry.folder, scratch.path().join("removed")) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(failed(&entry.folder)(error).into())
            }
            _ => Ok(()),
        }
    }

    /// Removes the results that were not used for longest, if all together pass the limit.
    fn keep_limit(&self, new: &Path) -> Result<(), Error> {
        let bytes = bytes_of(new).unwrap_or(0);
        let made = self.made.fetch_add(bytes, Ordering::Relaxed);
        // Counting takes a look at every file: so it is done now and then.
        let is_due = made == u64::MAX || made.saturating_add(bytes) > self.limit / 20;
        if !is_due {
            return Ok(());
        }
        self.made.store(0, Ordering::Relaxed);
        let mut entries = self.entries()?;
        let mut total: u64 = entries.iter().map(|entry| entry.bytes).sum();
        entries.sort_by_key(|entry| entry.used);
        let is_free = |entry: &Entry| entry.used.elapsed().is_ok_and(|age| age > IN_USE);
        for entry in entries.iter().filter(|entry| is_free(entry)) {
            if total <= self.limit {
                break;
            }
            self.remove(entry)?;
            total -= entry.bytes;
        }
        Ok(())
    }

    /// A folder for work in progress, on the same disk. It is removed when dropped.
    pub fn scratch(&self) -> Result<Scratch, Error> {
        self.open()?;
        Ok(Scratch::within(&self.root, MAKING).map_err(failed(&self.root))?)
    }

    fn place(&self, name: &str, inputs: &impl Serialize) -> PathBuf {
        let text = serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), inputs)).expect("plain data");
        self.root.join(format!("{name}-{}", output::hex(&Sha256::digest(text)[..16])))
    }
}

/// The limit that the user set.
fn limit() -> u64 {
    std::env::var("SOILSIG_CACHE_SIZE").ok().and_then(|text| bytes(&text)).unwrap_or(LIMIT)
}

/// Bytes written as `500M`, `20G` or `2T`.
pub fn bytes(text: &str) -> Option<u64> {
    let text = text.trim().trim_end_matches(['b', 'B']);
    let (number, times) = match text.chars().last()?.to_ascii_uppercase() {
        'K' => (&text[..text.len() - 1], 1e3),
        'M' => (&text[..text.len() - 1], 1e6),
        'G' => (&text[..text.len() - 1], 1e9),
        'T' => (&text[..text.len() - 1], 1e12),
        _ => (text, 1.0),
    };
    let number: f64 = number.trim().parse().ok().filter(|n: &f64| *n >= 0.0 && n.is_finite())?;
    Some((number * times) as u64)
}

fn bytes_of(folder: &Path) -> Option<u64> {
    let files = std::fs::read_dir(folder).ok()?.flatten();
    Some(files.filter_map(|file| file.metadata().ok()).map(|file| file.len()).sum())
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> CacheError + use<> {
    let path = path.to_owned();
    move |source| CacheError::Output(OutputError { path, source })
}

/// What failed inside a folder of the cache is a failure of the cache, with its own remedy.
fn in_cache(error: Error, folder: &Path) -> Error {
    match error.downcast::<OutputError>() {
        Ok(error) if error.path.starts_with(folder) => CacheError::Output(error).into(),
        Ok(error) => error.into(),
        Err(error) => error,
    }
}

const MANIFEST: &str = "manifest.json";

/// Begin of the names of folders for work in progress.
const MAKING: &str = ".making-";

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

/// The files of a result, if they agree with its manifest. Each is a file of the folder itself.
fn intact(folder: &Path) -> Option<Vec<String>> {
    let is_file =
        |path: &Path| std::fs::symlink_metadata(path).is_ok_and(|now| now.file_type().is_file());
    let list = folder.join(MANIFEST);
    if !std::fs::symlink_metadata(folder).is_ok_and(|now| now.is_dir()) || !is_file(&list) {
        return None;
    }
    let manifest: BTreeMap<String, String> =
        serde_json::from_slice(&std::fs::read(list).ok()?).ok()?;
    let agrees = |(file, sum): (&String, &String)| {
        let path = folder.join(file);
        output::is_plain(file)
            && file != MANIFEST
            && is_file(&path)
            && output::sha256_hex(&path).is_ok_and(|now| now == *sum)
    };
    manifest.iter().all(agrees).then(|| manifest.into_keys().collect())
}

#[cfg(test)]
mod tests;
