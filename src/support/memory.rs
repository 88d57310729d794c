//! How much memory there is.

use std::fs;

/// Bytes of memory that the program may still take, as far as the system says: what is free, less
/// where the process or its group has a limit of its own.
pub(crate) fn available() -> Option<u64> {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let (system, own) = (read("/proc/meminfo"), read("/proc/self/status"));
    let free = Some(kilobytes(&system, "MemAvailable:")? + kilobytes(&system, "SwapFree:")?);
    let left = |limit: Option<u64>, taken| Some(limit?.saturating_sub(kilobytes(&own, taken)?));
    let limits = read("/proc/self/limits");
    let addresses = word_after(&limits, "Max address space").and_then(|word| word.parse().ok());
    let groups = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let group = groups.iter().filter_map(|path| read(path).trim().parse().ok()).min();
    [free, left(addresses, "VmSize:"), left(group, "VmRSS:")].into_iter().flatten().min()
}

fn kilobytes(text: &str, key: &str) -> Option<u64> {
    Some(word_after(text, key)?.parse::<u64>().ok()? * 1024)
}

fn word_after<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.lines().find_map(|line| line.strip_prefix(key))?.split_whitespace().next()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn some_memory_is_available() {
        let available = super::available().expect("Linux says");
        assert!((1 << 20..1 << 50).contains(&available), "{available}");
    }
}
