"""Compares facet spectra with measured quartz powders.

Prints the tables of docs/measurements/powders.md and docs/measurements/sand_beds.md.

    python3 scripts/chemistry.py SOILSIG FOLDER LIBRARY-FILE...

It needs numpy. LIBRARY-FILEs are hemispherical reflectances of quartz of the ECOSTRESS library,
fine, medium and coarse, samples TS-1A and TS-1B. Fetch them from the library's site. Each bed is
dropped once (scenes/quartz_sand.json, some with changes) and traced for each kind of facet. Tables
and charts go into FOLDER. Results that are already in FOLDER are used again.

    python3 scripts/chemistry.py SOILSIG FOLDER --pure-bed spectra/pure_bed.json

makes the shipped pure bed again. It needs no library file.
"""

import argparse
import csv
import json
import re
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "scenes" / "quartz_sand.json"
SHAPES = ("chip", "angular", "subangular", "worn")
RANGES_UM = ((7.5, 12.0), (8.0, 9.5), (10.0, 12.0))
UM = np.round(np.arange(7.5, 12.005, 0.01), 2)
PATHS = 8192
PACKINGS = 16
COSINES = 64
BEST = "quartz_zeidler"
SETS = ("quartz_spitzer_kleinman", "quartz", BEST)
SPECULAR = {"spectrum": {"fresnel": BEST}}


class Measured:
    """A library file: emissivity by Kirchhoff."""

    def __init__(self, path):
        text = Path(path).read_bytes().decode("latin-1").replace("\r\n", "\n")
        header, _, table = text.partition("\n\n")
        if not re.search(r"Y Units: *Reflect[ae]nce \(percent\)", header) or (
            "emispherical" not in header
        ):
            raise SystemExit(f"{path}: not a hemispherical reflectance in percent")
        self.path = path
        self.size = re.search(r"Particle Size: *(\w+)", header)[1].lower()
        self.sample = re.search(r"Sample No\.: *(\S+)", header)[1].upper()
        rows = np.array([line.split() for line in table.splitlines() if line.strip()], float)
        rows = rows[rows[:, 0].argsort()]
        self.emissivity = np.interp(UM, rows[:, 0], 1 - rows[:, 1] / 100)

    def rms(self, curve, within=RANGES_UM[0], bands=True):
        """Root mean square difference; not a number where there is no band."""
        inside = (within[0] - 1e-9 <= UM) & (within[1] + 1e-9 >= UM) & bands
        error = (curve - self.emissivity)[inside]
        return np.sqrt(np.mean(error**2)) if len(error) else np.nan


class Work:
    """Runs the program in a folder."""

    def __init__(self, soilsig, folder):
        self.soilsig, self.folder = Path(soilsig).resolve(), Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)

    def run(self, *arguments):
        command = [self.soilsig, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 4):  # 4: the tolerance was not reached
            raise SystemExit(done.stderr)
        return done.stdout

    def drop(self, name, change=lambda packing: None, packings=PACKINGS):
        """The placed scenes of so many packings of the sand."""
        scene = json.loads(SCENE.read_text())
        scene["name"] = name
        change(scene["geometry"]["packing"])
        recipe, out = self.folder / f"{name}.json", self.folder / name
        recipe.write_text(json.dumps(scene, indent=1))
        what = ["--scene", recipe, "--packings", packings, "--out", out]
        # The noise of these rays does not matter: each bed is traced again.
        if not (out / "run.json").is_file():
            self.run("pipeline", *what, "--tolerance", 0.3, "--range", "9-9")
        return [out / f"packings/{i + 1}/scene.json" for i in range(packings)]

    def trace(self, beds, name, material):
        """Bounce tables of beds with other facets, the floor's like the grains'."""
        tables = []
        for bed in beds:
            scene = json.loads(bed.read_text())
            scene["materials"] = [dict(material, name="quartz")]
            scene["geometry"]["placed"]["domain"]["floor"]["material"] = "quartz"
            placed, table = bed.with_name(f"{name}.json"), bed.with_name(f"{name}_table.json")
            placed.write_text(json.dumps(scene))
            if not table.is_file():
                # The rule that ends paths considers all bands of the range.
                self.run("trace", placed, "--out", table, "--paths", PATHS, "--range", "7.5-12")
            tables.append(table)
        return tables

    def curve(self, tables, *options):
        """Emissivity, and its standard error, over the packings."""
        out = self.folder / "signature.csv"
        self.run("signature", *tables, "--range", "7.5-12", "--out", out, *options)
        with out.open() as file:
            rows = list(csv.DictReader(file))
        column = [np.array([float(row[k]) for row in rows]) for k in COLUMNS]
        return Curve(*column)


