//! Parts of one trace, traced apart, put together: byte for byte the table of one run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::table::{StopReason, Table, TableError};

/// Reads the tables of all parts of one trace, in any order, and adds them up.
///
/// # Errors
/// A table of another trace, or parts that overlap or leave paths out.
pub fn merge(files: &[PathBuf]) -> Result<Table, Error> {
    let mut parts: Vec<(Table, &Path)> = files
        .iter()
        .map(|file| Ok((Table::read(file)?, file.as_path())))
        .collect::<Result<_, TableError>>()?;
    parts.sort_by_key(|(table, _)| table.numbers);
    let (first, first_file) = &parts[0];
    let mut next = 0;
    for (part, file) in &parts {
        let differs = part.differs_from(first);
        let (of, wanted) = (part.stop.reached.wanted, first.stop.reached.wanted);
        let [from, end] = part.numbers;
        let other = first_file.display();
        let problem = if !differs.is_empty() {
            let keys = differs.join(", ");
            format!("this is not a part of the trace of {other}: they differ in {keys}")
        } else if of != wanted {
            format!("this is part of a trace of {of} paths, {other} of one of {wanted}")
        } else if part.cells.is_some() != first.cells.is_some() {
            "this was counted by cells of the view, and other parts were not".into()
        } else if part.stop.reached.reason == StopReason::Interrupted {
            "its trace was interrupted and is not complete".into()
        } else if from < next {
            format!("paths {from} to {} are in another part too", next.min(end))
        } else if from > next {
            format!("paths {next} to {from} before it are in none of the parts")
        } else {
            next = end;
            continue;
        };
        return Err(TableError::Parts(FileError::wrong(file, problem)).into());
    }
    let (last, last_file) = parts.last().expect("at least one");
    let wanted = last.stop.reached.wanted;
    if next != wanted {
        let problem = format!("paths {next} to {wanted} after it are in none of the parts");
        return Err(TableError::Parts(FileError::wrong(last_file, problem)).into());
    }
    let names: BTreeSet<&str> = parts
        .iter()
        .flat_map(|(table, _)| &table.inside)
        .flat_map(|inside| inside.from.as_deref().into_iter().chain([&*inside.solid]))
        .collect();
    let names: Vec<&str> = names.into_iter().collect();
    let mut tally = first.tally(&names);
    for (part, _) in &parts[1..] {
        tally.add(&part.tally(&names));
    }
    let mut whole = first.clone();
    whole.count(&tally, &names);
    whole.numbers = [0, next];
    whole.stop.reached.reason = StopReason::Paths;
    whole.judge()?;
    Ok(whole)
}
