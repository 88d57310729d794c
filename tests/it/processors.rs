//! The same bytes on processors without fused multiplication: the system's functions for sines and
//! logarithms choose by the instruction set, so none of them is used.

use crate::support::{Place, shipped};

/// Takes instruction sets from the system's library, which chooses its functions by them.
const WITHOUT: &str = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-AVX";

#[test]
fn results_do_not_depend_on_the_instruction_set() {
    let place = Place::new();
    let mut scene = crate::support::shipped_json("settled_patch.json");
    // A view and a sky by angle, and spectra of optical constants: sines, logarithms, roots.
    scene["view"] = serde_json::json!({"zenith_deg": 31.7, "azimuth_deg": 23.9});
    scene["sky_temperature_k"] = serde_json::json!([
        {"zenith_deg": 0, "temperature_k": 230}, {"zenith_deg": 60, "temperature_k": 250},
        {"zenith_deg": 90, "temperature_k": 280}
    ]);
    for material in scene["materials"].as_array_mut().expect("materials") {
        material["spectrum"] = serde_json::json!({"fresnel": "quartz"});
    }
    place.write("scene.json", scene.to_string());
    let full = shipped("settled_patch.json");
    for (name, scene) in [("angles", "scene.json"), ("patch", &*full)] {
        for (kind, tunables) in [("all", ""), ("few", WITHOUT)] {
            let out = format!("{name}_{kind}");
            let args = ["pipeline", "--scene", scene, "--out", &out, "--tolerance", "0.02"];
            let args = [&args[..], &["--range", "8-12", "--step", "0.5", "--no-cache"]].concat();
            let mut command = place.soilsig(&args);
            let output = command.env("GLIBC_TUNABLES", tunables).output().expect("it runs");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!([Some(0), Some(4)].contains(&output.status.code()), "{said}");
        }
        let of = |kind: &str| {
            let record = place.json(format!("{name}_{kind}/run.json"));
            let outputs = record["outputs"].as_object().expect("outputs").clone();
            // Times and logs differ anyway.
            let same = outputs.into_iter().filter(|(_, output)| output["reproducible"] == true);
            same.collect::<serde_json::Map<_, _>>()
        };
        assert_eq!(of("all"), of("few"), "{name}");
    }
}
