//! The commands of the documents: those of the guide are run, options of all others exist.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs};

use tempfile::tempdir;

use crate::support::{Place, a_blender, shared_cache, shipped};

/// What the test does with a fenced block, by the comment above it.
#[derive(Debug, PartialEq)]
enum Mark {
    Run,
    NeedsBlender,
    NotRun,
    File(String),
}

struct Block {
    line: usize,
    language: String,
    mark: Mark,
    text: String,
}

struct Page {
    path: PathBuf,
    prose: String,
    blocks: Vec<Block>,
}

impl Page {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).expect("a document");
        let mut page = Self { path: path.to_owned(), prose: String::new(), blocks: Vec::new() };
        let mut lines = text.lines().enumerate();
        let mut above = "";
        while let Some((number, line)) = lines.next() {
            if let Some(language) = line.strip_prefix("```") {
                let inside = lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```");
                let text: String = inside.flat_map(|line| [line, "\n"]).collect();
                let mark = mark(above).unwrap_or_else(|| {
                    panic!("{}:{number}: {above} is no mark of the test", path.display())
                });
                page.blocks.push(Block {
                    line: number + 1,
                    language: language.to_owned(),
                    mark,
                    text,
                });
            } else {
                page.prose.extend([line, "\n"]);
            }
            above = line;
        }
        page
    }

    fn needs_blender(&self) -> bool {
        self.blocks.iter().any(|block| block.mark == Mark::NeedsBlender)
    }

    /// Writes the files and runs the commands, block by block, in a folder of its own.
    fn run(&self, cache: &Path, blender: Option<&Path>) {
        let place = tempdir().expect("a temporary folder");
        for folder in ["scenes", "spectra"] {
            std::os::unix::fs::symlink(root().join(folder), place.path().join(folder))
                .expect("a link");
        }
        for block in &self.blocks {
            match &block.mark {
                Mark::File(name) => {
                    let file = place.path().join(name);
                    fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
                    fs::write(file, &block.text).expect("written");
                }
                Mark::NotRun => {}
                Mark::NeedsBlender if blender.is_none() => {}
                Mark::Run if block.language != "sh" => {}
                Mark::Run | Mark::NeedsBlender => {
                    self.run_block(block, place.path(), cache, blender);
                }
            }
        }
    }

    fn run_block(&self, block: &Block, folder: &Path, cache: &Path, blender: Option<&Path>) {
        let program = Path::new(env!("CARGO_BIN_EXE_soilsig")).parent().expect("a folder");
        let mut path = program.as_os_str().to_owned();
        path.push(":");
        path.push(env::var_os("PATH").unwrap_or_default());
        let mut shell = Command::new("sh");
        shell.args(["-euc", &block.text]).current_dir(folder).stdin(Stdio::null());
        shell.env("PATH", path).env("SOILSIG_CACHE", cache);
        match blender {
            Some(blender) => shell.env("SOILSIG_BLENDER", blender),
            None => shell.env_remove("SOILSIG_BLENDER"),
        };
        let output = shell.output().expect("a shell");
        assert!(
            output.status.success(),
            "{}:{}: {}\n{}\n{}",
            self.path.display(),
            block.line,
            output.status,
            block.text,
            String::from_utf8_lossy(&output.stderr)
        );
    }

    /// Every command of soilsig on the page: lines of shell blocks, and code within the prose.
    fn commands(&self) -> Vec<String> {
        let shell = self.blocks.iter().filter(|block| block.language == "sh");
        let lines = shell.flat_map(|block| {
            let joined = block.text.replace("\\\n", " ");
            joined.lines().map(str::to_owned).collect::<Vec<_>>()
        });
        let spans = self.prose.split('`').skip(1).step_by(2).map(|span| span.replace('\n', " "));
        lines.chain(spans).filter(|command| command.starts_with("soilsig ")).collect()
    }
}

