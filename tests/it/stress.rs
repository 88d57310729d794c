//! The atlas of failure: where each row breaks, and that the tool says so before, or where, the
//! error is beyond what the result claims.

use std::collections::BTreeSet;
use std::path::PathBuf;

use assert_cmd::Command;
use insta::assert_snapshot;
use soilsig::studies::stress::{self, Point, Row, Setting};
use soilsig::support::cache::Cache;
use soilsig::support::monitor::Unwatched;

use crate::support::{
    real_blenders, shared_cache, without_fractions, without_numbers, without_places,
};

fn swept(name: &str, blender: Option<&std::path::Path>) -> Row {
    // Its results are its own; which Blender is which is known once for all rows.
    let cache = Cache::new(shared_cache().to_owned());
    let without_blender = blender.is_none();
    let setting =
        Setting { quick: true, cache: &cache, blender, without_blender, monitor: &Unwatched };
    stress::row(name, &setting).expect("it is swept")
}

/// Sweeps a row: it must reach a place where the method fails, and say so wherever it does.
fn row(name: &str) -> Row {
    let row = swept(name, None);
    let fails = |p: &Point| p.is_broken() || p.is_refused();
    assert!(row.points.iter().any(fails), "{name} nowhere comes to its failure");
    assert_no_silence(&row);
    row
}

fn assert_no_silence(row: &Row) {
    assert!(row.silent().is_empty(), "{}: {:?}", row.name, row.silent());
    for point in row.points.iter().filter(|p| p.is_refused()) {
        assert!(point.said.is_some(), "{}: a refusal without words at {}", row.name, point.x);
    }
}

/// The point at a place of the sweep.
fn at(row: &Row, x: f64) -> &Point {
    let near = |p: &&Point| (p.x - x).abs() <= 1e-9 * x.abs();
    row.points.iter().find(near).unwrap_or_else(|| panic!("{}: no point at {x}", row.name))
}

/// That nothing was said there, and nothing was wrong.
fn assert_harmless(row: &Row, x: f64) {
    let point = at(row, x);
    assert!(!point.is_broken() && !point.is_refused(), "{}: {point:?}", row.name);
    assert_eq!(point.said, None, "{} at {x}", row.name);
}

/// That it is broken there, and that something is said. What is said is in the row's snapshot.
fn assert_broken_and_said(row: &Row, x: f64) {
    let point = at(row, x);
    assert!(point.is_broken() && point.said.is_some(), "{}: {point:?}", row.name);
}

fn assert_refused(row: &Row, x: f64, status: u8) {
    let point = at(row, x);
    assert!(point.is_refused() && point.said.is_some(), "{}: {point:?}", row.name);
    assert_eq!(point.status, status, "{} at {x}", row.name);
}

/// What is said along the row, for a snapshot.
fn said(row: &Row) -> String {
    let said = |point: &Point| {
        let said = without_fractions(point.said.as_deref().unwrap_or("-"));
        format!("{}: {}\n", point.x, without_places(&said))
    };
    row.points.iter().map(said).collect()
}

#[test]
fn eq_2_masks_bands_where_the_sky_is_near_the_target() {
    let row = row("sky_nears_target");
    for sky_k in [100.0, 200.0, 260.0, 340.0] {
        assert_harmless(&row, sky_k);
    }
    for sky_k in [298.0, 300.0, 302.0] {
        assert_refused(&row, sky_k, 0);
    }
    assert_snapshot!(said(&row));
}

#[test]
fn a_wrong_temperature_of_quartz_is_seen_where_it_is_black() {
    let row = row("target_temperature");
    assert_harmless(&row, 0.0);
    for wrong_k in [-10.0, -2.0, 2.0, 10.0] {
        assert_broken_and_said(&row, wrong_k);
    }
    for wrong_k in [-0.5, 0.5] {
        assert!(at(&row, wrong_k).said.is_some(), "before it is beyond what is claimed");
    }
    assert_snapshot!(said(&row));
}

#[test]
fn eq_2_on_two_temperatures_is_said_not_to_be_exact() {
    let row = row("two_temperatures");
    assert_harmless(&row, 0.0);
    assert_broken_and_said(&row, 10.0);
    assert_snapshot!(said(&row));
}

#[test]
fn eq_2_under_a_sky_by_zenith_is_said_not_to_be_exact() {
    let row = row("sky_by_zenith");
    assert_broken_and_said(&row, 60.0);
    assert_snapshot!(said(&row));
}

/// Paths are given up after 128 hits: the interval widens by what they may carry, and holds the
/// closed form.
#[test]
fn what_is_caught_in_a_white_cavity_widens_the_interval() {
    let row = swept("white_cavity", None);
    assert_no_silence(&row);
    assert!(row.points.iter().all(|point| !point.is_broken()), "{row:?}");
    assert_harmless(&row, 0.5);
    let white = at(&row, 1.0);
    assert!(white.claimed > 0.03 && white.status == 4, "{white:?}");
    assert!(white.said.is_some());
    assert_snapshot!(said(&row));
}

