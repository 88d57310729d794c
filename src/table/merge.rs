//! Parts of one trace, traced apart, put together: byte for byte the table of one run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::support::error::Error;
use crate::table::{Ended, Table, TableError};

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
    let wrong = |file: &Path, problem: String| {
        Err(TableError::Parts { path: file.to_owned(), problem }.into())
    };
    let (first, first_file) = &parts[0];
    for (part, file) in &parts {
        if !part.is_part_of_same(first) {
            let differs = part.differs_from(first).join(", ");
            let other = first_file.display();
            return wrong(
                file,
                format!("this is no part of the trace of {other}: they differ in {differs}"),
            );
        }
        let (of, wanted) = (part.stop.wanted, first.stop.wanted);
        if of != wanted {
            let other = first_file.display();
            return wrong(
                file,
                format!("it is part of a trace of {of} paths, {other} of one of {wanted}"),
            );
        }
        if part.cells.is_some() != first.cells.is_some() {
            return wrong(file, "it was counted by cells of the view and others were not".into());
        }
        if part.stop.ended_by == Ended::Interrupted {
            return wrong(file, "its trace was interrupted and is not whole".into());
        }
    }
    let mut next = 0;
    for (part, file) in &parts {
        let [from, end] = part.numbers;
        if from < next {
            return wrong(
                file,
                format!("paths {from} to {} are in another part too", next.min(end)),
            );
        }
        if from > next {
            return wrong(
                file,
                format!("paths {next} to {from} before it are in none of the parts"),
            );
        }
        next = end;
    }
    let (last, last_file) = parts.last().expect("at least one");
    if next != last.stop.wanted {
        let of = last.stop.wanted;
        return wrong(last_file, format!("paths {next} to {of} after it are in none of the parts"));
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
    whole.stop.ended_by = Ended::Paths;
    whole.judge()?;
    Ok(whole)
}