/// The mark in the line above a block; none for a comment that is not one.
fn mark(above: &str) -> Option<Mark> {
    let Some(comment) = above.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->"))
    else {
        return Some(Mark::Run);
    };
    if comment == "needs Blender" {
        return Some(Mark::NeedsBlender);
    }
    match comment.split_once(": ")? {
        ("file", name) => Some(Mark::File(name.to_owned())),
        ("not run", reason) if !reason.trim().is_empty() => Some(Mark::NotRun),
        _ => None,
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn markdown(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(markdown(&path));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The README and the guide, whose commands are run.
fn guide() -> Vec<Page> {
    let mut files = markdown(&root().join("docs/guide"));
    files.push(root().join("README.md"));
    assert!(files.len() > 5, "{files:?}");
    files.iter().map(|file| Page::read(file)).collect()
}

#[test]
fn commands_of_the_guide_run() {
    let cache = tempdir().expect("a temporary folder");
    for page in guide() {
        assert!(!page.prose.contains("```"), "{}: an indented block", page.path.display());
        for block in &page.blocks {
            let known = ["sh", "text", "json", "python"].contains(&block.language.as_str());
            assert!(known, "{}:{}: {}", page.path.display(), block.line, block.language);
            let is_shell = block.language == "sh";
            let fits = match block.mark {
                Mark::Run => true,
                Mark::NeedsBlender | Mark::NotRun => is_shell,
                Mark::File(_) => !is_shell,
            };
            assert!(fits, "{}:{}: {:?}", page.path.display(), block.line, block.mark);
        }
        page.run(cache.path(), None);
    }
}

#[test]
fn commands_of_the_guide_that_need_blender_run() {
    let Some(blender) = a_blender() else { return };
    let pages: Vec<_> = guide().into_iter().filter(Page::needs_blender).collect();
    assert!(!pages.is_empty());
    for page in pages {
        page.run(shared_cache(), Some(&blender));
    }
}

/// The mean and the half-width at 9 um of a placed scene, by `soilsig trace` and `soilsig signature`.
fn at_9_um(place: &Place, scene: &str, evaluated: &[&str]) -> [f64; 2] {
    if !place.path("table.json").exists() {
        place.run(&["trace", scene, "--out", "table.json"], 0);
    }
    let args = [&["signature", "table.json", "--range", "9-9"], evaluated].concat();
    let (csv, _) = place.run(&args, 0);
    let row: Vec<&str> = csv.lines().last().expect("a band").split(',').collect();
    [1, 3].map(|column| row[column].parse().expect("a number"))
}

#[test]
fn figures_of_the_documents_are_those_of_their_commands() {
    let page = Page::read(&root().join("docs/guide/own_scenes.md"));
    let place = Place::new();
    for block in &page.blocks {
        if let Mark::File(name) = &block.mark {
            place.write(name, &block.text);
        }
    }
    let [mean, half_width] = at_9_um(&place, "pit.json", &[]);
    let said = format!("The emissivity is {mean:.3} \u{b1} {half_width:.3},");
    assert!(page.prose.contains(&said), "own_scenes.md lacks {said:?}");

    let page = Page::read(&root().join("docs/physics/facets.md"));
    let place = Place::new();
    let rows = page.prose.split_once("| shipped patch |").expect("the table").1;
    let rows = rows.lines().skip(2).take_while(|line| line.starts_with('|'));
    let mut seen = 0;
    for row in rows {
        let fields: Vec<&str> = row.split('|').map(str::trim).collect();
        let facets = ["coarse", "fine", "floor"].map(|name| format!("{name}=0{}", fields[1]));
        let spectra = facets.each_ref().map(|facet| ["--spectrum", facet]).concat();
        let [mean, _] = at_9_um(&place, &shipped("settled_patch.json"), &spectra);
        assert_eq!(format!("{mean:.3}"), format!("0{}", fields[2]), "facets.md: {row}");
        seen += 1;
    }
    assert_eq!(seen, 5);
}

/// Also those of commands that are not run, in all documents.
#[test]
fn commands_in_the_documents_and_their_options_exist() {
    let mut files = markdown(&root().join("docs"));
    files.extend([root().join("README.md"), root().join("CONTRIBUTING.md")]);
    let mut helps = BTreeMap::new();
    let mut seen = 0;
    for page in files.iter().map(|file| Page::read(file)) {
        for command in page.commands() {
            let words: Vec<_> =
                command.split('#').next().expect("text").split_whitespace().collect();
            let wrong = unknown(&words[1..], &mut helps);
            assert_eq!(wrong, None, "{}: {command}", page.path.display());
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen} commands");
}

/// The first of the words that is no subcommand or option of soilsig.
fn unknown(words: &[&str], helps: &mut BTreeMap<String, String>) -> Option<String> {
    let mut path = String::new();
    let mut known = help(&path, helps);
    let mut words = words.iter().take_while(|word| **word != "--").peekable();
    while known.contains("\nCommands:\n")
        && let Some(word) = words.next_if(|word| !word.starts_with('-'))
    {
        if !known.lines().any(|line| line.split_whitespace().next() == Some(word)) {
            return Some((*word).to_owned());
        }
        path = format!("{path} {word}");
        known = help(&path, helps);
    }
    let options: Vec<_> = known.split(|c: char| !(c.is_ascii_lowercase() || c == '-')).collect();
    let asked = words.filter(|word| word.starts_with("--"));
    let mut asked = asked.map(|word| word.split(['=', ',']).next().expect("an option"));
    asked.find(|option| !options.contains(option)).map(str::to_owned)
}

fn help(path: &str, helps: &mut BTreeMap<String, String>) -> String {
    let print = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        let output = command.args(path.split_whitespace()).arg("--help").output().expect("it runs");
        assert!(output.status.success(), "soilsig{path} --help");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    helps.entry(path.to_owned()).or_insert_with(print).clone()
}
