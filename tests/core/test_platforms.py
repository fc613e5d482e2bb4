"""Rules of Windows and macOS that hold anywhere: their path classes, reserved names, folders and the encodings of consoles."""

import os
import random
import re
import subprocess
import sys
from pathlib import Path, PureWindowsPath

import pytest
from s2ag.core import user_folders
from s2ag.core.batch import clip

ROOT = Path(__file__).parents[2]
FORBIDDEN = re.compile(r'[<>:"/\\|?*\x00-\x1f]|[. ]$')
"""What no name on Windows may hold or end with (Microsoft, "Naming Files, Paths, and Namespaces")."""
PIECES = ["CON", "nul", "COM1", "lpt9", ".", "..", " ", ":", "a", "é", "ä" * 90, "/", "\\", "?", "\t", "\u2028", "|", "$"]


def test_names_made_of_any_text_are_names_on_windows():
    chance = random.Random(0)
    for _ in range(2000):
        name = clip.safe_name("".join(chance.choices(PIECES, k=chance.randrange(1, 6))))
        assert name and not FORBIDDEN.search(name) and not PureWindowsPath(name).is_reserved(), name
        assert PureWindowsPath(name).name == name and len(name.encode()) < 240


@pytest.mark.parametrize(
    ("platform", "data", "cache"),
    [
        ("win32", "local/s2ag/Data", "local/s2ag/Cache"),
        ("darwin", "home/Library/Application Support/s2ag", "home/Library/Caches/s2ag"),
    ],
)
def test_folders_are_where_the_platform_has_them(monkeypatch, tmp_path, platform, data, cache):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("S2AG_DATA", raising=False)
    assert user_folders.data() == tmp_path / data and user_folders.cache() == tmp_path / cache


@pytest.mark.timeout(60)
@pytest.mark.parametrize("page", ["cp437", "cp932", "cp1252", "ascii"])
def test_a_console_of_any_code_page_shows_sentences(tmp_path, page):
    """Nor is any text read or written in the machine's encoding: Python warns of it, and the warning is an error."""
    text = tmp_path / "ナレーション ’é.txt"
    text.write_text("I do not know – it is „really“ great.", "utf-8")
    options = ["-X", "utf8=0", "-X", "warn_default_encoding", "-W", "error::EncodingWarning:s2ag"]
    environment = {**os.environ, "PYTHONIOENCODING": page, "LC_ALL": "C", "OMP_NUM_THREADS": "1"}
    out = tmp_path / "é.npz"
    command = [sys.executable, *options, "-m", "s2ag", "synth", ROOT / "examples" / "hello.flac"]
    command += ["--transcript", text, "-o", out]
    done = subprocess.run(command, capture_output=True, env=environment)
    assert done.returncode == 0 and out.is_file() and b"Error" not in done.stderr, done.stderr[-1500:].decode(page, "replace")
    missing = [*command[:-3], tmp_path / "没有.txt", "-o", out]
    done = subprocess.run(missing, capture_output=True, env=environment)
    assert done.returncode and b"Traceback" not in done.stderr, done.stderr[-1500:].decode(page, "replace")
