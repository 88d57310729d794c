//! Gives a parser inputs that libFuzzer makes by coverage: `SOILSIG_FUZZ=NAME soilsig-fuzz FOLDER`.
//! `make fuzz` builds and runs it for all parsers.
//!
//! A panic, an input that takes over 30 s and memory beyond [`MOST_OF_A_BYTE`] are findings. After
//! `SOILSIG_FUZZ_BYTES` bytes it ends and says what it did.

#![no_main]

#[path = "../../tests/it/fuzz/edits.rs"]
mod edits;
#[path = "../../tests/it/fuzz/parsers.rs"]
mod parsers;
#[path = "../../tests/it/fuzz/seeds.rs"]
mod seeds;

use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use peak_alloc::PeakAlloc;
use tempfile::TempDir;

use edits::edited;
use parsers::{PARSERS, Parser};

/// Bytes of memory that each byte of an input may take, beyond [`MOST_OF_ALL`].
const MOST_OF_A_BYTE: usize = 200;
/// Bytes that any input may take: tables of crystals, spectra and the like.
const MOST_OF_ALL: usize = 4 << 20;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

struct Run {
    parser: &'static Parser,
    folder: TempDir,
    most_bytes: u64,
    began: Instant,
    bytes: AtomicU64,
    inputs: AtomicU64,
    read: AtomicU64,
    most_memory: AtomicUsize,
}

static RUN: OnceLock<Run> = OnceLock::new();

/// Finds the parser, and writes its seeds into the folder of inputs.
fn begin() -> Run {
    let name = std::env::var("SOILSIG_FUZZ").unwrap_or_default();
    let Some(parser) = PARSERS.iter().find(|parser| parser.name == name) else {
        let names: Vec<&str> = PARSERS.iter().map(|parser| parser.name).collect();
        eprintln!("SOILSIG_FUZZ must name one of\nparsers: {}", names.join(" "));
        std::process::exit(2);
    };
    let most = std::env::var("SOILSIG_FUZZ_BYTES").ok().and_then(|most| most.parse().ok());
    let folder = Path::new("/dev/shm");
    let folder = if folder.is_dir() { folder.to_owned() } else { std::env::temp_dir() };
    Run {
        parser,
        folder: TempDir::new_in(folder).expect("a folder"),
        most_bytes: most.unwrap_or(u64::MAX),
        began: Instant::now(),
        bytes: AtomicU64::new(0),
        inputs: AtomicU64::new(0),
        read: AtomicU64::new(0),
        most_memory: AtomicUsize::new(0),
    }
}

fuzz_target!(init: {
    RUN.get_or_init(begin);
    if let Some(folder) = std::env::args().skip(1).find(|word| !word.starts_with('-')) {
        let parser = RUN.get_or_init(begin).parser;
        std::fs::create_dir_all(&folder).expect("made");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate's folder");
        let inputs = (parser.seeds)().into_iter().chain(seeds::found(root, parser.name));
        for (i, input) in inputs.enumerate() {
            std::fs::write(Path::new(&folder).join(format!("seed_{i}")), input).expect("written");
        }
    }
}, |data: &[u8]| {
    let run = RUN.get_or_init(begin);
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    if run.parser.read(data, run.folder.path()).is_ok() {
        run.read.fetch_add(1, Relaxed);
    }
    let memory = MEMORY.peak_usage().saturating_sub(before);
    let most = MOST_OF_ALL + MOST_OF_A_BYTE * data.len();
    assert!(memory <= most, "{} bytes take {memory} bytes of memory", data.len());
    run.most_memory.fetch_max(memory, Relaxed);
    run.inputs.fetch_add(1, Relaxed);
    if run.bytes.fetch_add(data.len() as u64, Relaxed) + data.len() as u64 >= run.most_bytes {
        report(run);
        let _ = std::fs::remove_dir_all(run.folder.path());
        // libFuzzer takes an end by `exit` for a finding.
        // SAFETY: nothing is left to be done, and nothing runs after it.
        unsafe { libc::_exit(0) }
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
    // Half of the inputs by words and lines, half by libFuzzer's own changes.
    if seed % 2 == 0 {
        return fuzzer_mutate(data, size, most);
    }
    let mut state = u64::from(seed) | 1 << 40;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as u32
    };
    let number = 1 + next() % 4;
    let edits: Vec<edits::Edit> = (0..number).map(|_| (next() as u8, next(), next())).collect();
    let changed = edited(&data[..size], &edits, most);
    data[..changed.len()].copy_from_slice(&changed);
    changed.len()
});

fn report(run: &Run) {
    println!(
        "{}: {} bytes in {} inputs, {} of them read, {:.0} s, at most {} kB of memory",
        run.parser.name,
        run.bytes.load(Relaxed),
        run.inputs.load(Relaxed),
        run.read.load(Relaxed),
        run.began.elapsed().as_secs_f64(),
        run.most_memory.load(Relaxed) / 1000
    );
}