#[test]
fn a_unit_of_a_kilometre_or_below_the_wavelength_is_told() {
    let row = row("units");
    assert_harmless(&row, 1e2);
    assert_refused(&row, 1e12, 3);
    let tiny = at(&row, 1e-6);
    assert!(tiny.said.is_some());
    assert_snapshot!(said(&row));
}

#[test]
fn a_mesh_far_from_its_file_s_origin_loses_nothing_in_silence() {
    let row = row("distance_in_file");
    assert_harmless(&row, 1e2);
    assert!(at(&row, 1e6).said.is_some());
    assert_refused(&row, 1e8, 3);
    assert_snapshot!(said(&row));
}

#[test]
fn an_instance_far_away_holds_as_far_as_a_kilometre() {
    let row = row("distance_of_instance");
    for far_um in [0.0, 1e5, 1e7, 5e8] {
        assert_harmless(&row, far_um);
    }
    assert_refused(&row, 1e12, 3);
    assert_snapshot!(said(&row));
}

#[test]
fn detail_that_single_precision_does_not_hold_is_told() {
    let row = row("detail");
    assert_harmless(&row, 1e3);
    assert_broken_and_said(&row, 1e-2);
    assert_snapshot!(said(&row));
}

#[test]
fn slivers_lose_no_ray() {
    let row = swept("slivers", None);
    assert_no_silence(&row);
    for point in &row.points {
        assert!(point.error.is_some_and(|error| error < 1e-9), "{point:?}");
    }
    assert_snapshot!(said(&row));
}

#[test]
fn a_gap_is_kept_until_coordinates_end_and_then_told() {
    let row = swept("gap", None);
    assert_no_silence(&row);
    for gap_um in [1e-2, 10.0] {
        assert_harmless(&row, gap_um);
    }
    assert_snapshot!(said(&row));
}

#[test]
fn facets_in_a_side_of_the_domain_are_told() {
    let row = row("facet_in_side");
    assert_broken_and_said(&row, 0.0);
    assert_harmless(&row, 1e-2);
    assert_snapshot!(said(&row));
}

#[test]
fn a_solid_with_holes_is_told_from_a_whole_one() {
    let row = row("holes");
    assert_harmless(&row, 0.0);
    assert_broken_and_said(&row, 10.0);
    assert_snapshot!(said(&row));
}

#[test]
fn overlapping_solids_are_found_by_probes_to_the_share_of_the_closed_form() {
    let row = row("overlap");
    assert_harmless(&row, 0.0);
    for depth in [0.05, 0.2, 0.5] {
        assert_broken_and_said(&row, depth);
        let words = at(&row, depth).said.clone().expect("said");
        let percent =
            words.split(" % of the facets").next().and_then(|text| text.rsplit(' ').next());
        let found: f64 = percent.expect("a share").parse().expect("a number");
        let truth: f64 = 50.0 * depth;
        // 4096 probes: four standard errors, and facets that are not all of one size.
        let room = 4.0 * (truth * (100.0 - truth) / 4096.0).sqrt() + 0.05 * truth;
        assert!((found - truth).abs() < room, "{depth}: {words}");
    }
    assert_snapshot!(said(&row));
}

#[test]
fn facets_too_few_for_the_file_s_own_normals_are_told() {
    let row = row("coarse_sphere");
    assert_harmless(&row, 96.0);
    assert_broken_and_said(&row, 4.0);
    assert_snapshot!(said(&row));
}

/// What is given up after 10,000 sides counts as open: the interval holds the truth.
#[test]
fn a_view_so_grazing_that_rays_are_given_up_is_told() {
    let row = swept("grazing_view", None);
    assert_no_silence(&row);
    assert!(row.points.iter().all(|point| !point.is_broken()), "{row:?}");
    for zenith_deg in [0.0, 85.0, 89.0] {
        assert_harmless(&row, zenith_deg);
    }
    let last = at(&row, 89.9);
    assert!(last.claimed > 0.02, "{last:?}");
    assert!(last.said.is_some(), "{last:?}");
    assert_snapshot!(said(&row));
}

#[test]
fn cosine_bins_too_wide_for_a_grazing_view_of_a_mirror_are_told() {
    let row = row("grazing_mirror");
    assert_harmless(&row, 50.0);
    assert_broken_and_said(&row, 89.0);
    assert_snapshot!(said(&row));
}

#[test]
fn a_bed_whose_floor_shows_is_told() {
    let row = row("shallow_bed");
    assert_harmless(&row, 12.0);
    assert_broken_and_said(&row, 1.0);
    assert_snapshot!(said(&row));
}