COLUMNS = ("emissivity", "emissivity_standard_error", "valid")


class Curve:
    def __init__(self, emissivity, error, valid):
        self.emissivity, self.error, self.valid = emissivity, error, valid > 0


def row(*cells):
    print("|", " | ".join(map(str, cells)), "|")


def head(*cells):
    row(*cells)
    row(*["---"] * len(cells))


def axis(constants, wavenumber):
    """The dielectric function along one axis of a file of spectra/."""
    eps = constants["eps_inf"] * np.ones_like(wavenumber, complex)
    for f in constants.get("factors", []):
        above = f["lo_per_cm"] ** 2 - wavenumber**2 - 1j * f["lo_damping_per_cm"] * wavenumber
        below = f["to_per_cm"] ** 2 - wavenumber**2 - 1j * f["to_damping_per_cm"] * wavenumber
        eps *= above / below
    for o in constants.get("oscillators", []):
        v0 = o["v0_per_cm"]
        eps += o["strength"] * v0**2 / (v0**2 - wavenumber**2 - 1j * o["damping"] * v0 * wavenumber)
    return eps


def fresnel(eps, mu):
    """Reflectance across and within the plane of incidence, at cosines."""
    inside = np.sqrt(eps - (1 - mu**2))
    return abs((mu - inside) / (mu + inside)) ** 2, abs(
        (eps * mu - inside) / (eps * mu + inside)
    ) ** 2


def any_axis(ordinary, extraordinary, mu, across=7, around=6):
    """Reflectance of a uniaxial crystal for unpolarised light, the mean over all directions of its
    axis, by the boundary conditions: tangential E and H are continuous, two waves go on within."""
    o, e, mu = np.broadcast_arrays(ordinary, extraordinary, mu)
    k, zero = np.sqrt(1 - mu**2), np.zeros(mu.shape)
    in_s = zero, zero + 1, zero
    back, forth = (k, zero, -mu), (k, zero, mu)
    nodes, weights = np.polynomial.legendre.leggauss(across)
    total = 0
    for cosine, weight in zip((nodes + 1) / 2, weights / 2):
        for azimuth in (np.arange(around) + 0.5) / around * np.pi:
            sine = np.sqrt(1 - cosine**2)
            a = sine * np.cos(azimuth), sine * np.sin(azimuth), cosine
            # The extraordinary wave: o k.k + (e - o) (k.a)^2 = o e.
            d = e - o
            two, one = o + d * a[2] ** 2, 2 * d * a[0] * a[2] * k
            root = np.sqrt(one**2 - 4 * two * (o * k**2 + d * (a[0] * k) ** 2 - o * e))
            q = [(-one + root) / (2 * two), (-one - root) / (2 * two)]
            k_o = k, zero, np.sqrt(o - k**2)
            k_e = k, zero, np.where(q[0].imag >= q[1].imag, *q)
            along = a[0] * k + a[2] * k_e[2]
            fields = []
            for wave, field in (
                (k_o, cross(k_o, a)),
                (k_e, tuple(o * a[i] - along * k_e[i] for i in range(3))),
            ):
                norm = np.sqrt(sum(abs(c) ** 2 for c in field))
                fields.append((wave, tuple(c / norm for c in field)))
            fields += [(back, in_s), (back, cross(back, in_s))]
            coming = [(forth, in_s), (forth, cross(forth, in_s))]
            left, right = ([tangential(*w) for w in waves] for waves in (fields, coming))
            left[2:] = [-c for c in left[2:]]
            sent = np.linalg.solve(np.stack(left, -1), np.stack(right, -1))[..., 2:, :]
            total = total + weight / around * (abs(sent) ** 2).sum((-1, -2)) / 2
    return total


def cross(u, v):
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def tangential(wave, field):
    magnetic = cross(wave, field)
    return np.stack([field[0], field[1], magnetic[0], magnetic[1]], -1).astype(complex)


