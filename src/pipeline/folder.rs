//! The folder of a scene's result: whatever is read or written there is recorded.

use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::inputs;
use super::record::{Output, Record, Stage};
use crate::support::error::Error;
use crate::support::monitor::{Monitor, Step};
use crate::support::output::{self, OutputError};
use crate::support::ro_crate;

/// Files of a drop that differ from run to run: they hold times of day, durations, the command
/// or, as Blender's own file does, addresses in memory.
const NOT_REPRODUCIBLE: [&str; 5] =
    ["blender.log", "drop.json", "scene.blend", super::page::PAGE, ro_crate::FILE];

/// Begin of the names of logs of Blenders that run or failed.
pub(super) const UNFINISHED: &str = "blender.unfinished";

/// The one place of the pipeline that writes files: they are made in a hidden folder of the result's
/// own, and put into their places when all are there.
pub(super) struct Folder<'a> {
    /// The folder of the whole run.
    pub(super) out: &'a Path,
    /// Where the files of the run are until it is done.
    pub(super) new: &'a Path,
    /// Folder of this scene below either, empty where there is only one scene.
    pub(super) below: &'a str,
    pub(super) record: &'a mut Record,
    pub(super) monitor: &'a dyn Monitor,
}

impl<'a> Folder<'a> {
    /// A name in the record, told apart where there are several scenes.
    pub(super) fn key(&self, name: &str) -> String {
        if self.below.is_empty() { name.to_owned() } else { format!("{}/{name}", self.below) }
    }

    /// The path of a file of this run, until the run is done.
    pub(super) fn place(&self, file: &str) -> PathBuf {
        self.new.join(self.below).join(file)
    }

    /// The log of a Blender that runs or failed; that of a finished bed is `blender.log`.
    pub(super) fn running_log(&self, number: usize) -> PathBuf {
        let scene = if self.below.is_empty() { String::new() } else { format!(".{}", self.below) };
        let number = if number == 0 { String::new() } else { format!(".{}", number + 1) };
        self.out.join(format!("{UNFINISHED}{scene}{number}.log"))
    }

    /// Records a file that is read.
    pub(super) fn reads(&mut self, file: &Path) -> Result<(), Error> {
        let sum = output::sha256_hex(file)?;
        self.record.inputs.insert(file.display().to_string(), sum);
        Ok(())
    }

    /// Refuses to write these files over what the run reads.
    pub(super) fn keeps_inputs(&self, files: &[&str]) -> Result<(), Error> {
        let written = files.iter().map(|file| self.out.join(self.below).join(file));
        Ok(output::keeps(self.record.inputs.keys(), written)?)
    }

    /// Writes a file.
    pub(super) fn write(&mut self, file: &str, content: impl AsRef<[u8]>) -> Result<(), Error> {
        output::scratch(&self.place(file), content).map_err(|error| self.of(file, error.source))?;
        self.wrote(file)
    }

    /// Copies a file here.
    pub(super) fn copy(&mut self, from: &Path, file: &str) -> Result<(), Error> {
        let place = self.place(file);
        let copy = || {
            std::fs::create_dir_all(place.parent().expect("it is in a folder"))?;
            std::fs::copy(from, &place)
        };
        copy().map_err(|source| self.of(file, source))?;
        self.wrote(file)
    }

    /// Copies all files that were read, so that the result can be made again anywhere.
    pub(super) fn copy_inputs(&mut self) -> Result<(), Error> {
        let inputs = self.record.inputs.clone();
        for (from, place) in inputs::places(inputs.keys()) {
            self.copy(Path::new(from), &place)?;
            if self.record.outputs[&self.key(&place)].sha256 != inputs[from] {
                let source = io::Error::other("it was changed during the run: run it again");
                return Err(OutputError { path: from.into(), source }.into());
            }
        }
        Ok(())
    }

    /// Writes what the files are and which run made them, for other programs.
    pub(super) fn write_crate(&mut self, started: SystemTime) -> Result<(), Error> {
        let record = &*self.record;
        let names: Vec<&str> = record.reached.keys().map(String::as_str).collect();
        let is_input = |file: &str| file.starts_with(inputs::INPUTS);
        let (inputs, outputs) = (record.outputs.iter())
            .map(|(file, output)| (file.clone(), Some(output.sha256.clone())))
            .partition::<Vec<_>, _>(|(file, _)| is_input(file));
        let run = ro_crate::Run {
            name: &names.join(", "),
            description: format!(
                "Thermal-infrared emissivity of {}, computed from the geometry of its grains",
                names.join(", ")
            ),
            command: &record.command,
            started,
            versions: &record.versions,
            inputs,
            outputs: [outputs, vec![(super::RUN.into(), None)]].concat(),
            folders: Vec::new(),
        };
        let text = run.text();
        self.write(ro_crate::FILE, text)
    }

    /// An error that names the file by its final place.
    fn of(&self, file: &str, source: io::Error) -> OutputError {
        OutputError { path: self.out.join(self.key(file)), source }
    }

    fn wrote(&mut self, file: &str) -> Result<(), Error> {
        let sha256 = output::sha256_hex(&self.place(file))?;
        let name = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
        let reproducible = !NOT_REPRODUCIBLE.contains(&&*name);
        self.record.outputs.insert(self.key(file), Output { sha256, reproducible });
        Ok(())
    }

    /// Removes what was made below a folder.
    pub(super) fn remove(&mut self, below: &str) -> Result<(), Error> {
        let below = self.key(below);
        for file in self.record.outputs.keys().filter(|file| file.starts_with(&below)) {
            output::remove(&self.new.join(file))?;
        }
        self.record.outputs.retain(|file, _| !file.starts_with(&below));
        Ok(())
    }

    /// Begins a stage.
    pub(super) fn begin(&self, stage: &str) -> Step<'a> {
        Step::new(self.monitor, &self.key(stage))
    }

    /// Ends a stage and records it.
    pub(super) fn end(&mut self, stage: &str, step: Step, note: &str, cached: bool) {
        let seconds = step.done(if cached { "from the cache" } else { note });
        self.record.stages.push(Stage { name: self.key(stage), seconds, cached });
    }
}
