"""Renders a scene that soilsig exported for Mitsuba 3, in any bands.

Reads a job from standard input, one JSON object:

    scene         path of the exported scene.xml
    reflectances  for each band, the reflectance of each material in the scene's order
    pixels        side of the film, which covers the sensor's view
    samples       paths through each pixel
    seeds         one render for each
    threads       of Mitsuba; absent: one for each core
    rr_depth      bounces after which Mitsuba may end paths by Russian roulette; absent: never

Writes a line for each render: the mean radiance over the film in each band under a sky of
radiance 1, and the CPU and wall seconds of rendering alone. The last line has the peak memory. The
mean is one minus the bed's emissivity (Kirchhoff's law).
"""

import json
import resource
import sys
import time

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")  # one path at a time with three bands; Embree finds its hits

BANDS = 3  # of a render


def cpu_s():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def main():
    job = json.load(sys.stdin)
    if "threads" in job:
        dr.set_thread_count(job["threads"])
    wanted = {key: job[key] for key in ("pixels", "samples", "rr_depth") if job.get(key)}
    # Or Mitsuba makes one of materials that are alike.
    scene = mi.load_file(job["scene"], optimize=False, **wanted)
    params = mi.traverse(scene)
    bands = job["reflectances"]
    for seed in job["seeds"]:
        means, spent_s, waited_s = [], 0.0, 0.0
        for first in range(0, len(bands), BANDS):
            # The last group is filled up with its last band.
            group = (bands[first : first + BANDS] + [bands[-1]] * BANDS)[:BANDS]
            for number, reflectance in enumerate(zip(*group)):
                params[f"material{number}.brdf_0.reflectance.value"] = list(reflectance)
            params.update()
            started_s, began_s = cpu_s(), time.perf_counter()
            image = np.array(mi.render(scene, seed=seed * 1009 + first))
            spent_s += cpu_s() - started_s
            waited_s += time.perf_counter() - began_s
            means += image.reshape(-1, 3).mean(axis=0, dtype=np.float64).tolist()
        render = {"means": means[: len(bands)], "cpu_s": spent_s, "wall_s": waited_s}
        print(json.dumps(render), flush=True)
    peak_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps({"peak_memory_mb": peak_kb / 1024, "mitsuba": mi.__version__}))


main()
