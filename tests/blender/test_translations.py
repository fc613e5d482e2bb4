"""Every word that the extension shows has one in every language; they are found in the registered classes and in the source."""

import ast
import json
import re
import string
import unicodedata

import bpy
import pytest
import s2ag
from s2ag.core import errors
from s2ag.core.motion import skeleton
from s2ag.core.worker.interpreter import Check
from s2ag.rigs.faces import shapes
from s2ag.s2ag_blender import registration, translations
from s2ag.s2ag_blender.rig import readiness
from s2ag.s2ag_blender.takes import bone_map_files, menu_items, stages
from s2ag.s2ag_blender.ui import marks, setting_properties
from s2ag.s2ag_blender.ui.properties import S2AG_Settings
from translated_texts import FOLDER, lacking, literals, template

PRESETS = FOLDER.parent / "presets"
SHOWN = {"text", "heading"}
TOLD = {"translate": 0, "_row": 1, "pgettext_rpt": 0, "pgettext_iface": 0}
REFUSED = {"report": 1, "poll_message_set": 0}
"""Calls whose text Blender does not translate by itself, with the place of the text among the arguments."""
SENTENCE = re.compile(r"[A-Z][a-z']+ [\w'{}-]+ .*[^.;,(]$")
NAMES = {"S2AG", "PyTorch", "Python", "Version", "Take", "Takes", "BVH", "FBX", "GLB", "Film", "Frames", "Hand L", "Hand R"}
"""What may be the same in another language."""
STOPS = (".", "。")
KEPT = re.compile(
    r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])|--[a-z-]+|\bS2AG_\w+|\bs2ag (?:bench|checkpoint|data|rig|synth)\b|s2ag\[[a-z,]+\]"
    r"|\b(?:Esc|Tab|Alt [A-Z])\b|(?<!\w)\.[a-z]{2,11}\b|\b(?:docs|core)/\S+\.(?:md|py)|\bpip install\b|\b[A-Z]{3,}\b"
)
"""Numbers, options, commands, keys, kinds of file and names that a user types or reads elsewhere."""


@pytest.fixture
def extension():
    s2ag.register()
    yield
    s2ag.unregister()


def trees():
    for path in sorted(FOLDER.rglob("*.py")):
        yield path, ast.parse(path.read_text("utf-8"))


def calls():
    """Every call in the package: file, name of what is called, node."""
    for path, tree in trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call):
                function = node.func
                name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
                yield path, name, node


def texts_of_calls():
    for _, name, node in calls():
        if any(word.arg == "translate" for word in node.keywords):
            continue
        for word in node.keywords:
            if word.arg in SHOWN:
                yield from literals(word.value)
        if name in TOLD and node.args:
            yield from literals(node.args[TOLD[name]])


def properties(cls):
    """The properties that a class of ours declares, as Blender has them once the class is registered."""
    declared = {
        name: value
        for base in cls.__mro__
        if base.__module__.startswith("s2ag.")
        for name, value in getattr(base, "__annotations__", {}).items()
    }
    if issubclass(cls, bpy.types.Operator):
        rna = getattr(bpy.ops.s2ag, cls.bl_idname.partition(".")[2]).get_rna_type()
    else:
        rna = cls.bl_rna
    return [rna.properties[name] for name in declared if not rna.properties[name].is_hidden]


def described(cls):
    return getattr(bpy.ops.s2ag, cls.bl_idname.partition(".")[2]).get_rna_type().description


def texts_of_classes():
    """Labels, descriptions, tabs and properties with their choices."""
    for cls in registration.CLASSES:
        if not issubclass(cls, (bpy.types.PropertyGroup, bpy.types.AddonPreferences)):
            yield getattr(cls, "bl_label", "")
            yield getattr(cls, "bl_category", "")
            if issubclass(cls, bpy.types.Operator):
                yield described(cls)
        for prop in properties(cls):
            yield from (prop.name if prop.name != prop.identifier else "", prop.description)
            if prop.type == "ENUM":
                for item in prop.enum_items_static:
                    yield from (item.name, item.description)


def texts_of_choices():
    """Names and descriptions of choices that are made while Blender runs: (identifier, name, description, number)."""
    for _, tree in trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.Tuple) and len(node.elts) == 4 and not literals(node.elts[3]):
                name, description = map(literals, node.elts[1:3])
                if name and description:
                    yield from (*name, *description)


def texts_of_headings():
    """Headings within menus of choices."""
    return list(menu_items.TEMPERAMENTS)


