"""Every error and warning that can reach Blender is told in every language, with its names at their places."""

import ast
import re

import pytest
from s2ag.core import errors
from s2ag.s2ag_blender import translations
from translated_texts import FOLDER, lacking, template

STOPS = (".", "。")
WARNING = ("warnings.append", "self.warn", "self._tell")


ELSEWHERE = (
    *("core/cli", "core/batch", "core/study", "core/learning", "core/sampling", "core/vectors/build.py"),
    *("core/model/config.py", "core/model/checkpoint_import.py", "core/model/safe_pickle.py"),
    *("s2ag_blender/render/job.py", "s2ag_blender/render/sheet.py", "s2ag_blender/program.py", "s2ag_blender/ui/command.py"),
)
"""What runs in other processes, for other people."""


def texts_of_errors():
    """Message and remedy of every error, and every warning, that can reach Blender."""
    kinds = {name for name, value in vars(errors).items() if isinstance(value, type) and issubclass(value, errors.S2agError)}
    for path in (path for folder in ("core", "rigs", "s2ag_blender") for path in (FOLDER.parent / folder).rglob("*.py")):
        place = path.relative_to(FOLDER.parent).as_posix()
        if place.startswith(ELSEWHERE):
            continue
        tree = ast.parse(path.read_text("utf-8"))
        named = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                named.setdefault(node.targets[0].id, []).extend(template(node.value))
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in kinds | {"cls", "_lose"}:
                for argument in node.args[:2]:
                    yield from named.get(argument.id, []) if isinstance(argument, ast.Name) else template(argument)
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(WARNING) and len(node.args) == 1:
                yield from template(node.args[0])


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_every_error_has_a_translation(locale):
    said = {text for text in texts_of_errors() if sum(letter.isalpha() for letter in text) > 7}
    assert not (missing := lacking(said, "errors", locale)), missing
    for text, translated in translations.errors(locale).items():
        assert text.endswith(".") == translated.endswith(STOPS), text
        names = [f"<{number}>" for number in range(text.count("{}"))]
        assert sorted(re.findall(r"<\d>", translated.format(*names))) == names, text


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_an_error_keeps_its_names_at_their_places(locale):
    """Translations that turn the sentence round number its names."""
    told = translations.translate_sentence(locale, "The recording /a {b} c.wav does not exist.")
    assert "/a {b} c.wav" in told and "does not" not in told
    told = translations.translate_sentence(locale, 'Write {"sch": "SH", "a": "AA", ...}.')
    assert '{"sch": "SH", "a": "AA", ...}' in told and not told.startswith("Write")
    turned = translations.translate_sentence(locale, "a.csv is cut off: it ends after 2 s where its header promises 9 s.")
    assert all(turned.count(name) == 1 for name in ("a.csv", "2", "9")) and "header" not in turned


def test_errors_are_told_in_german_with_their_names():
    told = translations.translate_sentence("de_DE", "The recording /a {b} c.wav does not exist.")
    assert told == "Die Aufnahme /a {b} c.wav gibt es nicht."
    assert translations.translate_sentence("de_DE", "Nobody thought of this.") == "Nobody thought of this."
    assert translations.translate_sentence("de_DE", "There is no Python in /a/b.") == "In /a/b ist kein Python."
