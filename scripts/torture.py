"""Kills runs, lets writes fail and fills disks, and looks for half files, orphans and leftovers.

python3 scripts/torture.py PROGRAM [--kills N] [--errors N] [--disks N] [--seed N]
                                   [--blender PATH] [--with-blender SHARE]

Each trial begins with a whole result of seed 1 in the folder. A run of seed 2 is disturbed. Then
the folder must hold the result of seed 1 or that of seed 2, or no record at all (after a kill), and
no process of it may live. The same run, undisturbed, must give the bytes of a clean run and leave
nothing behind. With Blender, whose runs take long, it follows each fifth disturbed run only. One
line tells each finding; the exit status is 1 if there is any.
"""

import argparse
import errno
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LEFT = (".soilsig-", ".making-", "soilsig-", "blender.unfinished", "blender_")
PIT = "\n".join(
    [f"v {x} {y} {z}" for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    + ["usemtl rock", "f 1 2 3 4", "f 1 5 6 2", "f 2 6 7 3", "f 3 7 8 4", "f 4 8 5 1", ""]
)
PLACED = {
    "soilsig_scene": 1,
    "name": "pit",
    "seed": 1,
    "temperature_k": 300,
    "view": {"zenith_deg": 0},
    "materials": [{"name": "rock", "spectrum": {"constant": 0.5}}],
    "geometry": {"placed": {"prototypes": [{"name": "pit", "file": "pit.obj", "unit_um": 1000}]}},
}


# As `scenes/small.json`, but as quickly dropped as Blender starts.
FEWER = {"count": 2, "fines": 4}


def recipe(path):
    """A scene of two grains, from the shipped one."""
    scene = json.loads((ROOT / "scenes/small.json").read_text())
    packing = scene["geometry"]["packing"]
    packing["grains"] = [packing["grains"][0] | FEWER]
    packing |= {"tray_um": [1500, 1500], "crop_um": 200}
    path.write_text(json.dumps(scene))
    return path


def ended(run, seconds):
    """What a run said, within so many seconds in which this program itself is not stopped."""
    for _ in range(10 * seconds):
        try:
            return run.communicate(timeout=0.1)[1]
        except subprocess.TimeoutExpired:
            pass
    run.kill()
    raise SystemExit(f"FOUND: a run goes on for over {seconds} s")


class Trial:
    """A folder for results, one for the cache and one for temporary files."""

    def __init__(self, program, folder, scene, blender, whole=None):
        self.program, self.folder, self.scene, self.blender = program, folder, scene, blender
        self.earlier = folder.parent / (folder.name + ".earlier")
        self.findings = []
        self.disturbed = 0
        if whole is None:
            self.reset(empty=True)
            self.first = self.clean("1")
            if self.earlier.exists():
                shutil.rmtree(self.earlier)
            shutil.copytree(self.out, self.earlier)
            self.reset(empty=True)
            self.second = self.clean("2")
        else:
            self.earlier = whole.earlier
            self.first, self.second, self.seconds = whole.first, whole.second, whole.seconds

    @property
    def out(self):
        return self.folder / "out"

    def reset(self, empty=False):
        """The earlier result, and an empty cache."""
        for name in ("out", "cache", "tmp"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        (self.folder / "cache").mkdir(mode=0o700)
        (self.folder / "tmp").mkdir()
        if not empty:
            shutil.copytree(self.earlier, self.out)

    def start(self, seed, **more):
        args = [self.program, "pipeline", "--scene", self.scene, "--out", self.out, "--seed", seed]
        args += ["--range", "8-10", "--step", "1", "--tolerance", "0.03", "--threads", "1"]
        places = {"SOILSIG_CACHE": self.folder / "cache", "TMPDIR": self.folder / "tmp"}
        places["SOILSIG_BLENDER"] = self.blender or "/nowhere"
        environment = os.environ | {k: str(v) for k, v in (places | more).items()}
        return subprocess.Popen(
            list(map(str, args)),
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def clean(self, seed):
        began = time.monotonic()
        run = self.start(seed)
        said = ended(run, 900)
        # What is in the cache is not made again.
        self.seconds = max(time.monotonic() - began, 0.5 * getattr(self, "seconds", 0))
        if run.returncode not in (0, 4):
            raise SystemExit(f"a run that nothing disturbs ends with {run.returncode}: {said}")
        return self.found()

    def found(self):
        """The files that are the same in every run; None without a record."""
        try:
            record = json.loads((self.out / "run.json").read_text())
        except FileNotFoundError:
            return None
        sums = {}
        for name, output in record["outputs"].items():
            sum_now = hashlib.sha256((self.out / name).read_bytes()).hexdigest()
            if sum_now != output["sha256"]:
                self.findings.append(f"{name} is not as recorded")
            if output["reproducible"]:
                sums[name] = sum_now
        return sums

    def left(self):
        return [
            str(Path(folder, name))
            for place in ("out", "cache", "tmp")
            for folder, folders, files in os.walk(self.folder / place)
            for name in folders + files
            if name.startswith(LEFT)
        ]

    def orphans(self):
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit() and int(entry.name) != os.getpid():
                try:
                    words = (entry / "cmdline").read_bytes()
                    state = (entry / "stat").read_text().rsplit(")", 1)[1].split()[0]
                except OSError:
                    continue
                if bytes(self.folder) in words and state != "Z":
                    found.append(f"process {entry.name}")
        return found

    def judge(self, what, may_be_gone):
        """What is there after a disturbed run, and after the next one."""
        before = len(self.findings)
        now = self.found()
        if now is None and not may_be_gone:
            self.findings.append("the earlier result is gone")
        if now is not None and now not in (self.first, self.second):
            self.findings.append("the result is a mixture")
        for _ in range(100):
            if not self.orphans():
                break
            time.sleep(0.05)
        self.findings += self.orphans()
        self.disturbed += 1
        if not self.blender or self.disturbed % 5 == 0:
            if self.clean("2") != self.second:
                self.findings.append("the next run gives other bytes")
            self.findings += [f"left over: {path}" for path in self.left()]
        for finding in self.findings[before:]:
            print(f"FOUND {what}: {finding}", flush=True)
        return now == self.second


def kills(trial, number, chance):
    counts = {"while running": 0, "after the end": 0}
    i = 0
    while counts["while running"] < number:
        # What killed runs left stays until a run that nothing disturbs.
        if not trial.blender or i % 5 == 0:
            trial.reset()
        # Some in the first milliseconds, where programs are started.
        span = 0.02 if i % 5 == 0 else trial.seconds
        wait = chance.uniform(0, span)
        how = chance.choice([signal.SIGKILL] * 3 + [signal.SIGTERM, signal.SIGINT])
        run = trial.start("2")
        time.sleep(wait)
        is_running = run.poll() is None
        run.send_signal(how)
        said = ended(run, 60)
        counts["while running" if is_running else "after the end"] += 1
        if "panicked" in said:
            trial.findings.append(said)
        trial.judge(f"{how.name} after {wait:.4f} s", may_be_gone=True)
        i += 1
    return counts


def errors(trial, number, chance, library):
    counts = {"failed": 0, "not reached or borne": 0}
    most = 400
    for _ in range(number):
        trial.reset()
        at = chance.randint(1, most)
        code = chance.choice([errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS])
        more = {"LD_PRELOAD": library, "FAIL_AT": at, "FAIL_WITH": code}
        if chance.random() < 0.5:
            more["FAIL_ON"] = 1
        run = trial.start("2", **more)
        said = ended(run, 900)
        what = f"write {at} fails with {errno.errorcode[code]}"
        if run.returncode in (0, 4):
            counts["not reached or borne"] += 1
            most = max(40, min(most, at + 20))
        else:
            counts["failed"] += 1
            if said.count("error: ") != 1 or "panicked" in said:
                trial.findings.append(f"not one clear line: {said}")
                print(f"FOUND {what}: {trial.findings[-1]}", flush=True)
        trial.judge(what, may_be_gone=False)
    return counts


def disks(whole, number, chance, folder):
    """Full disks of their own, which only root and users with namespaces may make."""
    counts = {"failed": 0, "large enough": 0}
    disk = folder / "disk"
    disk.mkdir()
    for _ in range(number):
        which = chance.choice(["out", "cache", "tmp"])
        trial = Trial(whole.program, folder / "on_disks", whole.scene, whole.blender, whole)
        trial.findings = whole.findings
        trial.folder.mkdir(exist_ok=True)
        trial.reset()
        place = trial.folder / which
        size = chance.choice(
            [f"size={chance.randint(4, 600)}k", f"nr_inodes={chance.randint(2, 40)}"]
        )
        mounted = ["mount", "-t", "tmpfs", "-o", f"{size},mode=700", "tmpfs", str(disk)]
        if subprocess.run(mounted, stderr=subprocess.DEVNULL).returncode:
            return {"left out: mounting is not allowed": number}
        try:
            try:
                shutil.copytree(place, disk, dirs_exist_ok=True)
            except (OSError, shutil.Error):
                continue  # Too small for the earlier result.
            shutil.rmtree(place)
            place.symlink_to(disk)
            run = trial.start("2")
            said = ended(run, 900)
            what = f"{which} on a disk of {size}"
            if run.returncode in (0, 4):
                counts["large enough"] += 1
            else:
                counts["failed"] += 1
                if said.count("error: ") != 1 or "panicked" in said or run.returncode != 1:
                    trial.findings.append(f"status {run.returncode}: {said}")
                    print(f"FOUND {what}: {trial.findings[-1]}", flush=True)
                if trial.found() != trial.first:
                    trial.findings.append("the earlier result has changed")
                    print(f"FOUND {what}: {trial.findings[-1]}", flush=True)
        finally:
            if place.is_symlink():
                place.unlink()
            subprocess.run(["umount", str(disk)], check=True)
    return counts


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--errors", type=int, default=200)
    parser.add_argument("--disks", type=int, default=60)
    parser.add_argument("--blender", help="also with beds that this Blender drops")
    parser.add_argument("--with-blender", type=float, default=0.2, help="share of those trials")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    program = options.program.resolve()
    found = 0
    with tempfile.TemporaryDirectory(prefix="torture-") as name:
        folder = Path(name)
        library = folder / "failing_writes.so"
        source = ROOT / "scripts/failing_writes.c"
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, source], check=True)
        (folder / "pit.obj").write_text(PIT)
        (folder / "pit.json").write_text(json.dumps(PLACED))
        scenes = [("placed", folder / "pit.json", None, 1.0)]
        if options.blender:
            small = recipe(folder / "small.json")
            scenes.append(("by Blender", small, options.blender, options.with_blender))
            scenes[0] = (*scenes[0][:3], 1 - options.with_blender)
        for title, scene, blender, share in scenes:
            place = folder / title.replace(" ", "_")
            place.mkdir()
            trial = Trial(program, place, scene, blender)
            number = {
                name: max(1, round(getattr(options, name) * share))
                for name in ("kills", "errors", "disks")
            }
            print(f"{title}: a run takes {trial.seconds:.2f} s", flush=True)
            print("  kills", kills(trial, number["kills"], chance), flush=True)
            print("  errors", errors(trial, number["errors"], chance, library), flush=True)
            if not blender:
                print("  disks", disks(trial, number["disks"], chance, folder), flush=True)
            found += len(trial.findings)
    print(f"findings: {found}")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
