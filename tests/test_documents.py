"""Documents name files and folders that are there."""

import re

import pytest
from imports import ROOT

FOLDERS = "core|rigs|s2ag_blender|tests|docs|examples|farm|presets"
DOCUMENTS = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("*/README.md")]


def missing(path):
    """Paths in code style and targets of links that a document names and nobody has."""
    text = path.read_text("utf-8")
    named = re.findall(rf"`((?:{FOLDERS})/[\w./-]*)`", text)
    linked = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    return [name for name in named if not (ROOT / name).exists()] + [
        name for name in linked if not (path.parent / name).exists()
    ]


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_document_names_is_there(path):
    assert not missing(path)


def test_a_path_that_is_gone_is_told(tmp_path):
    (tmp_path / "guide.md").write_text("`core/nowhere.py` and `core/errors.py`, [here](guide.md#top) and [there](gone.md)\n")
    assert missing(tmp_path / "guide.md") == ["core/nowhere.py", "gone.md"]