def evaluated(tables, reflectances):
    """Emissivity for reflectances by band and bin of the cosine; means over the packings."""
    curves = []
    for path in tables:
        histogram = json.loads(path.read_text())["histogram"]
        states = [(s, sum(n for _, n in c)) for s, c in histogram["escaped"]]
        # A path that is given up counts half.
        states += [(s, sum(n for _, n in c) / 2) for s, c in histogram["trapped"]]
        hits = np.zeros((len(states), COSINES))
        for counts, (state, _) in zip(hits, states):
            np.add.at(counts, state, 1)
        number = np.array([n for _, n in states])
        whole = sum(n for kind in ("escaped", "trapped") for _, c in histogram[kind] for _, n in c)
        whole += sum(n for _, n in histogram["ended"])
        curves.append([1 - np.exp(np.log(r) @ hits.T) @ number / whole for r in reflectances])
    return np.mean(curves, 0)


def quartz(of_e=BEST):
    """Dielectric function along both axes by band, cosines in the middle of bins, and there the
    reflectance across and within the plane of incidence."""
    both = (json.loads((ROOT / "spectra" / f"{name}.json").read_text()) for name in (BEST, of_e))
    names = "ordinary", "extraordinary"
    o, e = (axis(crystal[name], 1e4 / UM)[:, None] for crystal, name in zip(both, names))
    middles = (np.arange(COSINES) + 0.5)[None] / COSINES
    of_axes = fresnel(o, middles), fresnel(e, middles)
    return o, e, middles, [(2 * of_axes[0][i] + of_axes[1][i]) / 3 for i in (0, 1)]


def other_optics(tables):
    """The specular bed once more, with the crystal's axes and polarisation done better."""
    o, e, middles, (s, p) = quartz()
    other = [sum(quartz("quartz")[3]) / 2, any_axis(o, e, middles), s, p]
    plain, mixed, exact, all_s, all_p = evaluated(tables, [(s + p) / 2, *other])
    return {
        "the same, evaluated here": plain,
        "extraordinary ray of `quartz`": mixed,
        "axes: exact mean over their directions": exact,
        "polarisation kept, all hits in one plane (a bound)": (all_s + all_p) / 2,
    }


def steps_table(work, beds_of, coarse):
    """Returns the specular curve of each bed by the best set."""
    print("\n## What each step buys, coarse\n")
    head("facets", "constants", *(f"{m.sample} {a:g}-{b:g}" for m in coarse for a, b in RANGES_UM))
    sand, curves = beds_of["quartz_sand"], {}

    def line(what, constants, curve):
        row(what, constants, *(f"{m.rms(curve, r):.4f}" for m in coarse for r in RANGES_UM))

    grey = work.trace(sand, "grey", {"spectrum": {"constant": 0.05}})
    for constants in SETS:
        spectrum = work.folder / f"{constants}.csv"
        work.run("spectra", "convert", f"fresnel:{constants}", "--range", "7-14", "--out", spectrum)
        curve = work.curve(grey, "--spectrum", f"quartz={spectrum}")
        line("Lambertian, hemispherical mean", constants, curve.emissivity)
    for what, name, material, beds in (
        ("Lambertian direction, by angle", "by_angle", dict(SPECULAR, specular=0), sand),
        *((f"specular, {bed}", "specular", SPECULAR, beds) for bed, beds in beds_of.items()),
    ):
        tables = work.trace(beds, name, material)
        for constants in SETS:
            curves[what] = work.curve(tables, "--spectrum", f"quartz=fresnel:{constants}")
            line(what, constants, curves[what].emissivity)
    for bed, beds in beds_of.items():
        for what, other in other_optics(work.trace(beds, "specular", SPECULAR)).items():
            line(f"{what}, {bed}", BEST, other)
    return {bed: curves[f"specular, {bed}"] for bed in beds_of}


def misses_table(curves, coarse):
    print(f"\n## Where the specular beds miss (bed less sample), `{BEST}`\n")
    at = (7.7, 8.0, 8.2, 8.5, 8.62, 8.75, 9.0, 9.3, 9.45, 9.7, 10.0, 10.5, 11.0, 11.5)
    head("bed", "um", *(f"{um:g}" for um in at))
    places = [np.abs(UM - um).argmin() for um in at]
    for bed, curve in curves.items():
        for m in coarse:
            row(bed, m.sample, *(f"{curve.emissivity[i] - m.emissivity[i]:+.3f}" for i in places))
        row(bed, "standard error", *(f"{curve.error[i]:.3f}" for i in places))
        row(bed, "valid", *("yes" if curve.valid[i] else "no" for i in places))


