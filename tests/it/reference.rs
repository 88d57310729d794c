//! The pages of docs/reference are made from the schemas and the lists of columns in the code.
//!
//! `SOILSIG_WRITE_REFERENCE=1 cargo test --test it reference` writes them anew; else they must be
//! as they are written.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Map, Value};
use soilsig::cli::schema::{self, Format};
use soilsig::support::error::Status;

/// Compares a page with its file, or writes it.
fn keep(name: &str, page: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference").join(name);
    if std::env::var_os("SOILSIG_WRITE_REFERENCE").is_some() {
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(&path, page).expect("written");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "{} is not what the code says: SOILSIG_WRITE_REFERENCE=1 cargo test --test it reference",
        path.display()
    );
}

/// A text of several lines as one paragraph of at most 100 columns, indented.
fn wrapped(text: &str, first: &str, indent: &str) -> String {
    let mut lines = vec![first.to_owned()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is one");
        let is_empty = line.trim().is_empty() || line.ends_with("- ");
        if line.len() + word.len() < 100 || is_empty {
            if !is_empty {
                line.push(' ');
            }
            line.push_str(word);
        } else {
            lines.push(format!("{indent}{word}"));
        }
    }
    lines.join("\n") + "\n"
}

struct Schema<'a>(&'a Value);

impl Schema<'_> {
    fn text(&self, key: &str) -> &str {
        self.0.get(key).and_then(Value::as_str).unwrap_or_default()
    }

    fn has(&self, key: &str) -> bool {
        self.0.get(key).is_some()
    }

    fn list(&self, key: &str) -> &[Value] {
        self.0.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    /// What a value is, in words, with links to the definitions.
    fn kind(&self) -> String {
        if let Some((page, name)) = self.text("$ref").split_once("/$defs/") {
            let anchor = if page.ends_with('#') { name.to_lowercase() } else { String::new() };
            return format!("[{name}]({page}{anchor})");
        }
        if self.has("const") {
            return format!("`{}`", self.0["const"]);
        }
        let others = ["anyOf", "oneOf"].iter().flat_map(|key| self.list(key));
        let kinds: Vec<String> =
            others.map(|other| Schema(other).kind()).filter(|kind| !kind.is_empty()).collect();
        if !kinds.is_empty() {
            return kinds.join(" or ");
        }
        let types: Vec<&str> = match &self.0["type"] {
            Value::String(one) => vec![one],
            Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
            _ => vec!["any value"],
        };
        let named = types.into_iter().filter(|of| *of != "null").map(|of| self.named(of));
        named.collect::<Vec<_>>().join(" or ")
    }

    fn named(&self, of: &str) -> String {
        let number = |key: &str| {
            let text = self.0.get(key)?.to_string();
            Some(text.strip_suffix(".0").unwrap_or(&text).to_owned())
        };
        match of {
            "array" => {
                let items = self.0.get("items").map_or("values".into(), |of| Schema(of).kind());
                match (number("minItems"), number("maxItems")) {
                    (Some(least), Some(most)) if least == most => format!("{least} of: {items}"),
                    (Some(least), _) if least != "0" => format!("list of {least} or more: {items}"),
                    _ => format!("list of: {items}"),
                }
            }
            "object" => match self.0.get("additionalProperties") {
                Some(of @ Value::Object(_)) => format!("by name: {}", Schema(of).kind()),
                _ if self.has("properties") => {
                    let keys = self.0["properties"].as_object().expect("keys").keys();
                    format!(
                        "object with {}",
                        keys.map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ")
                    )
                }
                _ => "object".into(),
            },
            "number" | "integer" => {
                let above = number("exclusiveMinimum").map(|x| format!("above {x}"));
                let least = number("minimum").map(|x| format!("{x} or more"));
                let most = number("maximum").map(|x| format!("at most {x}"));
                let below = number("exclusiveMaximum").map(|x| format!("below {x}"));
                let range: Vec<String> =
                    [above, least, most, below].into_iter().flatten().collect();
                if range.is_empty() { of.into() } else { format!("{of}, {}", range.join(", ")) }
            }
            other => other.into(),
        }
    }

    /// A list item for each key.
    fn keys(&self, page: &mut String, indent: &str) {
        let Some(properties) = self.0.get("properties").and_then(Value::as_object) else { return };
        let required: Vec<&str> = self.list("required").iter().filter_map(Value::as_str).collect();
        for (key, value) in properties {
            let schema = Schema(value);
            let default = value.get("default").filter(|value| !value.is_null());
            let needed = if required.contains(&key.as_str()) {
                ", required".into()
            } else {
                default.map_or(String::new(), |value| format!(", default `{value}`"))
            };
            let text =
                format!("`{key}` ({}{needed}): {}", schema.kind(), schema.text("description"));
            *page += &wrapped(&text, &format!("{indent}- "), &format!("{indent}  "));
            if schema.text("type") == "object" && schema.has("properties") {
                schema.keys(page, &format!("{indent}  "));
            }
        }
    }

    /// Sentences, keys and alternatives.
    fn body(&self, page: &mut String) {
        let description = self.text("description");
        if !description.is_empty() {
            *page += "\n";
            for paragraph in description.split("\n\n") {
                *page += &wrapped(paragraph, "", "");
                *page += "\n";
            }
        }
        self.keys(page, "");
        for other in ["anyOf", "oneOf"].iter().flat_map(|key| self.list(key)) {
            let schema = Schema(other);
            let text = match schema.kind() {
                kind if schema.has("properties") => {
                    let keys = other["properties"].as_object().expect("keys");
                    let of: Vec<String> = keys
                        .iter()
                        .map(|(key, value)| {
                            format!("`{{\"{key}\": ...}}` with {}", Schema(value).kind())
                        })
                        .collect();
                    drop(kind);
                    format!("{}: {}", of.join(", "), schema.text("description"))
                }
                kind => format!("{kind}: {}", schema.text("description")),
            };
            *page += &wrapped(&text, "- ", "  ");
            for value in
                other.get("properties").and_then(Value::as_object).into_iter().flat_map(Map::values)
            {
                Schema(value).keys(page, "  ");
            }
        }
    }
}