def texts_of_reasons():
    """Sentences that functions return or keep under a name, to be told by their callers, and the names of stages."""
    for _, tree in trees():
        for node in ast.walk(tree):
            if isinstance(node, (ast.Return, ast.Assign)) and node.value is not None:
                yield from (text for text in literals(node.value) if SENTENCE.match(text))
            targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
            if any(ast.unparse(target).endswith("stage") for target in targets):
                yield from literals(node.value)
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple):
                parts = node.targets[0].elts if isinstance(node.targets[0], ast.Tuple) else node.value.elts
                for target, value in zip(parts, node.value.elts, strict=False):
                    if ast.unparse(target).endswith("stage"):
                        yield from literals(value)
    for path in (FOLDER.parent / "core" / "synthesis").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("stages.run", "stages.within") and node.args:
                yield from literals(node.args[0])


def test_every_stage_is_shown_in_words_for_people(extension):
    """What the engine calls its stages ("extract MFCC") is for its developers."""
    engines = {text for text in texts_of_reasons() if text and text[0].islower()}
    assert engines <= {*stages.SHOWN, "engine"} and len(engines) > 8
    assert all(text[0].isupper() for text in stages.SHOWN.values())


def wanted():
    found = {*texts_of_calls(), *texts_of_classes(), *texts_of_choices(), *texts_of_headings(), *texts_of_reasons()}
    found |= {readiness.label(part) for part in (*bone_map_files.ORDER, *skeleton.EDGE_NAMES, "left_fingers", "right_fingers")}
    found |= {text for _, *texts in menu_items.kinds() for text in texts}
    found |= {text for _, *texts in marks.mark_items() for text in texts}
    found |= {*shapes.PARTS, Check.stage, *stages.SHOWN.values()}
    found |= {one.short for one in setting_properties.SETTINGS.values()}
    found -= stages.SHOWN.keys()
    found |= {bpy.path.display_name(path.name, title_case=False) for path in PRESETS.rglob("*.py")}
    return {text for text in found if any(letter.isalpha() for letter in text)}


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_every_text_has_a_translation(extension, locale):
    assert not (missing := lacking(wanted(), "", locale)), missing


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_few_texts_wait_for_a_translator(locale):
    """Somebody who adds a button need not know all languages; the next one to land finds no more than a change's worth."""
    waiting = [
        text
        for folder in ("", "errors", "styles")
        for text, told in json.loads((FOLDER / "translations" / folder / f"{locale}.json").read_text("utf-8")).items()
        if not told
    ]
    assert len(waiting) <= 12, waiting


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_nothing_is_translated_that_is_not_said(extension, locale):
    assert not sorted(set(translations.LANGUAGES[locale]) - wanted())


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_translations_keep_their_places_and_differ(locale):
    def places(text):
        return sorted((name, rule) for _, name, rule, _ in string.Formatter().parse(text) if name)

    for text, translated in translations.LANGUAGES[locale].items():
        assert places(text) == places(translated), text
        assert translated.strip() and (translated != text or text in NAMES), text
        assert text.endswith(".") == translated.endswith(STOPS), text


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_what_is_typed_or_pressed_stays(locale):
    """Numbers, options, keys and kinds of file are the same in every language."""
    tables = {**translations.LANGUAGES[locale], **translations.errors(locale), **translations.STYLES[locale]}
    assert not [(text, kept) for text, told in tables.items() for kept in KEPT.findall(text) if kept not in told]


@pytest.mark.parametrize(("column", "locale"), [(1, "ja_JP"), (2, "zh_HANS")])
def test_terms_are_those_of_the_table(column, locale):
    """Blender's own words and ours, as CONTRIBUTING.md lists them; "key" and "take" are verbs, too, and not asked here."""
    rows = [line.strip("| ").split(" | ") for line in (FOLDER.parent / "CONTRIBUTING.md").read_text("utf-8").splitlines()]
    terms = {row[0].lower(): row[column] for row in rows if len(row) == 3 and not row[2].isascii()}
    asked = {term: terms[term] for term in terms.keys() - {"key", "take", "gesture", "decision (about a take)"}}
    tables = {**translations.LANGUAGES[locale], **translations.errors(locale)}
    said = {text: re.sub(r"--\w+|docs/\S+", "", text).lower() for text in tables}
    uses = [(term, text) for text, plain in said.items() for term in asked if re.search(rf"\b{term}s?\b", plain)]
    assert len(asked) > 20 and len(uses) > 100
    assert not [(term, tables[text]) for term, text in uses if asked[term] not in tables[text]]


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_every_style_has_a_name_that_differs_from_the_others(locale):
    names = {name.capitalize() for name in menu_items.style_names()}
    assert not (missing := lacking(names, "styles", locale)), missing
    table = translations.STYLES[locale]
    assert len({table.get(name, name) for name in names}) == len(names)


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_every_style_is_described_in_the_users_language(locale):
    told = {one["description"] for one in menu_items.speakers_and_controls()["speakers"]}
    assert not (missing := lacking(told, "styles", locale)), missing
    described = {text: theirs for text, theirs in translations.STYLES[locale].items() if text.endswith(".")}
    assert described.keys() <= told
    assert all(theirs.endswith(STOPS) and theirs != text for text, theirs in described.items())


