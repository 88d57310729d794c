"""Scenes."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import _soilsig


class Scene:
    """What is looked at, from where, of what: the content of a scene file, checked.

    Parameters
    ----------
    given : path or mapping
        A scene file, or its content. Relative paths in the content are those of the working folder.

    Attributes
    ----------
    content : dict
        The content. Its paths hold in any folder. The keys are those of the scene reference.

    Raises
    ------
    Error
        A key that is unknown, or a value that does not fit.
    """

    content: dict[str, Any]

    def __init__(self, given: Mapping[str, Any] | str | os.PathLike | Scene) -> None:
        if isinstance(given, Scene):
            given = given.content
        if isinstance(given, Mapping):
            text, folder = json.dumps(given), "."
        else:
            text, folder = Path(given).read_text(encoding="utf-8"), Path(given).parent
        self.content = json.loads(_soilsig.scene(text, os.fspath(folder)))

    @property
    def name(self) -> str:
        """Its name."""
        return self.content["name"]

    def write(self, file: str | os.PathLike) -> Path:
        """Write the scene file."""
        path = Path(file)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(self.content, indent=2) + "\n", encoding="utf-8")
        return path

    def __repr__(self) -> str:
        return f"<soilsig.Scene {self.name}>"