/// A page of a JSON Schema: the whole, then its parts by name. Parts that stand alike on another page
/// are there only.
fn page_of(title: &str, intro: &str, schema: &Value, others: &[(&str, Format)]) -> String {
    let others: Vec<_> = others.iter().map(|(file, of)| (*file, schema::of(*of))).collect();
    let parts = schema.get("$defs").and_then(Value::as_object).into_iter().flatten();
    let mut text = schema.to_string();
    let mut own = Vec::new();
    for (name, part) in parts {
        let here = format!("\"#/$defs/{name}\"");
        let is_alike = |of: &Value| of["$defs"].get(name) == Some(part);
        if let Some((file, _)) = others.iter().find(|(_, of)| is_alike(of)) {
            text = text.replace(&here, &here.replace('#', &format!("{file}#")));
        } else if let Some((file, _)) = others.iter().find(|(_, of)| is_whole(part, of)) {
            text = text.replace(&here, &here.replace('#', file));
        } else {
            own.push(name);
        }
    }
    let schema: Value = serde_json::from_str(&text).expect("JSON");
    let mut page = format!("# {title}\n\n{}", wrapped(intro, "", ""));
    Schema(&schema).body(&mut page);
    for name in own {
        let _ = write!(page, "\n## {name}\n");
        Schema(&schema["$defs"][name]).body(&mut page);
    }
    page
}

/// Whether a part is all of another schema.
fn is_whole(part: &Value, schema: &Value) -> bool {
    let mut whole = schema.clone();
    let keys = whole.as_object_mut().expect("a schema");
    for key in ["$schema", "$defs", "title"] {
        keys.remove(key);
    }
    *part == whole
}

#[test]
fn scene_files_are_documented_by_their_schema() {
    let intro = "A scene file says what is looked at, what it is made of, from where, and at which temperature. It is \
                 JSON; keys that are not known are refused. This page is made from the schema that `soilsig schema \
                 scene` prints. [Own scenes](../guide/own_scenes.md) shows how to write one.";
    keep("scene.md", &page_of("Scene files", intro, &schema::of(Format::Scene), &[]));
}

const STUDY: (&str, Format) = ("study.md", Format::Study);
const RUN: (&str, Format) = ("results.md", Format::Run);

