//! Every reader of files is given changed inputs: none panics, hangs or reads a wrong number.
//! `make fuzz` does it for longer, by coverage.

mod edits;
mod parsers;
pub mod seeds;

use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};

use edits::edited;
use parsers::{PARSERS, Parser};

/// Changed inputs of each parser.
const CASES: u32 = 400;
/// Longest that all of them may take.
const LONGEST: Duration = Duration::from_secs(120);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn every_parser_reads_its_valid_inputs() {
    let folder = tempfile::tempdir().expect("a folder");
    for parser in PARSERS {
        for (i, seed) in (parser.seeds)().iter().enumerate() {
            let read = parser.read(seed, folder.path());
            assert!(read.is_ok(), "{} {i}: {}", parser.name, read.unwrap_err());
        }
    }
}

#[test]
fn no_parser_fails_on_what_once_was_read_wrongly() {
    let folder = tempfile::tempdir().expect("a folder");
    for parser in PARSERS {
        for input in seeds::found(root(), parser.name) {
            let _ = parser.read(&input, folder.path());
        }
    }
}

#[test]
fn no_parser_panics_or_hangs_on_changed_inputs() {
    for parser in PARSERS {
        in_time(parser, fuzzed);
    }
}

#[test]
fn no_parser_hangs_on_long_text_above_its_numbers() {
    for parser in PARSERS {
        in_time(parser, |parser| {
            let folder = tempfile::tempdir().expect("a folder");
            for text in
                ["/\n", "no word\n", "emissivity of ", "reflectance %", "1-", "0", " ", "a,"]
            {
                let bare = b"8 0.9\n9 0.8\n10 0.7\n".to_vec();
                for seed in (parser.seeds)().into_iter().chain([bare]) {
                    let long = [text.repeat(60_000 / text.len()).as_bytes(), &seed].concat();
                    let _ = parser.read(&long, folder.path());
                }
            }
        });
    }
}

/// Panics if it panics, or takes longer than [`LONGEST`].
fn in_time(parser: &'static Parser, tried: fn(&Parser)) {
    let (ended, end) = mpsc::channel();
    thread::spawn(move || {
        let result = panic::catch_unwind(AssertUnwindSafe(|| tried(parser)));
        ended.send(result).expect("somebody waits");
    });
    match end.recv_timeout(LONGEST) {
        Ok(Ok(())) => {}
        Ok(Err(panicked)) => panic::resume_unwind(panicked),
        Err(error) => panic!("{} hangs, or is slow: {error}", parser.name),
    }
}

/// Panics with the least changes that make a parser panic.
fn fuzzed(parser: &Parser) {
    let folder = tempfile::tempdir().expect("a folder");
    let seeds = (parser.seeds)();
    let config = Config {
        cases: CASES,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..Config::default()
    };
    let edit = (0..17_u8, any::<u32>(), any::<u32>());
    let changed = (0..seeds.len(), vec(edit, 1..5));
    let mut runner = TestRunner::new(config);
    let result = runner.run(&changed, |(seed, edits)| {
        let _ = parser.read(&edited(&seeds[seed], &edits, 1 << 16), folder.path());
        Ok(())
    });
    if let Err(found) = result {
        panic!("{}: {found}", parser.name);
    }
}
