"""Errors, interrupts and progress."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest

import soilsig
from conftest import PATCH
from soilsig import _run


@pytest.mark.parametrize(
    ("args", "status"),
    [
        (["trace", "missing.json", "--out", "t.json"], 3),
        (["signature", "missing.json"], 3),
        (["spectra", "show", "nothing_of_this_name"], 3),
        (["trace", "x.json", "--out", "t.json", "--range", "12-8"], 2),
        (["spectra", "show", "1.5"], 2),
    ],
)
def test_errors_have_the_words_of_the_command_line(args, status, program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _, said = program(*args, status=status)
    with pytest.raises(soilsig.Error) as caught:
        soilsig.run(args)
    error = caught.value
    assert error.status == status
    assert f"error: {error.message}" in said
    assert error.hint is None or f"hint: {error.hint}" in said


def test_errors_of_the_library_are_exceptions_too(table):
    with pytest.raises(soilsig.Error, match="not a material of the table: fine"):
        table.emissivity({"clay": 0.9})
    with pytest.raises(soilsig.Error, match="within 0 to 1"):
        table.emissivity({"fine": 1.5})
    with pytest.raises(soilsig.Error, match="scatters in other directions"):
        table.emissivity({"fine": "fresnel:quartz"})
    with pytest.raises(soilsig.Error) as caught:
        table.emissivity(wavelength=[5.0])
    assert caught.value.status == 3
    with pytest.raises(soilsig.Error, match=r"twice|ascending"):
        soilsig.Spectrum(([8.0, 8.0], [0.5, 0.5]))
    with pytest.raises(ValueError, match="as many"):
        soilsig.Spectrum(([8.0, 9.0], [0.5]))
    with pytest.raises(soilsig.Error, match="soilsig_scene"):
        soilsig.Scene({"name": "empty"})


def test_a_wrong_word_is_an_error_and_help_is_an_answer():
    with pytest.raises(soilsig.Error, match="unrecognized subcommand"):
        soilsig.run(["sing"])
    assert soilsig.run(["--version"]).text.startswith("soilsig ")
    assert "--tolerance" in soilsig.run(["trace", "--help"]).text


def test_a_result_that_is_less_than_was_asked_for_warns(tmp_path):
    with pytest.warns(UserWarning, match="tolerance was not reached"):
        table = soilsig.trace(PATCH, out=tmp_path / "t.json", tolerance=1e-4, max_paths=4096)
    assert table.paths == 4096


def test_ctrl_c_stops_a_trace_and_leaves_nothing_half_written(tmp_path):
    # A program started in the background ignores SIGINT, and so do its children.
    script = f"""
        import signal
        import soilsig
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            soilsig.trace({str(PATCH)!r}, out="t.json", tolerance=1e-5, max_paths=2**40)
        except KeyboardInterrupt:
            print("stopped")
    """
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    # Until the bar shows paths.
    said = ""
    while "paths/s" not in said:
        said += process.stderr.read(1)
    os.kill(process.pid, signal.SIGINT)
    assert process.communicate(timeout=300)[0] == "stopped\n"
    assert process.returncode == 0
    assert {path.name for path in tmp_path.iterdir()} <= {"t.json.partial"}


def test_other_threads_run_meanwhile(tmp_path):
    turns = []
    done = threading.Event()

    def turn():
        while not done.is_set():
            turns.append(1)
            time.sleep(0.001)

    other = threading.Thread(target=turn)
    other.start()
    soilsig.trace(PATCH, out=tmp_path / "t.json", tolerance=0.02)
    done.set()
    other.join()
    assert len(turns) > 4, "the interpreter was held"


def test_progress_is_a_bar(tmp_path, monkeypatch):
    bars = []

    class Bar:
        def __init__(self, desc, leave):
            self.desc, self.places, self.n, self.total = desc, [], 0, None
            bars.append(self)

        def refresh(self):
            self.places.append((self.n, self.total))

        def close(self):
            self.closed = True

    monkeypatch.setattr(_run, "tqdm", Bar)
    soilsig.trace(PATCH, out=tmp_path / "t.json", tolerance=0.01)
    assert [bar.desc for bar in bars] == ["load", "trace"]
    assert all(bar.closed for bar in bars)
    places = bars[1].places
    assert places and all(0 <= n <= total for n, total in places)
    monkeypatch.setattr(_run, "tqdm", None)
    soilsig.trace(PATCH, out=tmp_path / "t.json", tolerance=0.05)