@pytest.mark.parametrize("locale", ["en", *sorted(translations.LANGUAGES)])
def test_labels_beside_settings_are_not_cut(extension, locale):
    """Beside a value there is room for 16 letters where the sidebar is 292 pixels wide, as it is at first; a Chinese or
    Japanese letter takes as much as two others (``ui/test_widths.py`` measures all texts by Blender's font)."""

    def letters(text):
        return sum(1 + (unicodedata.east_asian_width(one) in "WF") for one in text)

    table = translations.LANGUAGES.get(locale, {})
    labels = {prop.name for prop in properties(S2AG_Settings) if prop.name not in ("Bone Map", "Live Preview")}
    labels |= {readiness.label(part) for part in (*bone_map_files.ORDER, *skeleton.EDGE_NAMES) if not part.endswith("twist")}
    assert not [label for label in (table.get(one, one) for one in labels) if letters(label) > 16]


@pytest.mark.parametrize("locale", sorted(translations.LANGUAGES))
def test_notes_on_parts_that_are_not_found_have_a_translation(locale):
    said = {text for path in (FOLDER.parent / "rigs", FOLDER / "rig") for one in path.glob("*.py") for text in notes(one)}
    assert len(said) > 5
    for text in said:
        filled = [text.format(*names) for names in (('Bone "a"', "the arms"), ("the left upper arm", "a"))]
        assert [one for one in filled if translations.translate_sentence(locale, one) != one], text


def notes(path):
    """What is said of a part that is not found, in a file's source."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call):
            values = [word.value for word in node.keywords if word.arg == "note"]
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) in ("note", "search.reasons[part]"):
            values = [node.value]
        elif isinstance(node, ast.FunctionDef) and node.name in ("missing_reason", "_why_not"):
            values = [inner.value for inner in ast.walk(node) if isinstance(inner, ast.Return)]
        else:
            continue
        yield from (text for value in values for text in template(value) if text)


def test_every_word_of_ours_is_looked_up_among_ours(extension):
    """In Blender's own catalogue "Rate" is a price and "Spread" a splash."""
    for cls in registration.CLASSES:
        if issubclass(cls, (bpy.types.Panel, bpy.types.Operator, bpy.types.Menu)):
            assert cls.bl_translation_context == translations.CONTEXT, cls
        for prop in properties(cls):
            assert prop.translation_context == translations.CONTEXT, (cls, prop.identifier)


def test_a_neighbouring_country_reads_its_language():
    """Where Blender follows the system, Austria's locale is no German one of Blender's list."""
    assert [translations._ours(one) for one in ("de_AT", "de", "ja_JP", "zh_HANS")] == ["de_DE", "de_DE", "ja_JP", "zh_HANS"]
    assert [translations._ours(one) for one in ("en_US", "zh_HANT", "zh_TW", "fr_FR", "")] == [""] * 5


def test_the_scan_sees_what_is_there(extension):
    found = wanted()
    assert {"Recording", "Choose Engine", "The engine works", "Cancel", "Generate Gestures"} <= found


def test_descriptions_are_one_line_without_a_full_stop(extension):
    for cls in registration.CLASSES:
        texts = [described(cls)] if issubclass(cls, bpy.types.Operator) else []
        texts += [prop.description for prop in properties(cls)]
        for text in texts:
            assert "\n" not in text and not text.endswith("."), f"{cls.__name__}: {text!r}"


def test_no_text_is_made_of_pieces_that_cannot_be_translated():
    """An f-string has no fixed words to look up: translate() fills names into a whole sentence."""
    wrong = []
    for path, name, node in calls():
        untouched = any(word.arg == "translate" for word in node.keywords)
        parts = [] if untouched else [word.value for word in node.keywords if word.arg in SHOWN]
        if name in REFUSED and len(node.args) > REFUSED[name]:
            text = node.args[REFUSED[name]]
            parts.append(text)
            if literals(text):
                wrong.append(f"{path.name}:{node.lineno} wants translate()")
        if name in TOLD and node.args:
            parts.append(node.args[0])
        if any(isinstance(inner, ast.JoinedStr) for part in parts for inner in ast.walk(part)):
            wrong.append(f"{path.name}:{node.lineno} has an f-string")
    assert not wrong, "\n" + "\n".join(wrong)


def test_blender_takes_the_tables(extension):
    """The wheels of bpy know no languages, so the words come back as they are; in a window it was tried by hand."""
    assert translations.translate("The engine works") == "The engine works"
    assert translations.translate("{path} is open", path="log") == "log is open"
    failed = errors.S2agError("It {broke}.", "Mend it.")
    assert translations.translate_error(failed) == "It {broke}. Mend it."
