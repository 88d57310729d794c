"""Measures time and memory of a field, for 10^4 to 10^9 particles.

python3 scripts/scale.py SOILSIG SCENE.json [REPEATS]

Traces the placed scene as the patch of fields of many sizes, and alone within mirror sides, in
turns. Writes docs/figures/scale.csv and docs/figures/scale.svg for docs/measurements/scale.md.
Needs nothing but Python's own library.
"""

import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from math import log10 as log
from pathlib import Path

PARTICLES = (1e4, 1e5, 1e6, 1e7, 8.7e7, 4.24e8, 1e9)
RAYS = 1 << 15  # paths, for the time of a ray
FIGURES = Path(__file__).resolve().parent.parent / "docs/figures"
COLUMNS = (
    *("particles", "patches_x", "patches_y", "width_mm", "user_cpu_s", "wall_s", "peak_memory_mb"),
    *("paths", "half_width", "user_cpu_us_per_ray", "relative_to_patch"),
)


def main(soilsig, scene, repeats=5):
    scene = Path(scene).resolve()
    with tempfile.TemporaryDirectory() as folder:
        cases = {None: placed(scene, "mirror", folder)}
        for particles in PARTICLES:
            sides = {"field": {"particles": particles}}
            cases[particles] = placed(scene, sides, folder)
        rows = measure(soilsig, cases, int(repeats), Path(folder) / "table.json")
    with open(FIGURES / "scale.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    (FIGURES / "scale.svg").write_text(chart(rows))
    for row in rows:
        print(row)


def placed(scene, sides, folder):
    """The scene with other sides, as a file."""
    text = json.loads(scene.read_text())
    geometry = text["geometry"]["placed"]
    geometry["domain"]["sides"] = sides
    for prototype in geometry["prototypes"]:
        prototype["file"] = str(scene.parent / prototype["file"])
    for material in text["materials"]:
        if "file" in material["spectrum"]:
            material["spectrum"]["file"] = str(scene.parent / material["spectrum"]["file"])
    with tempfile.NamedTemporaryFile("w", suffix=".json", dir=folder, delete=False) as file:
        json.dump(text, file)
    return file.name


def run(soilsig, scene, table, *options):
    """User CPU seconds, wall seconds, peak memory in MB and the table."""
    start = time.monotonic()
    command = [soilsig, "trace", scene, "--out", str(table), *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.monotonic() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{' '.join(command)}: exit status {process.returncode}")
    return usage.ru_utime, wall, usage.ru_maxrss / 1024, json.loads(table.read_text())


def measure(soilsig, cases, repeats, table):
    """A row for each field: medians, and the least wall time, which other work only lengthens."""
    whole, per_ray = ({case: [] for case in cases} for _ in range(2))
    for _ in range(repeats):
        for case, scene in cases.items():
            load, *_ = run(soilsig, scene, table, "--paths", "32")
            all_rays, _, _, traced = run(soilsig, scene, table, "--paths", str(RAYS))
            # A path has one ray to each hit and one to the sky.
            rays = traced["hits"] + traced["paths"] - 32
            per_ray[case].append((all_rays - load) / rays * 1e6)
            if case is not None:
                whole[case].append(run(soilsig, scene, table))
    alone = statistics.median(per_ray[None])
    rows = []
    for case in PARTICLES:
        user, wall, memory, tables = zip(*whole[case], strict=True)
        field, ray = tables[0]["field"], statistics.median(per_ray[case])
        values = (
            field["particles"],
            *field["patches"],
            round(field["size_um"][0] / 1000, 3),
            round(statistics.median(user), 2),
            round(min(wall), 2),
            round(statistics.median(memory), 1),
            tables[0]["paths"],
            round(tables[0]["stop"]["half_width"], 4),
            round(ray, 3),
            round(ray / alone, 3),
        )
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


# The chart: three panels one above the other, particles from left to right.
LEFT, WIDTH, HEIGHT, GAP, TOP = 84, 600, 132, 40, 78
BLUE, GREY = "#1f5fa8", "#9a5b13"
NAMES = {3: "thousand", 6: "million"}


def chart(rows):
    """The rows as SVG."""
    across = Scale(4, 9.15, LEFT, LEFT + WIDTH)
    height = TOP + 3 * (HEIGHT + GAP) + 22
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" role="img" '
        f'viewBox="0 0 {LEFT + WIDTH + 40} {height}" '
        'font-family="Ubuntu, \'DejaVu Sans\', Arial, sans-serif" font-size="13" fill="#1a1a1a">',
        "<title>What a field costs against its particles</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        text(LEFT, 26, "A field costs what its patch costs", size=17),
        text(
            LEFT,
            46,
            "Load and trace to a half-width of 0.005 in 651 bands; brown: the founding paper",
        ),
    ]
    panels = (
        (
            "processor time, s (user, all threads)",
            "user_cpu_s",
            (0.1, 1, 10, 100, 1000),
            600,
            "one thread, 10 min",
        ),
        (
            "peak memory, MB",
            "peak_memory_mb",
            (10, 100, 1e3, 1e4, 1e5, 1e6),
            192 * 1024,
            "a machine of 192 GB",
        ),
        (
            "processor time of a ray, of the patch alone = 1",
            "relative_to_patch",
            (0, 0.5, 1, 1.5),
            None,
            None,
        ),
    )
    for number, (name, key, ticks, paper, note) in enumerate(panels):
        top = TOP + number * (HEIGHT + GAP)
        logs = paper is not None
        ends = (ticks[0], ticks[-1])
        up = Scale(*(map(log, ends) if logs else ends), top + HEIGHT, top)
        parts.append(text(LEFT, top - 7, name, weight="bold"))
        for tick in ticks:
            y = up(log(tick) if logs else tick)
            parts.append(line(LEFT, y, LEFT + WIDTH, y, "#dddddd"))
            parts.append(text(LEFT - 8, y + 4, label(tick), anchor="end"))
        for power in range(4, 10):
            x = across(power)
            parts.append(line(x, top, x, top + HEIGHT, "#eeeeee"))
        points = [
            (across(log(row["particles"])), up(log(row[key]) if logs else row[key])) for row in rows
        ]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        parts.append(f'<polyline points="{path}" fill="none" stroke="{BLUE}" stroke-width="2"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{BLUE}"/>' for x, y in points]
        if logs:
            y, left, right = up(log(paper)), across(log(87e6)), across(log(424e6))
            parts.append(line(left, y, right, y, GREY, 4))
            parts.append(text(left - 8, y + 4, note, anchor="end", fill=GREY))
    for power in range(4, 10):
        number, zeros = 10 ** (power % 3), power - power % 3
        name = f"{number} {NAMES[zeros]}" if zeros in NAMES else "1 billion"
        parts.append(text(across(power), height - 34, name, anchor="middle"))
    parts.append(text(LEFT + WIDTH / 2, height - 12, "particles in the field", anchor="middle"))
    return "\n".join([*parts, "</svg>\n"])


class Scale:
    """Maps a range of numbers to a range of places."""

    def __init__(self, low, high, start, end):
        self.low, self.per, self.start = low, (end - start) / (high - low), start

    def __call__(self, value):
        return self.start + (value - self.low) * self.per


def label(value):
    return f"{value:,.0f}".replace(",", " ") if value >= 10 else f"{value:g}"


def line(x1, y1, x2, y2, colour, width=1):
    return (
        f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="{colour}" stroke-width="{width}"/>'
    )


def text(x, y, words, anchor="start", size=13, weight="normal", fill="#1a1a1a"):
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
        f'font-weight="{weight}" fill="{fill}">{words}</text>'
    )


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