#[test]
fn results_are_documented_by_their_schemas_and_columns() {
    let intro = "Every run writes `run.json`: what was done, with what, and what came out, enough to do it again. \
                 This page is made from the schema that `soilsig schema run` prints. [Reading \
                 results](../guide/reading_results.md) explains the numbers, and [files of numbers](columns.md) the \
                 columns.";
    keep("results.md", &page_of("The record of a run", intro, &schema::of(Format::Run), &[STUDY]));
    let intro = "`soilsig match` writes `match.json`. This page is made from the schema that `soilsig schema match` \
                 prints. [Matching](../guide/matching.md) shows how to read it.";
    keep("match.md", &page_of("The result of a match", intro, &schema::of(Format::Match), &[]));
    let intro = "`soilsig sweep` reads a study file. This page is made from the schema that `soilsig schema study` \
                 prints. [Sweeps](../guide/sweeps.md) shows studies.";
    keep("study.md", &page_of("The study file", intro, &schema::of(Format::Study), &[]));
    let intro = "`soilsig sweep` writes `sweep.json`, enough to do the sweep again. This page is made from the schema \
                 that `soilsig schema sweep` prints. [Sweeps](../guide/sweeps.md) explains the files.";
    keep(
        "sweep.md",
        &page_of("The record of a sweep", intro, &schema::of(Format::Sweep), &[STUDY, RUN]),
    );
    let mut page = "# Files of numbers\n\n".to_owned();
    page += &wrapped(
        "Columns of the CSV files, from the lists that the program writes them by. What is not known, and bands that \
         are masked, have empty fields.",
        "",
        "",
    );
    for (file, columns) in schema::column_lists() {
        let _ = write!(page, "\n## {file}\n\n");
        for (name, meaning) in columns {
            page += &wrapped(&format!("`{name}`: {meaning}"), "- ", "  ");
        }
    }
    keep("columns.md", &page);
}

#[test]
fn every_exit_status_is_documented() {
    let mut page = "# Exit statuses\n\n".to_owned();
    page += &wrapped("Scripts can tell failures apart by the exit status of the program.", "", "");
    page += "\n| status | name | meaning |\n|---|---|---|\n| 0 | Success | all that was asked for is done |\n";
    for (status, meaning) in Status::ALL {
        let _ = writeln!(page, "| {} | {status:?} | {meaning} |", status as u8);
    }
    keep("exit_statuses.md", &page);
}

