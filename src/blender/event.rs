//! What a script tells while it runs: lines `@soilsig {json}` among whatever Blender prints.

use serde::{Deserialize, Serialize};

const MARK: &[u8] = b"@soilsig ";

/// One report of a script.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// What the Blender is: the answer of `probe.py`.
    Probe {
        /// Blender's version.
        blender: String,
        /// The version of its Python.
        python: String,
        /// The version of its numpy, if there is one.
        numpy: Option<String>,
    },
    /// How far a stage has come.
    Progress {
        /// `model`, `dust`, `drop`, `check` or `export` of a bed; `bed` when one of several is done.
        stage: String,
        /// Steps done.
        done: u64,
        /// Steps in all; a stage may end before them.
        total: u64,
    },
    /// Something the user should know; the work goes on.
    Warning {
        /// For the user.
        message: String,
    },
    /// The script gives up.
    Error {
        /// What sort of trouble.
        kind: Trouble,
        /// For the user.
        message: String,
        /// The remedy, if the script knows one.
        hint: Option<String>,
    },
    /// The last line of a success.
    Done {
        /// Files written, relative to the job's folder.
        files: Vec<String>,
    },
}

/// Why a script gave up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Trouble {
    /// The scene asks for something that cannot be made.
    Scene,
    /// Blender's Python has no numpy.
    Numpy,
    /// The Blender is too old.
    Version,
    /// The grains did not come to rest.
    NotSettled,
    /// Grains left the tray.
    Escaped,
    /// Grains sank into each other.
    Overlap,
    /// Grains sank into the tray.
    Sunk,
    /// Grains hang in the air.
    Floating,
    /// A position is not a number.
    Nan,
    /// Anything else.
    #[serde(other)]
    Internal,
}

impl Event {
    /// Splits a line into the event in it and the text around the event, which belongs in the log.
    ///
    /// Blender flushes on its own account, so that its words can stand before or behind an event.
    pub(super) fn split(line: &[u8]) -> (Option<Self>, Vec<u8>) {
        let Some(start) = line.windows(MARK.len()).position(|window| window == MARK) else {
            return (None, line.to_vec());
        };
        let (before, json) = (&line[..start], &line[start + MARK.len()..]);
        let mut values = serde_json::Deserializer::from_slice(json).into_iter::<Self>();
        match values.next() {
            Some(Ok(event)) => {
                let around = [before, &json[values.byte_offset()..]].concat();
                let text = if around.trim_ascii().is_empty() { Vec::new() } else { around };
                (Some(event), text)
            }
            _ => (None, line.to_vec()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Event, Trouble};

    #[test]
    fn an_event_is_found_among_the_words_of_blender() {
        let line = b"Fra:1 @soilsig {\"event\":\"warning\",\"message\":\"m\"} Saved: 'a.blend'\n";
        let (event, text) = Event::split(line);
        assert_eq!(event, Some(Event::Warning { message: "m".into() }));
        assert_eq!(text, b"Fra:1  Saved: 'a.blend'\n");
        let (event, text) = Event::split(b"@soilsig {\"event\":\"done\",\"files\":[\"a\"]}\n");
        assert_eq!(event, Some(Event::Done { files: vec!["a".into()] }));
        assert!(text.is_empty());
    }

    #[test]
    fn garbage_is_text_for_the_log() {
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
        assert_eq!(event, Some(Event::Error { kind: Trouble::Internal, message, hint: None }));
    }
}
