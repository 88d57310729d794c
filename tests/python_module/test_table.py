"""Tables, spectra and sensors."""

import pickle
import time

import numpy as np
import pytest
import xarray as xr

import soilsig


def test_the_signature_has_the_numbers_of_the_command_line(table, program, tmp_path):
    file = tmp_path / "signature.csv"
    grid = ["--range", "8-12", "--step", "0.5"]
    program("signature", table.file, "--out", file, *grid)
    lines = [line.split(",") for line in file.read_text().splitlines()]
    signature = table.signature()
    assert signature.wavelength.values.tolist() == [8 + i / 2 for i in range(9)]
    for i, name in enumerate(lines[0][1:], 1):
        written = np.array([float(line[i] or "nan") for line in lines[1:]])
        np.testing.assert_allclose(signature[name], written, rtol=1e-5, atol=5.1e-8)
    assert signature.attrs["Conventions"] == "CF-1.11"
    assert signature.emissivity.attrs["units"] == "1"
    errors = signature.emissivity.attrs["ancillary_variables"].split()
    assert "emissivity_total_half_width_95" in errors
    assert set(errors) <= set(signature)
    assert signature.wavelength.attrs["standard_name"] == "radiation_wavelength"


def test_other_spectra_temperatures_and_skies_are_those_of_the_command_line(
    table, program, tmp_path
):
    um = np.linspace(7, 13, 50)
    own = 0.8 + 0.1 * np.sin(um)
    file = tmp_path / "own.csv"
    rows = "".join(f"{a},{b}\n" for a, b in zip(um.tolist(), own.tolist()))
    file.write_text("um,emissivity\n" + rows)
    out = tmp_path / "s.csv"
    program(
        "signature", table.file, "--out", out, "--spectrum", f"fine={file}",
        "--temperature", 310, "--sky", 250, "--range", "8-12", "--step", "0.5",
    )  # fmt: skip
    lines = [line.split(",") for line in out.read_text().splitlines()]
    written = {
        name: [float(line[i] or "nan") for line in lines[1:]] for i, name in enumerate(lines[0])
    }
    for given in [file, str(file), (um, own), xr.DataArray(own, {"wavelength": um}, "wavelength")]:
        found = table.signature({"fine": given}, temperature=310, sky=250)
        for name in ["emissivity", "l_target_w_m2_sr_um", "brightness_temperature_k"]:
            np.testing.assert_allclose(found[name], written[name], rtol=1e-5, atol=5.1e-8)
        emissivity = table.emissivity({"fine": given}, temperature=310)
        np.testing.assert_allclose(emissivity, found.emissivity, atol=1e-14)


def test_bands_that_amplify_errors_are_masked_as_on_the_command_line(table, program, tmp_path):
    out = tmp_path / "s.csv"
    light = ["--sky", 290, "--amplification-limit", 6, "--range", "8-12", "--step", "0.5"]
    program("signature", table.file, "--out", out, *light)
    lines = [line.split(",") for line in out.read_text().splitlines()]
    column = lines[0].index("emissivity_eq2")
    written = np.array([float(line[column] or "nan") for line in lines[1:]])
    found = table.signature(sky=290, amplification_limit=6)["emissivity_eq2"]
    assert 0 < np.isnan(written).sum() < len(written)
    assert np.isfinite(table.signature(sky=290, amplification_limit=1e3)["emissivity_eq2"]).all()
    np.testing.assert_allclose(found, written, rtol=1e-5, atol=5.1e-8)


def test_an_evaluation_takes_a_millisecond(table):
    spectrum = soilsig.Spectrum(0.9)
    times = []
    for _ in range(20):
        start = time.perf_counter()
        table.emissivity({"fine": spectrum}, temperature=310)
        times.append(time.perf_counter() - start)
    assert min(times) < 5e-3, times


def test_the_jacobian_is_the_slope(table):
    flat = {name: 0.7 + 0.05 * i for i, name in enumerate(table.materials)}
    jacobian = table.jacobian(flat)
    assert jacobian.dims == ("material", "wavelength")
    assert jacobian.material.values.tolist() == list(table.materials)
    for name in table.materials:
        more, less = (table.emissivity({**flat, name: flat[name] + d}) for d in (1e-5, -1e-5))
        np.testing.assert_allclose(jacobian.sel(material=name), (more - less) / 2e-5, atol=1e-8)


def test_a_pickled_table_and_spectrum_are_the_same(table):
    again = pickle.loads(pickle.dumps(table))
    xr.testing.assert_identical(again.signature(), table.signature())
    assert table.file.read_bytes() == "".join(again._of.texts()).encode()
    spectrum = soilsig.Spectrum(([8.0, 12.0], [0.3, 0.5]), name="mine")
    same = pickle.loads(pickle.dumps(spectrum))
    assert same.name == "mine"
    xr.testing.assert_identical(same.emissivity([9.0]), spectrum.emissivity([9.0]))


def test_a_sensor_sees_what_it_sees_on_the_command_line(table, program, tmp_path):
    out = tmp_path / "bands.csv"
    program("signature", table.file, "--out", out, "--sensor", "aster")
    heading, *rows = (line.split(",") for line in out.read_text().splitlines())
    seen = table.signature(sensor="aster")
    assert seen.band.values.tolist() == ["10", "11", "12", "13", "14"]
    for name in ["emissivity", "l_sensor_w_m2_sr_um", "brightness_temperature_half_width_95_k"]:
        written = [float(row[heading.index(name)]) for row in rows]
        np.testing.assert_allclose(seen[name], written, rtol=1e-5, atol=5.1e-8)
    assert set(seen.sensor.values) == {"aster"}
    aster = soilsig.sensor("aster")
    several = table.signature(sensor=[aster, "landsat-tirs"])
    xr.testing.assert_identical(several, table.signature(sensor="aster,landsat-tirs"))
    assert several.band.values.tolist() == [*seen.band.values.tolist(), "10", "11"]
    assert several.sensor.values.tolist() == ["aster"] * 5 + ["landsat-tirs"] * 2
    assert several.emissivity.values[:5].tolist() == seen.emissivity.values.tolist()
    assert aster.bands[0].name == "10" and aster.bands[0].centre_um == pytest.approx(8.3)
    assert "Yamaguchi" in aster.source


def test_shipped_spectra_and_points_give_emissivities():
    quartz = soilsig.read_spectrum("quartz_fine")
    assert quartz.range_um == pytest.approx((7.3, 14.0))
    assert quartz.emissivity().size > 600
    assert quartz.emissivity([9.0]).wavelength.attrs["units"] == "um"
    half = soilsig.Spectrum(0.5)
    assert half.range_um is None
    assert half.emissivity([9.0, 10.0]).values.tolist() == [0.5, 0.5]
