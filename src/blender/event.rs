//! The reports of a script: lines `@soilsig {json}` among the other output of Blender.

use serde::Deserialize;

const MARK: &[u8] = b"@soilsig ";

/// One report of a script.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The versions of a Blender: the answer of `probe.py`.
    Probe {
        /// Blender's version.
        blender: String,
        /// The version of its Python.
        python: String,
        /// The version of its numpy, if there is one.
        numpy: Option<String>,
    },
    /// The progress of a stage.
    Progress {
        /// `model`, `dust`, `drop`, `check` or `export` of a bed; `bed` when a bed is finished.
        stage: String,
        /// Finished steps.
        done: u64,
        /// All steps; a stage may need fewer.
        total: u64,
    },
    /// A warning; the work goes on.
    Warning {
        /// The text for the user.
        message: String,
    },
    /// The script ends with an error.
    Error {
        /// The kind of error.
        kind: Trouble,
        /// The text for the user.
        message: String,
        /// The remedy, if the script has one.
        hint: Option<String>,
    },
    /// The last report of a success.
    Done {
        /// The files written, relative to the job's folder.
        files: Vec<String>,
    },
}

/// The kind of a script's error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Trouble {
    /// Blender's Python has no numpy.
    Numpy,
    /// The Blender is too old.
    Version,
    /// The bed failed its checks.
    #[serde(rename = "not_settled")]
    #[serde(
        alias = "escaped",
        alias = "overlap",
        alias = "sunk",
        alias = "floating",
        alias = "nan"
    )]
    Refused,
    /// Any other error.
    #[serde(other)]
    Other,
}

impl Event {
    /// Splits a line into its event and the text around it, which belongs in the log: Blender's own
    /// output may share the line.
    pub(super) fn split(line: &[u8]) -> (Option<Self>, Vec<u8>) {
        let Some(start) = line.windows(MARK.len()).position(|window| window == MARK) else {
            return (None, line.to_vec());
        };
        let (before, json) = (&line[..start], &line[start + MARK.len()..]);
        let mut values = serde_json::Deserializer::from_slice(json).into_iter::<Self>();
        let Some(Ok(event)) = values.next() else { return (None, line.to_vec()) };
        let mut around = [before, &json[values.byte_offset()..]].concat();
        if around.trim_ascii().is_empty() {
            around.clear();
        }
        (Some(event), around)
    }
}

#[cfg(test)]
mod tests {
    use super::{Event, Trouble};

    #[test]
    fn an_event_is_found_within_other_output() {
        let line = b"Fra:1 @soilsig {\"event\":\"warning\",\"message\":\"m\"} Saved: 'a.blend'\n";
        let (event, text) = Event::split(line);
        assert_eq!(event, Some(Event::Warning { message: "m".into() }));
        assert_eq!(text, b"Fra:1  Saved: 'a.blend'\n");
        let (event, text) = Event::split(b"@soilsig {\"event\":\"done\",\"files\":[\"a\"]}\n");
        assert_eq!(event, Some(Event::Done { files: vec!["a".into()] }));
        assert!(text.is_empty());
    }

    #[test]
    fn a_line_without_a_valid_event_goes_to_the_log() {
        for line in [
            &b"Blender quit\n"[..],
            b"@soilsig {\"event\":\"done\",\"fil\n",
            b"@soilsig {\"event\":\"sung\"}\n",
            b"@soilsig \n",
            b"\xff\xfe\n",
        ] {
            assert_eq!(Event::split(line), (None, line.to_vec()));
        }
    }

    #[test]
    fn an_error_of_an_unknown_kind_is_still_an_error() {
        let (event, _) =
            Event::split(b"@soilsig {\"event\":\"error\",\"kind\":\"new\",\"message\":\"m\"}");
        let message = "m".into();
        assert_eq!(event, Some(Event::Error { kind: Trouble::Other, message, hint: None }));
    }
}
