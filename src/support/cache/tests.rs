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

#[test]
fn a_manifest_names_plain_files_of_its_own_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cache = Cache::new(folder.path().join("cache"));
    let made = || {
        let made = cache.stage("s", &1, |at| Ok(output::bytes(&at.join("file"), b"whole")?));
        made.expect("made")
    };
    let entry = made().folder;
    let mine = folder.path().join("mine");
    std::fs::write(&mine, "mine").expect("written");
    std::os::unix::fs::symlink(&mine, entry.join("link")).expect("a link");
    let sum = output::sha256_hex(&mine).expect("read");
    for name in ["../../mine", "link", &mine.display().to_string(), ".."] {
        let text = serde_json::json!({ name: sum }).to_string();
        std::fs::create_dir_all(&entry).expect("made");
        std::fs::write(entry.join(MANIFEST), text).expect("written");
        let made = made();
        assert!(!made.cached && made.files == ["file"], "{name}");
    }
    assert_eq!(std::fs::read(mine).expect("kept"), b"mine");
}

#[test]
fn what_was_not_used_for_longest_goes_when_the_limit_is_passed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let make = |cache: &Cache, stage: &str, number: u32| {
        let fill = |at: &Path| Ok(output::bytes(&at.join("file"), &[0; 1000])?);
        cache.stage(stage, &number, fill).expect("made").folder
    };
    let cache = Cache { limit: 3500, ..Cache::new(folder.path().join("cache")) };
    let made: Vec<PathBuf> = (0..3).map(|number| make(&cache, "s", number)).collect();
    for (folder, hours) in made.iter().zip([4, 6, 5]) {
        let file = std::fs::File::open(folder.join(MANIFEST)).expect("there");
        let then = SystemTime::now() - Duration::from_secs(3600 * hours);
        file.set_modified(then).expect("set");
    }
    // The oldest is looked for, which makes it the newest.
    assert!(cache.look("s", &1).expect("it is read").is_some());
    make(&cache, "t", 3);
    assert_eq!(made.iter().map(|folder| folder.is_dir()).collect::<Vec<_>>(), [true, true, false]);
    // The rest are in use, or within the limit.
    assert_eq!(cache.entries().expect("listed").len(), 3);
    assert_eq!(cache.clear(Some("t")).expect("cleared").0, 1);
    assert_eq!(cache.clear(None).expect("cleared").0, 2);
    assert_eq!(output::list(cache.root()).expect("a folder"), [""; 0]);
}

#[test]
fn sizes_are_written_with_a_letter() {
    let all = ["500M", "20G", "2 tb", "1000", "1.5k"].map(bytes);
    assert_eq!(all, [500e6, 20e9, 2e12, 1e3, 1.5e3].map(|n| Some(n as u64)));
    assert_eq!(["", "G", "-1G", "much"].map(bytes), [None; 4]);
}