/// What is promised of files, processes and strangers, with the test that keeps it: the file of the
/// test and its name.
const PROMISES: &[(&str, &str, &str)] = &[
    (
        "A record does not choose the program that replays it",
        "tests/it/strangers.rs",
        "a_record_does_not_choose_the_program_that_replays_it",
    ),
    (
        "The list of known Blenders does not choose the program",
        "tests/it/strangers.rs",
        "a_list_of_known_blenders_does_not_choose_the_program",
    ),
    (
        "A record deletes only what a run wrote, by name and SHA-256",
        "tests/it/strangers.rs",
        "a_record_deletes_only_what_a_run_wrote_there",
    ),
    (
        "No link inside a folder of results is followed",
        "tests/it/strangers.rs",
        "no_link_inside_a_result_is_written_through",
    ),
    (
        "A cache that others may write to is refused",
        "tests/it/strangers.rs",
        "a_cache_of_others_is_refused",
    ),
    (
        "The manifest of the cache names plain files of its own folder",
        "src/support/cache/tests.rs",
        "a_manifest_names_plain_files_of_its_own_folder",
    ),
    (
        "A record by another hand is refused by its key",
        "tests/it/strangers.rs",
        "a_record_by_another_hand_is_refused_by_its_key",
    ),
    (
        "Devices named as inputs of a record are not read",
        "tests/it/strangers.rs",
        "an_input_of_a_record_that_is_no_file_is_not_read",
    ),
    (
        "Names from files do not steer the terminal",
        "tests/it/strangers.rs",
        "names_of_strangers_do_not_steer_the_terminal",
    ),
    ("A name of any length is printed", "tests/it/strangers.rs", "a_name_of_any_length_is_printed"),
    (
        "Temporary folders are of their owner alone",
        "src/support/scratch.rs",
        "temporary_folders_are_of_their_owner_alone",
    ),
    (
        "Without a home the cache lasts for the run",
        "tests/it/places.rs",
        "a_cache_is_in_a_place_of_the_users_own",
    ),
    (
        "Devices and pipes are written to and stay",
        "tests/it/places.rs",
        "devices_and_pipes_are_written_to_and_stay",
    ),
    (
        "Links in `--out` are followed, and modes are kept",
        "tests/it/places.rs",
        "links_are_followed_and_modes_are_kept",
    ),
    (
        "Other names of a file (hard links) keep its earlier content",
        "tests/it/places.rs",
        "links_are_followed_and_modes_are_kept",
    ),
    (
        "No result is written over what it is made of",
        "tests/it/command_line.rs",
        "no_result_is_written_over_what_it_is_made_of",
    ),
    (
        "One run at a time writes into a folder",
        "tests/it/places.rs",
        "a_folder_that_another_run_has_is_refused_with_its_process",
    ),
    (
        "Runs that race do not mix",
        "tests/it/places.rs",
        "runs_that_race_for_a_folder_and_a_cache_do_not_mix",
    ),
    (
        "A killed run leaves no half result",
        "tests/it/durable.rs",
        "a_killed_run_leaves_no_half_result",
    ),
    (
        "The run after a killed one clears up",
        "tests/it/durable.rs",
        "a_killed_run_leaves_no_half_result",
    ),
    (
        "A write that fails leaves the earlier result as it was",
        "tests/it/durable.rs",
        "a_write_that_fails_leaves_the_earlier_result_as_it_was",
    ),
    (
        "A standard error that cannot be written costs no result",
        "tests/it/places.rs",
        "a_standard_error_that_cannot_be_written_costs_no_result",
    ),
    (
        "A signal is heard while a read waits",
        "tests/it/places.rs",
        "a_signal_is_heard_while_a_read_waits",
    ),
    (
        "Blender does not outlive a killed soilsig",
        "tests/it/blender_control/jobs.rs",
        "blender_does_not_outlive_a_killed_soilsig",
    ),
    (
        "A Blender that hangs is ended with all its children",
        "tests/it/blender_control/jobs.rs",
        "a_hang_is_ended_with_all_its_children",
    ),
    (
        "If one of several Blenders fails, all end",
        "tests/it/places.rs",
        "a_blender_that_fails_ends_the_others",
    ),
    (
        "The log of an earlier result stays as it was recorded",
        "tests/it/places.rs",
        "an_interrupted_drop_leaves_the_earlier_log",
    ),
    (
        "The table is the same for any number of threads",
        "tests/it/command_line.rs",
        "the_table_is_the_same_for_any_number_of_threads",
    ),
    (
        "A killed sweep goes on where it was",
        "tests/it/sweep.rs",
        "a_killed_sweep_goes_on_where_it_was",
    ),
    (
        "Parts of a sweep give the bytes of one run",
        "tests/it/sweep.rs",
        "parts_side_by_side_give_the_bytes_of_one_run_and_no_bed_is_made_twice",
    ),
    (
        "A bundle is made again with nothing else at hand",
        "tests/it/sweep.rs",
        "a_bundle_is_made_again_with_nothing_else_at_hand",
    ),
    (
        "Results do not depend on the processor's instruction set",
        "tests/it/processors.rs",
        "results_do_not_depend_on_the_instruction_set",
    ),
    (
        "A limit on time holds for a field too",
        "tests/it/field.rs",
        "a_limit_on_time_holds_for_a_field_and_its_patch_alone",
    ),
    (
        "No changed input makes a reader panic or hang",
        "tests/it/fuzz/mod.rs",
        "no_parser_panics_or_hangs_on_changed_inputs",
    ),
    (
        "The order of keys in JSON does not matter",
        "tests/it/round_trips.rs",
        "the_order_of_keys_does_not_matter",
    ),
    (
        "Spectra are read as they were written, bit for bit",
        "tests/it/round_trips.rs",
        "spectra_are_read_as_they_were_written",
    ),
    (
        "Images are read as they were written, bit for bit",
        "tests/it/round_trips.rs",
        "images_are_read_as_they_were_written",
    ),
    (
        "Scenes and records are read as they were written",
        "tests/it/round_trips.rs",
        "scenes_and_records_are_read_as_they_were_written",
    ),
    (
        "Tables are read as they were written",
        "tests/it/round_trips.rs",
        "tables_are_read_as_they_were_written",
    ),
    (
        "No quantity but emissivity and reflectance is read as one of them",
        "tests/it/own_spectra.rs",
        "what_is_no_emissivity_is_refused_and_quantity_settles_what_is_not_known",
    ),
    (
        "A word or sign that changes a quantity is refused",
        "tests/it/own_spectra.rs",
        "a_word_or_sign_that_changes_a_quantity_makes_it_unclear",
    ),
    (
        "A unit of wavelength is heard, or refused if it is not known",
        "tests/it/own_spectra.rs",
        "units_are_heard_without_brackets_and_unknown_ones_are_refused",
    ),
    (
        "An image of another quantity than radiance is refused",
        "tests/it/retrieval.rs",
        "an_image_of_another_quantity_is_refused",
    ),
    (
        "Numbers of an image that are no radiance are refused",
        "tests/it/retrieval.rs",
        "numbers_of_an_image_that_are_no_radiance_are_refused_or_warned_of",
    ),
    (
        "No radiance becomes NaN, and no faint one is lost",
        "tests/it/retrieval.rs",
        "radiances_at_the_edge_of_numbers_are_no_nan_and_faint_ones_are_not_lost",
    ),
    (
        "A mesh is the same in every encoding and with every line end",
        "tests/it/obj_files.rs",
        "a_pit_is_read_in_every_encoding_and_with_every_line_end",
    ),
    ("Lines and points are no faces", "tests/it/obj_files.rs", "what_is_no_surface_is_passed_over"),
    (
        "glTF instances are placed",
        "tests/it/gltf_files.rs",
        "instances_on_the_graphics_card_are_placed",
    ),
    (
        "Figures of the documents come from their commands",
        "tests/it/guide.rs",
        "figures_of_the_documents_are_those_of_their_commands",
    ),
    (
        "glTF morph targets are added",
        "tests/it/gltf_files.rs",
        "morph_targets_are_added_by_their_weights",
    ),
    ("glTF skins are refused", "tests/it/gltf_files.rs", "skins_are_refused"),
    (
        "glTF numbers that are not all there are refused",
        "tests/it/gltf_files.rs",
        "numbers_that_are_not_all_there_are_refused",
    ),
    (
        "glTF nodes in a ring or below two others are refused at once",
        "tests/it/gltf_files.rs",
        "nodes_that_are_no_tree_are_refused_at_once",
    ),
    (
        "A bed that needs more memory than is free is refused before",
        "tests/it/gltf_files.rs",
        "a_bed_for_which_there_is_no_memory_is_refused_before_it_takes_any",
    ),
    (
        "An image that no disk or memory holds is refused before the work",
        "tests/it/image.rs",
        "bands_and_sizes_that_no_machine_holds_are_refused_before_the_work",
    ),
    (
        "Bands in which grains let light through are marked and warned of",
        "tests/it/image.rs",
        "bands_in_which_grains_let_light_through_are_marked_and_warned_of",
    ),
    (
        "One table of several beds knows that beds differ",
        "tests/it/budget.rs",
        "a_single_table_of_a_drawn_bed_knows_that_others_differ",
    ),
    (
        "Blender's time limit holds while it is asked what it is",
        "tests/it/places.rs",
        "a_blender_that_does_not_answer_is_ended_at_the_users_limit",
    ),
    (
        "A missing folder for temporary files is named",
        "tests/it/places.rs",
        "a_missing_folder_for_temporary_files_is_named",
    ),
    (
        "A full disk is told with what names it: --out, TMPDIR or cache",
        "tests/it/durable.rs",
        "a_write_that_fails_leaves_the_earlier_result_as_it_was",
    ),
];

#[test]
fn every_promise_has_a_test_that_keeps_it() {
    let mut page = "# Promises\n\n".to_owned();
    page += &wrapped(
        "What soilsig promises of files, processes and strangers' files, and the test that keeps it. \
         `make torture` does what the tests of kills and failing writes do for longer, and `make \
         fuzz` what those of changed inputs do. SECURITY.md says what a stranger's file can do.",
        "",
        "",
    );
    page += "\n| promise | test |\n|---|---|\n";
    for (promise, file, test) in PROMISES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let code = fs::read_to_string(&path).expect(file);
        // Those of modules and of properties stand further in.
        let is_there = ["", "    "].map(|indent| format!("#[test]\n{indent}fn {test}("));
        assert!(is_there.iter().any(|at| code.contains(at)), "{test} is not in {file}");
        let _ = writeln!(page, "| {promise} | `{test}` |");
    }
    keep("promises.md", &page);
}
