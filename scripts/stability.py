"""Makes the atlas of failure and puts its table into docs/stability.md.

python3 scripts/stability.py PATH-OF-SOILSIG
"""

import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"


def main(soilsig):
    out = ROOT / "out" / "stress"
    subprocess.run([soilsig, "stress", "--out", out], check=True)
    shutil.copy(out / "atlas.png", ROOT / "docs" / "figures" / "atlas.png")
    page = ROOT / "docs" / "stability.md"
    before, rest = page.read_text().split(BEGIN)
    _, after = rest.split(END)
    page.write_text(before + BEGIN + (out / "atlas.md").read_text() + END + after)


if __name__ == "__main__":
    main(sys.argv[1])
