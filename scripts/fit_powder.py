"""Fits the closed form of a powder's emissivity to a measured spectrum.

    python scripts/fit_powder.py spectra/quartz_coarse.json MEASURED.txt \\
        [--other OTHER.txt] [--csv CURVE.csv]

It needs numpy and scipy. The parameter file holds the start values. Its list "fitted" names the
free numbers. The fitted numbers are written back into it. "constants" names a file beside it with
the crystal's optical constants. Another mineral needs two such files and no change here. MEASURED
is a hemispherical reflectance of the ECOSTRESS or ASTER library, in percent.

The fit minimises the square error at every 10 nm of the range and the slope of the curve at
"christiansen_um", where the measured curve has its maximum. The residuals alone are too small there
to place the maximum.

The optics here are independent of the program's, so that a test can compare the two.
"""

import argparse
import json
import math
import re
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

STEP_UM = 0.01
DIGITS = 5


def measured(path):
    """Wavelengths (um, ascending) and emissivities of a library file."""
    text = Path(path).read_bytes().decode("latin-1")
    header, _, table = text.replace("\r\n", "\n").partition("\n\n")
    if not re.search(r"Y Units: *Reflect[ae]nce \(percent\)", header):
        raise SystemExit(f"{path}: not a reflectance in percent")
    if "emispherical" not in header:
        raise SystemExit(f"{path}: not a hemispherical reflectance: Kirchhoff's law does not hold")
    rows = np.array([line.split() for line in table.splitlines() if line.strip()], float)
    rows = rows[rows[:, 0].argsort()]
    return rows[:, 0], 1 - rows[:, 1] / 100


def axis(constants, changes, eps_inf_shift, wavenumber):
    """Refractive index n + ik along one axis."""
    eps = constants["eps_inf"] + eps_inf_shift + 0j
    for row in constants["oscillators"]:
        v0, strength, damping = row["v0_per_cm"], row["strength"], row["damping"]
        for change in changes:
            if row["v0_per_cm"] in change["rows_per_cm"]:
                v0 += change.get("shift_per_cm", 0)
                strength *= change.get("strength", 1)
                damping *= change.get("damping", 1)
        eps = eps + strength * v0**2 / (v0**2 - wavenumber**2 - 1j * damping * v0 * wavenumber)
    return np.sqrt(eps)


def emissivity(parameters, crystal, um):
    """Emissivity by the closed form, at wavelengths in um."""
    shifts = (0, parameters.get("extraordinary_eps_inf_shift", 0))
    axes = (crystal["ordinary"], crystal["extraordinary"])
    wavenumber = 1e4 / um
    indices = [
        axis(constants, parameters["changes"], shift, wavenumber)
        for constants, shift in zip(axes, shifts)
    ]
    weight = parameters["ordinary_weight"]
    ordinary, extraordinary = (np.abs((index - 1) / (index + 1)) ** 2 for index in indices)
    rs = weight * ordinary + (1 - weight) * extraordinary
    a, c = parameters["surface"]["a"], parameters["surface"]["c"]
    result = 1 - a * rs * (1 - c) / (1 - c * rs)
    volume = parameters.get("volume")
    if volume:
        depths = [4 * math.pi * index.imag * volume["d_um"] / um for index in indices]
        m = volume.get("m")
        ordinary, extraordinary = (np.exp(-x) if m is None else (1 + x / m) ** -m for x in depths)
        t = weight * ordinary + (1 - weight) * extraordinary
        result = result - volume["b"] * (1 - rs) * t * rs / (rs + volume["r0"])
    return result


def place(parameters, key):
    """The list or object that holds a number, and its key there: "changes.0.strength"."""
    *way, last = [int(part) if part.isdigit() else part for part in key.split(".")]
    for part in way:
        parameters = parameters[part]
    return parameters, last


def get(parameters, key):
    """A number of the parameter file."""
    holder, last = place(parameters, key)
    return holder[last]


def put(parameters, key, value):
    """Sets a number of the parameter file."""
    holder, last = place(parameters, key)
    holder[last] = value


def fit(parameters, crystal, um, target):
    """Sets the numbers named in "fitted" to their best."""
    keys = parameters["fitted"]
    start = np.array([get(parameters, key) for key in keys])
    near = parameters["christiansen_um"] + np.array([-0.04, 0.04])

    def residuals(values):
        for key, value in zip(keys, values):
            put(parameters, key, value)
        low, high = emissivity(parameters, crystal, near)
        slope = parameters["christiansen_weight"] * (high - low) / (near[1] - near[0])
        return np.append(emissivity(parameters, crystal, um) - target, slope)

    scale = np.maximum(np.abs(start), 0.1)
    best = least_squares(residuals, start, x_scale=scale, max_nfev=500).x
    for key, value in zip(keys, best):
        put(parameters, key, float(f"{value:.{DIGITS}g}"))


def main():
    """Reads the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parameters", type=Path)
    parser.add_argument("measured", help="the library's file that is fitted")
    parser.add_argument("--other", help="another sample, not fitted, for comparison")
    parser.add_argument("--csv", type=Path, help="write the fitted curve as well")
    args = parser.parse_args()
    parameters = json.loads(args.parameters.read_text())
    constants = args.parameters.with_name(parameters["constants"] + ".json")
    crystal = json.loads(constants.read_text())
    first, last = parameters["range_um"]
    um = np.arange(round(first / STEP_UM), round(last / STEP_UM) + 1) * STEP_UM
    target = np.interp(um, *measured(args.measured))
    fit(parameters, crystal, um, target)
    curve = emissivity(parameters, crystal, um)
    error = curve - target
    worst = np.abs(error).argmax()
    parameters["rms"] = float(f"{np.sqrt(np.mean(error**2)):.2g}")
    parameters["largest_error"] = float(f"{error[worst]:.2g}")
    parameters["largest_error_at_um"] = float(f"{um[worst]:.2f}")
    if args.other:
        other = curve - np.interp(um, *measured(args.other))
        parameters["rms_other_sample"] = float(f"{np.sqrt(np.mean(other**2)):.2g}")
    args.parameters.write_text(written(parameters))
    if args.csv:
        rows = "".join(f"{x:.2f},{y:.6f}\n" for x, y in zip(um, curve))
        args.csv.write_text("wavelength_um,emissivity\n" + rows)
    top = (um < 7.6).nonzero()[0][curve[um < 7.6].argmax()]
    print(f"numbers fitted        {len(parameters['fitted'])}")
    print(f"rms                   {np.sqrt(np.mean(error**2)):.5f}")
    print(f"largest error         {error[worst]:+.4f} at {um[worst]:.2f} um")
    if args.other:
        print(f"rms, other sample     {np.sqrt(np.mean(other**2)):.5f}")
    print(f"highest below 7.6 um  {curve[top]:.5f} at {um[top]:.2f} um, first {curve[0]:.5f}")
    for x in (8.5, 8.95, 10.0, 11.0, 12.5):
        print(f"{x:5.2f} um  {emissivity(parameters, crystal, np.array([x]))[0]:.7f}")


def written(parameters):
    """JSON with one line for each key and each change."""
    lines = []
    for key, value in parameters.items():
        if key == "changes":
            rows = ",\n".join("    " + json.dumps(change) for change in value)
            lines.append(f'  "changes": [\n{rows}\n  ]')
        else:
            lines.append(f"  {json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


if __name__ == "__main__":
    main()