def shapes_table(work, coarse):
    """Returns the beds of each shape."""
    print(f"\n## Shape and porosity, coarse, specular, `{BEST}`\n")
    head(
        "bed",
        "porosity",
        "one hit, %",
        *(f"{m.sample} {a:g}-{b:g}" for m in coarse for a, b in RANGES_UM),
        "G(.3)",
        "G(.6)",
        "G(.9)",
    )
    beds, each = {}, []
    for name, change in BEDS.items():
        packings = PACKINGS if name in FRESNEL_BEDS else PACKINGS // 2
        beds[name] = work.drop(name, change, packings)
        tables = work.trace(beds[name], "specular", SPECULAR)
        curve = work.curve(tables).emissivity
        rms = [f"{m.rms(curve, r):.4f}" for m in coarse for r in RANGES_UM]
        pure = pure_bed(work.trace(beds[name], "grey", {"spectrum": {"constant": 0.05}}))
        series = [f"{reflectance(pure, facet):.4f}" for facet in (0.3, 0.6, 0.9)]
        row(name, f"{porosity(beds[name]):.3f}", f"{100 * pure['escaped'][1]:.1f}", *rms, *series)
        each += [evaluated([table], [sum(quartz()[3]) / 2])[0] for table in tables]
    if coarse:
        both = np.mean([m.emissivity for m in coarse], 0)
        near = [nearest_mean(each, target) for target in [m.emissivity for m in coarse] + [both]]
        samples = ", ".join([m.sample for m in coarse] + ["the mean of the samples"])
        print(f"\nWeighted means of these {len(each)} packings that are nearest to {samples}:\n")
        head(*(f"RMS from {m.sample}" for m in coarse))
        for curve in near:
            row(*(f"{m.rms(curve):.4f}" for m in coarse))
    return beds


def nearest_mean(curves, target, steps=20000):
    """The weighted mean of curves that is nearest to another (Frank and Wolfe's method)."""
    curves = np.array(curves)
    found = curves.mean(0)
    for _ in range(steps):
        towards = curves[(curves @ (found - target)).argmin()] - found
        length = towards @ towards
        share = np.clip(towards @ (target - found) / length, 0, 1) if length > 0 else 0
        if share == 0:
            break
        found = found + share * towards
    return found


def porosity(beds):
    reports = [json.loads(bed.with_name("drop.json").read_text()) for bed in beds]
    return np.mean([report["bed"]["interior_porosity"] for report in reports])


def pure_bed(tables):
    """Shares of paths by number of hits, among paths that Russian roulette did not end."""
    beds = [json.loads(path.read_text())["histogram"] for path in tables]
    of_each = np.zeros((2, len(beds), 129))
    for i, histogram in enumerate(beds):
        for kind, counts in zip(of_each, (histogram["escaped"], histogram["trapped"])):
            for state, by_group in counts:
                kind[i, state[0]] += sum(n for _, n in by_group)
    of_each /= of_each.sum((0, 2))[None, :, None]
    facets = np.arange(101) / 100
    series = (of_each[0] + of_each[1] / 2) @ facets[None, :] ** np.arange(129)[:, None]
    error = series.std(0, ddof=1).max() / np.sqrt(len(beds)) if len(beds) > 1 else None
    escaped, given_up = (np.trim_zeros(shares, "b").tolist() for shares in of_each.mean(1))
    return {"escaped": escaped, "given_up": given_up, "standard_error": error}


def reflectance(pure, facet):
    def series(shares):
        return sum(share * facet**n for n, share in enumerate(shares))

    return series(pure["escaped"]) + series(pure["given_up"]) / 2


def no_gaps(change):
    """The sand without its gaps between grains: the drop's default margin."""

    def changed(packing):
        packing.pop("drop")
        change(packing)

    return changed


def gaps(margin, shape):
    def changed(packing):
        of_shape(packing, shape)
        packing["drop"]["margin"] = margin

    return changed