#[test]
fn a_single_packing_never_claims_what_packings_differ_by() {
    let row = row("narrow_patch");
    assert_broken_and_said(&row, 1.0);
    assert_snapshot!(said(&row));
}

#[test]
fn a_spectrum_sampled_too_coarsely_at_the_christiansen_edge_is_told() {
    let row = row("christiansen_sampling");
    assert_harmless(&row, 0.01);
    assert_broken_and_said(&row, 0.5);
    assert_snapshot!(said(&row));
}

#[test]
fn a_spectrum_sampled_too_coarsely_in_the_reststrahlen_bands_is_told() {
    let row = row("reststrahlen_sampling");
    assert_harmless(&row, 0.01);
    assert_broken_and_said(&row, 0.2);
    assert_snapshot!(said(&row));
}

#[test]
fn particles_that_let_light_through_are_told() {
    let row = row("not_opaque");
    assert_harmless(&row, 3000.0);
    assert_broken_and_said(&row, 20.0);
    assert_snapshot!(said(&row));
}

#[test]
fn few_paths_claim_little() {
    let row = swept("few_paths", None);
    assert_no_silence(&row);
    assert!(row.points.iter().all(|point| !point.is_broken()), "{row:?}");
    let two = at(&row, 2.0);
    assert!(two.claimed > 0.1 && two.said.is_some(), "{two:?}");
    assert_snapshot!(said(&row));
}

#[test]
fn a_field_too_small_or_too_large_is_told() {
    let row = row("particles_of_field");
    assert_broken_and_said(&row, 1.0);
    assert_harmless(&row, 1e9);
    assert_refused(&row, 1e15, 3);
    assert_snapshot!(said(&row));
}

#[test]
fn more_materials_than_hits_can_tell_apart_are_refused() {
    let row = row("materials");
    assert_harmless(&row, 100.0);
    assert_refused(&row, 1001.0, 3);
    assert_refused(&row, 100_000.0, 3);
    assert_snapshot!(said(&row));
}

#[test]
fn recipes_of_no_grain_and_of_too_many_are_refused() {
    let row = row("grains_of_recipe");
    assert_refused(&row, 0.0, 3);
    assert_harmless(&row, 10.0);
    assert_refused(&row, 1e6, 3);
    assert_refused(&row, 1e10, 3);
    assert_snapshot!(said(&row));
}

/// Sweeps a row in every Blender there is to test with; the settings at `harmless` are good ones.
/// Returns what is said at `refused`.
fn drops(name: &str, harmless: f64, refused: f64) -> BTreeSet<String> {
    let said_of = |blender: PathBuf| {
        let row = swept(name, Some(&blender));
        assert_no_silence(&row);
        assert_harmless(&row, harmless);
        let point = at(&row, refused);
        assert!(point.is_refused(), "{point:?}");
        without_numbers(&without_places(point.said.as_deref().expect("a reason")))
    };
    real_blenders().into_iter().map(said_of).collect()
}

/// Every Blender says the same, and that.
macro_rules! assert_said {
    ($said:expr) => {
        for said in $said {
            assert_snapshot!(said);
        }
    };
}

#[test]
fn bullet_with_too_few_steps_is_found_out() {
    assert_said!(drops("bullet_substeps", 12.0, 1.0));
}

#[test]
fn bullet_at_a_bad_scale_is_found_out() {
    assert_said!(drops("bullet_scale", 65.0, 0.0065));
}

#[test]
fn bullet_with_a_bad_margin_is_found_out() {
    assert_said!(drops("bullet_margin", 0.04, 40.0));
}

#[test]
fn bullet_with_too_much_gravity_is_found_out() {
    assert_said!(drops("bullet_gravity", 98.1, 9810.0));
}

#[test]
fn every_row_has_a_test() {
    let tests = include_str!("stress.rs");
    for name in stress::names() {
        assert!(tests.contains(&format!("(\"{name}\"")), "{name}");
    }
}

#[test]
fn the_atlas_is_written_by_one_command() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
    command.args(["stress", "--quick", "--rows", "materials", "bullet_scale", "--without-blender"]);
    command.args(["--out", "atlas"]).current_dir(folder.path());
    let output = command.output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("bullet_scale"), "{said}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join("atlas").join(name));
    let csv = read("materials.csv").expect("a CSV file");
    assert!(csv.starts_with("x,error,claimed_half_width,broken,refused,status,said\n"), "{csv}");
    assert!(read("atlas.svg").expect("a chart").contains("Very many materials"));
    let table = read("atlas.md").expect("a table");
    assert_snapshot!(without_fractions(&table));
    assert!(read("bullet_scale.csv").is_err(), "nothing was swept");
    let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
    command.args(["stress", "--rows", "nonsense"]).assert().code(2);
}
