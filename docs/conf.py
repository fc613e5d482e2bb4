"""The site of the documents: ``nox -s site`` builds it into ``dist/site``, and fails where a link leads nowhere.

The pages are the Markdown files as they are; the contents list of the site is that of ``docs/README.md``.
"""

import re

project = "S2AG for Blender"
copyright = "S2AG for Blender contributors"
extensions = ["myst_parser"]
root_doc = "docs/README"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "examples/README.md"]
myst_heading_anchors = 4
html_theme = "alabaster"
html_theme_options = {"description": "Speech to gesture for Blender characters", "page_width": "70em", "fixed_sidebar": True}
html_show_sphinx = False
suppress_warnings = ["myst.header", "toc.not_included"]  # levels of headings may be skipped; tables of figures are linked
LISTED = ["../README.md", "../CONTRIBUTING.md", "../CHANGELOG.md", "../examples/README.md"]


def add_contents(app, page, source):
    """Give the first page the contents list that the sidebar shows: each heading with the pages below it."""
    if page != root_doc:
        return
    lists = [("Start", LISTED[:1])]
    for part in source[0].split("\n## ")[1:]:
        lists.append((part.partition("\n")[0], re.findall(r"^- \[[^]]*\]\(([^)]+\.md)\)", part, re.MULTILINE)))
    lists.append(("The repository", LISTED[1:]))
    for title, pages in lists:
        source[0] += f"\n\n```{{toctree}}\n:caption: {title}\n:hidden:\n\n" + "\n".join(pages) + "\n```\n"


def setup(app):
    """Connect to Sphinx."""
    app.connect("source-read", add_contents)
