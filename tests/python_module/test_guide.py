"""The Python of the guide runs."""

import re

from conftest import NEEDS_BLENDER, ROOT


@NEEDS_BLENDER
def test_the_code_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    page = (ROOT / "docs" / "guide" / "python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) >= 4
    names = {}
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)
    assert set(names["slopes"].material.values) == {"fine", "coarse", "floor"}
    assert "quartz_fine" in capsys.readouterr().out