def of_shape(packing, shape):
    for grain in packing["grains"]:
        grain["shape"] = shape


def of_one_size(packing):
    of_shape(packing, "angular")
    packing["grains"] = [dict(packing["grains"][0], diameter_um=300, count=144)]


BEDS = {
    "quartz_sand": lambda packing: None,
    "quartz_sand_touching": no_gaps(lambda packing: None),
    **{shape: no_gaps(lambda packing, shape=shape: of_shape(packing, shape)) for shape in SHAPES},
    "angular_one_size": no_gaps(of_one_size),
    "flake_gaps": gaps(0.4, "flake"),
    "chip_gaps": gaps(0.4, "chip"),
    "angular_gaps": gaps(0.5, "angular"),
}
# Beds that are traced in more packings and compared band by band.
FRESNEL_BEDS = ("quartz_sand", "quartz_sand_touching")


def modes_table(work, beds, others, measured):
    """Pure beds of each fraction, by all three ways."""
    print("\n## RMS by mode, fraction and range, beds of one fraction alone\n")
    head("fraction", "facets", "sample", *(f"{a:g}-{b:g} um" for a, b in RANGES_UM), "valid bands")
    grey = work.trace(beds, "grey", {"spectrum": {"constant": 0.05}})
    other = work.trace(others, "grey", {"spectrum": {"constant": 0.05}})
    fresnel = work.curve(work.trace(beds, "specular", SPECULAR))
    for size, diameter_um in (("fine", 25), ("medium", 85), ("coarse", 300)):
        powder = f"quartz_{size}"
        by_mode = {
            "library": work.curve(grey, "--spectrum", f"quartz={powder}"),
            "inverted": work.curve(grey, "--spectrum", f"quartz=inverted:{powder}"),
            "inverted, another bed": work.curve(other, "--spectrum", f"quartz=inverted:{powder}"),
            "fresnel": fresnel,
        }
        # The same bed in another size reflects alike; only its opaque bands differ.
        scaled = work.trace([resized(beds[0], diameter_um)], f"specular_{size}", SPECULAR)
        valid = work.curve(scaled).valid
        for mode, curve in by_mode.items():
            for m in measured.get(size, []):
                rms = [f"{m.rms(curve.emissivity, r):.4f}" for r in RANGES_UM]
                row(size, mode, m.sample, *rms, "all" if mode != "fresnel" else share(valid))
        for m in measured.get(size, []) if valid.any() else []:
            rms = [m.rms(fresnel.emissivity, r, valid) for r in RANGES_UM]
            cells = [f"{x:.4f}" if np.isfinite(x) else "none" for x in rms]
            row(size, "fresnel, valid bands alone", m.sample, *cells, share(valid))


def share(valid):
    return f"{100 * np.mean(valid):.0f} %"


def resized(bed, diameter_um):
    """A placed bed scaled from grains of 300 um to another diameter."""
    scene, factor = json.loads(bed.read_text()), diameter_um / 300
    placed = scene["geometry"]["placed"]
    for instance in placed["instances"]:
        instance["transform"] = [factor * x for x in instance["transform"]]
    domain = placed["domain"]
    for key in ("min_um", "max_um"):
        domain[key] = [factor * x for x in domain[key]]
    domain["floor"]["z_um"] *= factor
    path = bed.with_name(f"resized_{diameter_um}.json")
    path.write_text(json.dumps(scene))
    return path


def inversion_table(work, beds_of, pure):
    print("\n## Inverted by the shipped bed, seen on other beds: emissivity less the powder's\n")
    at = [np.abs(UM - um).argmin() for um in (8.5, 9.0, 11.0)]
    head(
        "bed",
        *(f"{size} at {UM[i]:g} um" for size in ("fine", "coarse") for i in at),
        "largest, coarse",
    )
    for name, beds in beds_of.items():
        tables = work.trace(beds, "grey", {"spectrum": {"constant": 0.05}})
        cells = []
        for size in ("fine", "coarse"):
            curve = work.curve(tables, "--spectrum", f"quartz=inverted:quartz_{size}")
            less = curve.emissivity - pure[size]
            cells += [f"{less[i]:+.4f}" for i in at]
        row(name, *cells, f"{less[np.abs(less).argmax()]:+.4f}")


