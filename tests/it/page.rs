//! The page of a result, opened in a browser.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::support::{Place, Tool, shipped, tool};

/// Runs a script at the end of a page, in a browser without a window; returns its result, which the
/// script gives as JSON to `done`.
fn in_browser(browser: &Path, page: &Path, script: &str) -> Value {
    let html = fs::read_to_string(page).expect("a page");
    let script = format!(
        "<script>\n'use strict';\nconst done = (value) => document.body.append(Object.assign(\
         document.createElement('pre'), {{ id: 'done', textContent: JSON.stringify(value) }}));\n\
         {script}\n</script>\n</body>"
    );
    let (before, after) = html.rsplit_once("</body>").expect("a body");
    let copy = page.with_file_name("in_browser.html");
    fs::write(&copy, format!("{before}{script}{after}")).expect("written");
    let profile = tempfile::tempdir().expect("a temporary folder");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .args(["--virtual-time-budget=10000", "--window-size=1200,900"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", copy.display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&output.stdout);
    let said = String::from_utf8_lossy(&output.stderr);
    let result = dom.split("<pre id=\"done\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let result = result.unwrap_or_else(|| panic!("the script ended early: {said}\n{}", dom.len()));
    let text = result.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&text).expect("JSON")
}

/// Moves a slider or chooses an entry, as a hand does.
const HANDS: &str = "
const move = (id, value) => {
  const slider = document.getElementById(id);
  slider.value = value;
  slider.dispatchEvent(new Event('input', { bubbles: true }));
};
const choose = (id, value) => {
  const select = document.getElementById(id);
  select.value = value;
  select.dispatchEvent(new Event('change', { bubbles: true }));
};
const cells = (table) => [...table.querySelectorAll('tbody tr')]
  .map((row) => [...row.cells].map((cell) => cell.textContent));
";

/// Columns of a CSV file by heading.
fn column(csv: &str, heading: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let at = lines.next().expect("a heading").split(',').position(|name| name == heading);
    let at = at.expect("a column");
    let field = |line: &str| line.split(',').nth(at).expect("a field").parse().expect("a number");
    lines.map(field).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn near(a: &[f64], b: &[f64], within: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= within, "{a} and {b}");
    }
}

#[test]
fn a_page_is_one_small_file_that_asks_for_nothing() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    place.run(&["pipeline", "--scene", &scene, "--out", "r"], 0);
    let html = place.read("r/report.html");
    assert!(html.len() < 2_000_000, "{}", html.len());
    let without_names = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!without_names.contains("http://") && !without_names.contains("https://"));
    assert!(html.contains("default-src 'none'"));
    for words in ["Emissivity ", "signature.csv", "soilsig replay", "patch"] {
        assert!(html.contains(words), "{words}");
    }
    // The numbers of a page that is made anew from the files of the run.
    place.run(&["report", "r", "--out", "again.html"], 0);
    let numbers = |html: &str| {
        let end = html.find("\"tables\":").expect("a key");
        html[html.find("\"um\":").expect("a key")..end].to_owned()
    };
    assert_eq!(numbers(&place.read("again.html")), numbers(&html));
}

