"""Documents name files, folders and headings that are there, and the contents list has every page."""

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


def anchors(path):
    """The headings of a document, as links name them."""
    prose = re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = re.findall(r"^#+ (.+)$", prose, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in found}


def lost(path):
    """Links of a document to headings that are not there."""
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", path.read_text("utf-8")) if "://" not in link and "#" in link]
    targets = {link: path.parent / link.partition("#")[0] if link[0] != "#" else path for link in links}
    return [link for link, to in targets.items() if to.suffix == ".md" and link.partition("#")[2] not in anchors(to)]


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_headings_that_are_linked_are_there(path):
    assert not lost(path)


def test_a_heading_that_is_gone_is_told(tmp_path):
    (tmp_path / "guide.md").write_text("# The Way\n\n[up](#the-way), [down](#the-end), [on](guide.md#the-way)\n")
    assert lost(tmp_path / "guide.md") == ["#the-end"]


def test_the_contents_list_has_every_page():
    contents = (ROOT / "docs" / "README.md").read_text("utf-8")
    pages = {path.name for path in ROOT.glob("docs/*.md")} - {"README.md"}
    within = "".join(path.read_text("utf-8") for path in ROOT.glob("docs/*.md"))
    assert not [page for page in pages if f"({page})" not in contents and f"({page})" not in within]
    assert pages - {"bench-claim.md", "bench-core.md", "bench-small.md"} <= set(re.findall(r"\(([\w-]+\.md)\)", contents))


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_document_names_is_there(path):
    assert not missing(path)


def test_a_path_that_is_gone_is_told(tmp_path):
    (tmp_path / "guide.md").write_text("`core/nowhere.py` and `core/errors.py`, [here](guide.md#top) and [there](gone.md)\n")
    assert missing(tmp_path / "guide.md") == ["core/nowhere.py", "gone.md"]
