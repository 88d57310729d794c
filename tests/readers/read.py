"""Opens soilsig's files in the readers of others and compares them.

tests/it/readers.rs starts it in the folder that holds them.
"""

import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import spectral.io.envi as envi
import xarray as xr

warnings.simplefilter("error")

LINES, SAMPLES = 4, 6
BANDS_UM = np.arange(8.0, 12.01, 0.5)

data = xr.open_dataset("image/image.nc")
assert data.attrs["Conventions"].startswith("CF-")
assert data.sizes == {"y": LINES, "wavelength": len(BANDS_UM), "x": SAMPLES}
assert np.array_equal(data.wavelength, BANDS_UM)
assert data.wavelength.attrs["units"] == "um"
assert data.radiance.attrs["units"] == "W m-2 sr-1 um-1"
assert all(name in data for name in data.radiance.attrs["ancillary_variables"].split())
assert "scene" in data.attrs["history"]
# Upward and to the right, about the middle: as plots of xarray show them.
assert (np.diff(data.y) < 0).all() and (np.diff(data.x) > 0).all()
assert abs(data.y.mean()) < 1e-9 and abs(data.x.mean()) < 1e-9
assert (data.valid == 1).all() and (data.band_width == 0).all()
assert data.material.attrs["flag_meanings"].split() == ["fine", "coarse", "floor"]

for name in ["radiance", "radiance_standard_error", "emissivity"]:
    ours = np.array([float(line) for line in Path(f"{name}.txt").read_text().split()])
    ours = ours.reshape(len(BANDS_UM), LINES, SAMPLES).astype(np.float32)
    image = envi.open(f"image/{name}.hdr")
    assert image.bands.band_unit == "Micrometers"
    assert np.array_equal(image.bands.centers, BANDS_UM)
    assert image.metadata["band names"][:2] == ["8 um", "8.5 um"]
    assert np.array_equal(np.asarray(image.load()).transpose(2, 0, 1), ours), name
    assert np.array_equal(data[name].transpose("wavelength", "y", "x").values, ours), name

maps = envi.open("image/maps.hdr")
for band, name in enumerate(maps.metadata["band names"]):
    assert np.array_equal(maps.read_band(band), data[name].values), name
assert set(np.unique(data.material)) <= {0.0, 1.0, 2.0}
assert (data.hits >= 1).all() and (data.paths >= 32).all()

library = envi.open("library.hdr")
assert library.bands.band_unit == "Micrometers"
assert np.array_equal(library.bands.centers, BANDS_UM)
table = pd.read_csv("library.csv")
assert np.array_equal(table.iloc[:, 0], BANDS_UM)
assert np.array_equal(library.spectra[0], table.iloc[:, 1])
assert table.iloc[:, 1].min() > 0 and table.iloc[:, 1].max() < 1

signature = pd.read_csv("signature.csv")
assert np.array_equal(signature.wavelength_um, BANDS_UM)
assert signature.emissivity.between(0, 1).all()
# A column that only several packings fill is left out.
assert "emissivity_sd_packings" not in signature
assert not signature.isna().any(axis=None)

curves = xr.open_dataset("signature.nc")
assert curves.attrs["Conventions"].startswith("CF-")
assert "scene" in curves.attrs["history"]
assert curves.sizes == {"wavelength": len(BANDS_UM)}
assert np.array_equal(curves.wavelength, BANDS_UM)
assert curves.wavelength.attrs["standard_name"] == "radiation_wavelength"
for name in signature.columns.drop("wavelength_um"):
    assert np.allclose(curves[name], signature[name], rtol=0, atol=5.1e-8), name
    assert curves[name].attrs["units"] in {"1", "K", "W m-2 sr-1 um-1"}, name
errors = curves.emissivity.attrs["ancillary_variables"].split()
assert {"emissivity_standard_error", "emissivity_total_half_width_95", "budget_floor"} <= set(
    errors
)
assert all(error in curves for error in errors)
assert curves.l_target_w_m2_sr_um.attrs["ancillary_variables"] in curves

# Names are words, bands in the order of the sensors; two bands are missing in both.
bands = pd.read_csv("bands.csv", dtype={"band": str})
seen = xr.open_dataset("bands.nc")
assert seen.sizes == {"band": 9}
assert (
    seen.sensor.astype(str).values.tolist()
    == bands.sensor.tolist()
    == ["aster"] * 5 + ["modis"] * 4
)
assert seen.band_name.astype(str).values.tolist() == bands.band.tolist()
assert set(seen.emissivity.coords) == {"sensor", "band_name", "centre_um"}
for name in bands.columns.drop(["sensor", "band"]):
    of = 5.1e-5 if name == "centre_um" else 5.1e-8
    assert np.allclose(seen[name], bands[name], rtol=0, atol=of, equal_nan=True), name
assert bands.band[bands.emissivity.isna()].tolist() == ["14", "32"]
for name, unit in [("emissivity", "1"), ("l_sensor_w_m2_sr_um", "W m-2 sr-1 um-1")]:
    assert seen[name].attrs["units"] == unit and seen[name].attrs["ancillary_variables"] in seen
assert seen.brightness_temperature_k.attrs["units"] == "K"