#[test]
fn the_numbers_of_a_page_are_those_of_the_files_when_sliders_move() {
    let Some(browser) = tool(Tool::Browser) else { return };
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let set = ["--set", "sky_temperature_k=250"];
    place.run(&[&["pipeline", "--scene", &scene, "--out", "r"], &set[..]].concat(), 0);
    let script = format!(
        "{HANDS}
const [run] = page.runs;
const own = emissivity(run.table, run.table.materials.map((m) => m.emissivity), run.um.length);
move('constant-0', 0.85);
const medium = page.spectra.findIndex((spectrum) => spectrum.name === 'quartz_medium');
choose('spectrum-1', `shipped ${{medium}}`);
move('kelvin', 315);
move('sky', 265);
choose('sensor', 'aster');
const spectra = [run.um.map(() => 0.85), page.spectra[medium].emissivity, run.table.materials[2].emissivity];
const moved = emissivity(run.table, spectra, run.um.length);
const radiance = moved.map((eps, i) =>
  eps * planck(run.um[i], 315) + (1 - eps) * planck(run.um[i], 265));
const svg = document.querySelector('.chart svg');
svg.dispatchEvent(new KeyboardEvent('keydown', {{ key: 'ArrowRight' }}));
const readout = document.querySelector('.readout').textContent;
done({{ um: run.um, own, shown: run.emissivity, total: run.parts.total, moved, radiance, readout,
  command: document.getElementById('command').textContent,
  bands: cells(document.querySelectorAll('table')[0]), errors: document.querySelectorAll('[role=alert]').length }});"
    );
    let page = in_browser(&browser, &place.path("r/report.html"), &script);
    let csv = place.read("r/signature.csv");
    let of_csv = column(&csv, "emissivity");
    near(&numbers(&page["um"]), &column(&csv, "wavelength_um"), 0.0);
    near(&numbers(&page["shown"]), &of_csv, 1e-12);
    near(&numbers(&page["own"]), &of_csv, 1e-7);
    near(&numbers(&page["total"]), &column(&csv, "emissivity_total_half_width_95"), 1e-12);
    // The command that the page shows gives what the page shows.
    let command = page["command"].as_str().expect("text");
    let sensor = " --sensor aster";
    assert!(command.ends_with(sensor), "{command}");
    let words: Vec<&str> = command.strip_suffix(sensor).expect("a sensor").split(' ').collect();
    assert_eq!(words[..2], ["soilsig", "signature"]);
    let args: Vec<String> =
        words[1..].iter().map(|word| word.replace("table.json", "r/table.json")).collect();
    let mut args: Vec<&str> = args.iter().map(String::as_str).collect();
    assert!(args.contains(&"fine=0.85") && args.contains(&"coarse=quartz_medium"), "{command}");
    let (csv, _) = place.run(&args, 0);
    near(&numbers(&page["moved"]), &column(&csv, "emissivity"), 1e-7);
    near(&numbers(&page["radiance"]), &column(&csv, "l_target_w_m2_sr_um"), 1e-6);
    // The table of bands, on the page's grid and with four decimals.
    args.extend(["--sensor", "aster"]);
    let (csv, _) = place.run(&args, 0);
    let bands = page["bands"].as_array().expect("rows");
    assert_eq!(bands.len(), 5);
    for (at, heading, within) in [
        (2, "emissivity", 3e-4),
        (3, "l_sensor_w_m2_sr_um", 3e-3),
        (4, "brightness_temperature_k", 0.02),
    ] {
        let cell = |row: &Value| row[at].as_str().expect("text").parse().expect("a number");
        let shown: Vec<f64> = bands.iter().map(cell).collect();
        near(&shown, &column(&csv, heading), within);
    }
    let readout = page["readout"].as_str().expect("text");
    assert!(readout.contains("µm: as traced 0.") && readout.contains(", now 0."), "{readout}");
}

/// Whether anything stands out of the page, or is cut off, on a phone, a tablet or a screen.
#[test]
fn nothing_stands_out_of_the_page_at_any_width() {
    let Some(browser) = tool(Tool::Browser) else { return };
    let place = Place::new();
    place.run(&["pipeline", "--scene", &shipped("settled_patch.json"), "--out", "r"], 0);
    place.run(&["report", "r", "r", "--out", "r/both.html"], 0);
    let script = format!(
        "{HANDS}
if (document.getElementById('sensor')) choose('sensor', 'aster');
document.querySelectorAll('details').forEach((details) => {{ details.open = true; }});
const out = [];
for (const width of [360, 800, 1180]) {{
  main.style.width = `${{width}}px`;
  window.dispatchEvent(new Event('resize'));
  const edge = main.getBoundingClientRect().right + 0.5;
  for (const element of main.querySelectorAll('*')) {{
    // Tables of many columns may be scrolled.
    const host = element.closest('.scroll');
    const may = host && host.querySelectorAll('th').length > 3;
    const {{ right, width: own }} = element.getBoundingClientRect();
    const said = `${{width}}: ${{element.tagName}} ${{element.textContent.slice(0, 40)}}`;
    if (own > 1 && right > edge && !(may && element !== host) && !element.closest('svg')) {{
      out.push(said);
    }}
    if (host === element && !may && host.scrollWidth > host.clientWidth + 1) out.push(said);
  }}
}}
done({{ out, versions: [...document.querySelectorAll('h3')].map((h) => h.textContent) }});"
    );
    for page in ["r/report.html", "r/both.html"] {
        let found = in_browser(&browser, &place.path(page), &script);
        assert_eq!(found["out"], serde_json::json!([]), "{page}");
        assert!(!found["versions"].as_array().expect("headings").is_empty());
    }
}

