//! All tests through the library and the program, as one binary: each file or folder is a subject.

#![allow(clippy::disallowed_methods, reason = "tests write no results")]

mod bed_warnings;
mod blender_control;
mod budget;
mod changes;
mod chart;
mod chemistry;
mod closed_forms;
mod command_line;
mod diff;
mod durable;
mod dust;
mod exports;
mod failures;
mod field;

mod gltf_files;
mod grains;
mod guide;
mod hollow;
mod image;
mod independent_tracer;
mod ingest;
mod library;
mod matching;
mod messages;
mod mitsuba;
mod obj_files;
mod own_spectra;
mod packings;
mod page;
mod pictures;
mod pipeline;
mod places;
mod precision;
mod processors;
mod python;
mod radiometry;
mod readers;
mod reciprocity;
mod reference;
mod refraction;
mod retrieval;
mod rooms;
mod rules;
mod sensors;
mod separation;
mod shards;
mod spectra;
mod strangers;
mod stress;
mod support;
mod sureness;
mod window;
