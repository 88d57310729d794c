//! What memory and disk a task may take, asked before it begins.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::error::{Failure, Status};

/// Less than this is not worth a word, bytes.
const NOTABLE: u64 = 10_000_000_000;

/// A task needs more than there is.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ResourceError {
    /// Memory.
    #[error("{task} takes {} of memory, but {} are free", size(*needed), size(*free))]
    Memory {
        /// What needs it.
        task: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes free.
        free: u64,
    },
    /// Room on a disk.
    #[error("{task} takes {} on disk, but {} are free at {}", size(*needed), size(*free), at.display())]
    Disk {
        /// What needs it.
        task: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes free.
        free: u64,
        /// The folder.
        at: PathBuf,
    },
}

impl Failure for ResourceError {
    fn status(&self) -> Status {
        Status::Files
    }

    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Memory { .. } => "ask for less: fewer pixels or fewer bands".into(),
            Self::Disk { .. } => {
                "ask for less, fewer pixels or fewer bands, or write elsewhere with --out".into()
            }
        })
    }
}

/// An error if a task needs more bytes of memory than are free.
pub fn need_memory(task: &str, needed: u64) -> Result<(), ResourceError> {
    match free_memory() {
        Some(free) if free < needed => {
            Err(ResourceError::Memory { task: task.to_owned(), needed, free })
        }
        _ => Ok(()),
    }
}

/// An error if a task needs more bytes than are free on the disk of a folder; else a sentence on
/// how many it takes, if they are many.
pub fn need_disk(task: &str, needed: u64, folder: &Path) -> Result<Option<String>, ResourceError> {
    match free_disk(folder) {
        Some(free) if free < needed => {
            let at = folder.to_owned();
            Err(ResourceError::Disk { task: task.to_owned(), needed, free, at })
        }
        _ => Ok((needed >= NOTABLE).then(|| format!("{task} takes {} on disk", size(needed)))),
    }
}

/// Bytes in words.
pub fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000_000 => format!("{} MB", bytes.div_ceil(1_000_000)),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

fn free_disk(folder: &Path) -> Option<u64> {
    let folder = folder.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."));
    let disk = rustix::fs::statvfs(folder).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

/// Bytes that the process may still take: by the system, by its group and by its own limit.
pub fn free_memory() -> Option<u64> {
    let text = |path| fs::read_to_string(path).ok();
    let number = |path| text(path)?.trim().parse::<u64>().ok();
    // "MemAvailable:   123 kB"
    let kilobytes = |path, key: &str| {
        let line =
            text(path)?.lines().find_map(|line| line.strip_prefix(key).map(str::to_owned))?;
        Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
    };
    let of_group = |most, now| Some(number(most)?.saturating_sub(number(now)?));
    let own = || {
        let limits = text("/proc/self/limits")?;
        let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
        let most = line.split_whitespace().next()?.parse::<u64>().ok()?;
        Some(most.saturating_sub(kilobytes("/proc/self/status", "VmSize:")?))
    };
    [
        kilobytes("/proc/meminfo", "MemAvailable:"),
        of_group("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        of_group(
            "/sys/fs/cgroup/memory/memory.limit_in_bytes",
            "/sys/fs/cgroup/memory/memory.usage_in_bytes",
        ),
        own(),
    ]
    .into_iter()
    .flatten()
    .min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_refused_before_the_work() {
        assert_eq!(need_memory("nothing", 0), Ok(()));
        assert_eq!(need_disk("nothing", 0, Path::new("not/yet/there")), Ok(None));
        let error = need_disk("all", u64::MAX, Path::new("")).expect_err("too much").to_string();
        assert!(error.starts_with("all takes 18446744073.7 GB on disk, but "), "{error}");
        if cfg!(target_os = "linux") {
            let error = need_memory("all", u64::MAX).expect_err("too much").to_string();
            assert!(error.starts_with("all takes 18446744073.7 GB of memory, but "), "{error}");
        }
    }
}