#[test]
fn measured_spectra_are_read_from_disk() {
    let Some(browser) = tool(Tool::Browser) else { return };
    let place = Place::new();
    place.run(&["pipeline", "--scene", &shipped("settled_patch.json"), "--out", "r"], 0);
    let script = format!(
        "{HANDS}
const texts = {{
  'plain.csv': 'wavelength_um,emissivity\\n8,0.9\\n9,0.8\\n10,0.9\\n',
  'nm.txt': '# x\\nwavelength_nm;reflectance (%)\\n9000;10\\n8000;20\\n',
  'library.txt': 'Name: Sand\\nX Units: Wavelength (micrometers)\\nY Units:Reflectance (percent)\\n\\n'
    + '14.0\\t 5\\n7.5\\t 25\\n',
  'signature.csv': 'wavelength_um,valid,emissivity\\n8,1,0.5\\n9,1,0.6\\n',
  'transmission.txt': 'Name: x\\nY Units: Transmittance (percent)\\n\\n8 5\\n9 5\\n',
  'words.csv': 'a,b\\n8,0.9\\nnine,0.8\\n',
}};
const read = Object.entries(texts).map(([name, text]) => {{
  try {{ const {{ x, y, name: label }} = readSpectrum(name, text); return {{ x, y, label }}; }}
  catch (error) {{ return error.message; }}
}});
// The browser's time does not wait for its reading of files.
File.prototype.text = async function () {{ return texts[this.name]; }};
const files = Object.entries(texts).map(([name, text]) => new File([text], name));
const transfer = new DataTransfer();
files.forEach((file) => transfer.items.add(file));
const place = document.querySelector('.chart');
place.dispatchEvent(new DragEvent('drop', {{ dataTransfer: transfer, bubbles: true }}));
setTimeout(() => done({{ read, keys: document.querySelector('.keys').textContent,
  notes: document.querySelector('main').textContent,
  alerts: [...document.querySelectorAll('[role=alert]')].map((p) => p.textContent),
  offered: [...document.querySelectorAll('#spectrum-0 option')].map((o) => o.textContent) }}), 500);"
    );
    let page = in_browser(&browser, &place.path("r/report.html"), &script);
    let read = &page["read"];
    near(&numbers(&read[0]["y"]), &[0.9, 0.8, 0.9], 1e-12);
    near(&numbers(&read[1]["x"]), &[8.0, 9.0], 1e-12);
    near(&numbers(&read[1]["y"]), &[0.8, 0.9], 1e-12);
    near(&numbers(&read[2]["y"]), &[0.75, 0.95], 1e-12);
    assert_eq!(read[2]["label"], "Sand (library.txt)");
    near(&numbers(&read[3]["y"]), &[0.5, 0.6], 1e-12);
    assert_eq!(read[4], "transmission.txt is a transmission spectrum");
    assert!(read[5].as_str().expect("an error").contains("not a row of numbers"));
    let text = |key: &str| page[key].as_str().expect("text").to_owned();
    for name in ["plain.csv", "nm.txt", "Sand", "signature.csv"] {
        assert!(text("keys").contains(name), "{name}: {}", text("keys"));
    }
    assert!(text("notes").contains("As traced less plain.csv: RMS 0."), "{}", text("notes"));
    let alerts = page["alerts"].as_array().expect("a list");
    assert_eq!(alerts.len(), 2, "{alerts:?}");
    // What holds all bands may be given to a material.
    let offered = page["offered"].as_array().expect("a list");
    let holds = |name: &str| offered.iter().any(|o| o.as_str().is_some_and(|o| o.contains(name)));
    assert!(holds("Sand") && !holds("plain.csv"), "{offered:?}");
}

#[test]
fn runs_are_compared_on_one_page() {
    let Some(browser) = tool(Tool::Browser) else { return };
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let bands = ["--range", "8-12", "--step", "0.05", "--tolerance", "0.02"];
    for (out, zenith) in [("nadir", "0"), ("tilted", "70")] {
        let set = format!("view.zenith_deg={zenith}");
        let args = ["pipeline", "--scene", &scene, "--out", out, "--set", &set];
        place.run(&[&args[..], &bands].concat(), 0);
    }
    place.run(&["report", "nadir", "tilted", "--out", "both.html"], 0);
    let script = format!(
        "{HANDS}
const tables = [...document.querySelectorAll('table')];
done({{ numbers: cells(tables[0]), apart: cells(tables[1]), charts: document.querySelectorAll('svg').length }});"
    );
    let page = in_browser(&browser, &place.path("both.html"), &script);
    assert_eq!(page["charts"], 2);
    assert_eq!(page["numbers"].as_array().expect("rows").len(), 2);
    let (out, _) = {
        let args = ["diff", "nadir", "tilted"];
        let output = place.soilsig(&args).output().expect("it runs");
        (String::from_utf8(output.stdout).expect("UTF-8"), output.status)
    };
    let apart = &page["apart"][0];
    assert_eq!(apart[0], "tilted less nadir");
    let rms = apart[1].as_str().expect("a number");
    assert!(out.contains(&format!("RMS {rms}")), "{out}: {apart}");
    let z: f64 = apart[6].as_str().expect("z").parse().expect("a number");
    assert!(out.contains(&format!("z {z:+.1}")), "{out}: {apart}");
}
