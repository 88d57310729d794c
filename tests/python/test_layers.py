"""Imports run one way: a stage imports from stages before it, and never from the add-on."""

import ast
import os
import tempfile
import unittest

import soilsig_blender

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "blender_scripts")
# Files beside the folders of the stages go through all of them.
FLOORS = (*soilsig_blender.STAGES, "")


def imported(path, package):
    """The full names that a file of a package imports, inside functions as well."""
    with open(path, encoding="utf-8") as file:
        tree = ast.parse(file.read(), path)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else []
            whole = [*above, *(node.module.split(".") if node.module else [])]
            yield from ([*whole, alias.name] for alias in node.names)


def upward(root):
    """Every import below `root`/soilsig_blender that a lower stage takes from a higher one."""
    found = []
    top = os.path.join(root, "soilsig_blender")
    for folder, _, files in os.walk(top):
        for file in sorted(f for f in files if f.endswith(".py")):
            path = os.path.join(folder, file)
            package = os.path.relpath(folder, root).split(os.sep)
            stage = package[1] if len(package) > 1 else ""
            for name in imported(path, package):
                if name[0] == "soilsig_addon":
                    found.append((os.path.relpath(path, top), ".".join(name)))
                if name[0] != "soilsig_blender":
                    continue
                # Modules at the top are of no stage.
                from_stage = name[1] if len(name) > 1 and name[1] in FLOORS else ""
                if FLOORS.index(from_stage) > FLOORS.index(stage):
                    found.append((os.path.relpath(path, top), ".".join(name)))
    return found


class Layers(unittest.TestCase):
    def test_every_folder_is_a_stage(self):
        top = os.path.join(SCRIPTS, "soilsig_blender")
        folders = {entry.name for entry in os.scandir(top) if entry.is_dir()} - {"__pycache__"}
        self.assertEqual(folders, set(soilsig_blender.STAGES))

    def test_no_import_runs_upward(self):
        self.assertEqual(upward(SCRIPTS), [])

    def test_an_upward_import_is_found_however_it_is_written(self):
        lines = (
            "from ..drop.settle import drop",
            "from .. import make_bed",
            "from soilsig_blender import check",
            "import soilsig_blender.export.report",
            "def late():\n    from ..check import porosity",
            "import soilsig_addon.objects",
        )
        for line in lines:
            with tempfile.TemporaryDirectory() as root:
                folder = os.path.join(root, "soilsig_blender", "dust")
                os.makedirs(folder)
                with open(os.path.join(folder, "seats.py"), "w", encoding="utf-8") as file:
                    file.write(f"import numpy\nfrom ..model import shapes\n{line}\n")
                self.assertEqual(len(upward(root)), 1, line)


if __name__ == "__main__":
    unittest.main()