def full_coverage(work, fine):
    print("\n## Full coverage with fines, 8 packings\n")
    out = work.folder / "full"
    what = ["--coverage", "full", "--packings", 8, "--tolerance", 0.01, "--range", "7.5-12"]
    if not (out / "run.json").is_file():
        work.run("pipeline", *what, "--out", out)
    tables = [out / f"packings/{i + 1}/table.json" for i in range(8)]
    inverted = [f"{m}=inverted:quartz_{size}" for m, size in FULL]
    curves = {
        "library": work.curve(tables),
        "inverted": work.curve(tables, *(x for text in inverted for x in ("--spectrum", text))),
    }
    head(
        "", "8-9.5 um, mean", "10-12 um, mean", "8.5 um", "9 um", *(f"RMS {m.sample}" for m in fine)
    )
    at = [np.abs(UM - um).argmin() for um in (8.5, 9.0)]
    shown = {name: curve.emissivity for name, curve in curves.items()}
    shown |= {f"measured fine, {m.sample}": m.emissivity for m in fine}
    for name, curve in shown.items():
        cells = [curve[(a - 1e-9 <= UM) & (b + 1e-9 >= UM)].mean() for a, b in RANGES_UM[1:]]
        cells += [curve[i] for i in at] + [m.rms(curve) for m in fine]
        row(name, *(f"{x:.4f}" for x in cells))
    return curves


FULL = (("fine", "fine"), ("coarse", "coarse"), ("floor", "coarse"))


def chart(work, name, curves, measured):
    """Computed and measured curves as a PNG, so that the library's points are not passed on."""
    files = []
    for label, curve in curves.items():
        files.append(work.folder / label)  # the name is the label
        rows = "".join(f"{um},{e:.6f}\n" for um, e in zip(UM, curve.emissivity))
        files[-1].write_text("wavelength_um,emissivity\n" + rows)
    files += [m.path for m in measured]
    work.run("spectra", "plot", *files, "--range", "7.5-12", "--out", work.folder / f"{name}.png")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("soilsig")
    parser.add_argument("folder")
    parser.add_argument("library", nargs="*", type=Path)
    parser.add_argument("--pure-bed", type=Path, help="write the shipped pure bed here")
    args = parser.parse_args()
    work = Work(args.soilsig, args.folder)
    sand = work.drop("quartz_sand")
    if args.pure_bed:
        made = pure_bed(work.trace(sand, "grey", {"spectrum": {"constant": 0.05}}))
        title = f"scenes/quartz_sand.json, view 10 degrees, the mean of {PACKINGS} packings"
        lists = {k: f"[{', '.join(f'{x:.10g}' for x in made[k])}]" for k in ("escaped", "given_up")}
        args.pure_bed.write_text(
            f'{{\n  "title": "{title}",\n  "standard_error": {made["standard_error"]:.2g},\n'
            f'  "escaped": {lists["escaped"]},\n  "given_up": {lists["given_up"]}\n}}\n'
        )
        return
    measured = {}
    for m in sorted(map(Measured, args.library), key=lambda m: m.sample):
        measured.setdefault(m.size, []).append(m)
    coarse, fine = measured.get("coarse", []), measured.get("fine", [])
    compared = {name: work.drop(name, BEDS[name]) for name in FRESNEL_BEDS}
    misses_table(steps_table(work, compared, coarse), coarse)
    beds_of = shapes_table(work, coarse)
    modes_table(work, sand, beds_of["worn"], measured)
    out = work.folder / "powder.csv"
    pure = {}
    for size in ("fine", "coarse"):
        work.run(
            "spectra",
            "convert",
            f"quartz_{size}",
            "--range",
            "7.5-12",
            "--step",
            0.01,
            "--out",
            out,
        )
        pure[size] = np.genfromtxt(out, delimiter=",", skip_header=1)[:, 1]
    inversion_table(work, beds_of, pure)
    beside = [text for m in coarse for text in ("--beside", m.path)]
    tables = work.trace(sand, "specular", SPECULAR)
    work.curve(tables, "--plot", work.folder / "fresnel_coarse.png", *beside)
    full = {f"traced, {mode}": curve for mode, curve in full_coverage(work, fine).items()}
    chart(work, "full_coverage", full, fine)


if __name__ == "__main__":
    main()
