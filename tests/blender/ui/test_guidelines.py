"""What Blender's human interface guidelines ask of operators, properties, panels and menus, item by item.

Title case is that of the Modern Language Association, as Blender's is; texts are American English, as Blender's are.
"""

import ast
import json
import re

import bpy
import pytest
from acted import Sheet, press
from s2ag.s2ag_blender import registration
from translated_texts import FOLDER, literals

LOWER = {
    "a", "an", "the", "and", "but", "for", "or", "nor", "so", "yet", "as", "at", "by", "from", "in", "into", "of", "off", "on",
    "onto", "out", "over", "per", "to", "up", "via", "with", "without",
}  # fmt: skip
"""Words that title case writes small, but for the first and the last."""
ACRONYMS = {"BVH", "FBX", "GLB", "S2AG", "NLA", "PyTorch", "L", "R"}
BRITISH = re.compile(
    r"\w*(?:cognis|organis|normalis|initialis|synchronis|[^r]colour|behaviour|centre|grey|neighbour|favourite|labelled)\w*",
    re.IGNORECASE,
)
SWITCHING = re.compile(r"(?:enable|disable|toggle|whether|activate|turns? (?:on|off))\b", re.IGNORECASE)
UNDONE = {"REGISTER", "UNDO"}
NOT_UNDONE = {
    "cancel": "ends a run before it has changed anything",
    "export": "writes a file",
    "save_bone_map": "writes a file",
    "save_face_map": "writes a file",
    "learn": "writes files",
    "preset_add": "writes a preset",
    "add_at_word": "asks for a word, then presses Add Gesture, which is undone",
    "show_markers": "changes an editor",
    "show_panel": "changes an editor",
    "open_log": "changes an editor",
    "open_help": "changes an editor",
    "engine_choose": "changes preferences",
    "engine_check": "changes no file",
    "engine_cancel": "changes no file",
    "engine_leave": "changes preferences",
}
"""Operators that change nothing of the file, with what they do instead."""
PLAIN_NUMBERS = {"size"}
"""Numbers without a unit and without an end: how many times as large."""


@pytest.fixture(autouse=True)
def registered(extension):
    """The classes are there."""


def kind(base):
    return [cls for cls in registration.CLASSES if issubclass(cls, base)]


def verb(cls):
    return cls.bl_idname.partition(".")[2]


def rna(cls):
    return getattr(bpy.ops.s2ag, verb(cls)).get_rna_type() if issubclass(cls, bpy.types.Operator) else cls.bl_rna


def own(cls):
    """The properties of a class that a user sees, of ours."""
    names = {
        name for base in cls.__mro__ if base.__module__.startswith("s2ag.") for name in getattr(base, "__annotations__", {})
    }
    return [one for one in rna(cls).properties if one.identifier in names and not one.is_hidden]


def everything():
    """``(where, name, description)`` of every operator, property and item that somebody sees."""
    for cls in registration.CLASSES:
        if issubclass(cls, bpy.types.Operator):
            yield cls.__name__, rna(cls).name, rna(cls).description
        for one in own(cls):
            where = f"{cls.__name__}.{one.identifier}"
            yield where, one.name, one.description
            for item in one.enum_items if one.type == "ENUM" else ():
                yield f"{where}.{item.identifier}", item.name, item.description


def titled(name):
    """The name in title case."""
    words = name.split(" ")
    last = len(words) - 1

    def of(place, word):
        if word in ACRONYMS:
            return word
        parts = word.split("-")
        small = word.lower() in LOWER and place not in (0, last)
        return word.lower() if small else "-".join(part[:1].upper() + part[1:] for part in parts)

    return " ".join(of(*one) for one in enumerate(words))


def test_titles():
    panels = [(cls.__name__, cls.bl_label, "") for cls in (*kind(bpy.types.Panel), *kind(bpy.types.Menu))]
    names = [(where, name) for where, name, _ in (*everything(), *panels)]
    assert not [(where, name, titled(name)) for where, name in names if name != titled(name)]
    assert not [one for one in names if not one[1] or one[1][-1] in ".:!?…" or (one[1].isupper() and one[1] not in ACRONYMS)]


def test_tooltips():
    told = [(where, name, text) for where, name, text in everything() if text]
    assert not [one for one in told if not re.match(r"[A-Z0-9-]", one[2]) or one[2][-1] in ".:!…" or "  " in one[2]]
    assert not [one for one in told if one[1] == one[2] or SWITCHING.match(one[2]) or SWITCHING.match(one[1])]


def test_every_property_and_operator_has_a_tooltip():
    items = {f"{cls.__name__}.{one.identifier}." for cls in registration.CLASSES for one in own(cls)}
    assert not [one for one in everything() if not one[2] and not any(one[0].startswith(head) for head in items)]


def test_american_english():
    """Of the interface; what is told of errors is the command line's, too, and has its English."""
    texts = json.loads((FOLDER / "translations" / "de_DE.json").read_text("utf-8"))
    assert len(texts) > 500 and not [text for text in texts if BRITISH.search(re.sub(r"\[[a-z,]+\]", "", text))]


def test_names_of_classes():
    for base, mark in ((bpy.types.Operator, "OT"), (bpy.types.Panel, "PT"), (bpy.types.Menu, "MT"), (bpy.types.UIList, "UL")):
        for cls in kind(base):
            name = f"S2AG_{mark}_{verb(cls)}" if mark == "OT" else getattr(cls, "bl_idname", cls.__name__)
            assert re.fullmatch(rf"S2AG_{mark}_[a-z0-9_]+", cls.__name__) and name == cls.__name__, cls


def test_what_changes_the_file_is_undone():
    operators = {verb(cls): set(getattr(cls, "bl_options", {"REGISTER"})) for cls in kind(bpy.types.Operator)}
    assert {name for name, options in operators.items() if not options >= UNDONE} == NOT_UNDONE.keys() & operators.keys()
    assert operators.keys() >= NOT_UNDONE.keys()


def test_numbers_say_what_they_count():
    numbers = [one for cls in registration.CLASSES for one in own(cls) if one.type == "FLOAT"]
    assert not [one.identifier for one in numbers if one.subtype == "NONE" and one.identifier not in PLAIN_NUMBERS]
    whole = [one for cls in registration.CLASSES for one in own(cls) if one.type == "INT"]
    assert not [one.identifier for one in whole if "rame" in one.description.split(";")[0] and one.subtype != "TIME"]


def test_paths_open_a_browser():
    texts = [one for cls in registration.CLASSES for one in own(cls) if one.type == "STRING"]
    paths = {one.identifier: one.subtype for one in texts if re.search(r"file|folder|path|dir", one.identifier, re.IGNORECASE)}
    assert paths and all(kind in ("FILE_PATH", "DIR_PATH") for kind in paths.values()), paths


def test_panels_are_at_home():
    panels = [cls for cls in kind(bpy.types.Panel) if getattr(cls, "bl_category", None)]
    assert {cls.bl_category for cls in panels} == {"Gestures"}
    titles = [(getattr(cls, "bl_parent_id", ""), cls.bl_label) for cls in panels]
    assert len(set(titles)) == len(titles)
    assert [cls.__name__ for cls in panels if not hasattr(cls, "bl_parent_id")] == ["S2AG_PT_gestures"]


class Labels(Sheet):
    """A sheet that notes the labels of settings and buttons."""

    def __init__(self, drawn=None, above=(), labels=None):
        super().__init__(drawn, above)
        self.labels = [] if labels is None else labels

    def column(self, **_):
        return Labels(self.drawn, (*self.above, self), self.labels)

    row = box = split = column

    def prop(self, settings, name, text=None, **about):
        super().prop(settings, name, text, **about)
        self.labels.append(settings.bl_rna.properties[name].name if text is None else text)

    def operator(self, name, text=None, **about):
        options = super().operator(name, **about)
        group, _, word = name.partition(".")
        self.labels.append(getattr(getattr(bpy.ops, group), word).get_rna_type().name if text is None else text)
        return options

    def operator_menu_enum(self, name, prop, text=None, **_):
        return self.operator(name, text)

    def template_list(self, *_, **__):
        """Rows of lists repeat."""


def doubled():
    """Labels that stand twice in one panel."""
    found = {}
    for cls in kind(bpy.types.Panel):
        if hasattr(cls, "draw") and cls.__name__ != "S2AG_PT_presets" and (not hasattr(cls, "poll") or cls.poll(bpy.context)):
            sheet = Labels()
            stand_in = type("Stand", (), {"layout": sheet, "draw_settings": getattr(cls, "draw_settings", None)})()
            cls.draw(stand_in, bpy.context)
            labels = [label for label in sheet.labels if label]
            found[cls.__name__] = sorted({label for label in labels if labels.count(label) > 1})
    return {name: labels for name, labels in found.items() if labels}


@pytest.mark.parametrize("voice_from", ["FILE", "STRIP", "MIXDOWN"])
def test_no_label_twice_in_a_panel(speaker, voice_from):
    speaker.s2ag.audio_source, speaker.s2ag.add_markers = voice_from, True
    for words_from in ("FILE", "BLOCK", "TYPED", "RECOGNISE"):
        speaker.s2ag.transcript_source = words_from
        assert not doubled()


def test_no_label_twice_with_a_take(speaker, examples):
    speaker.s2ag.audio = str(examples / "hello.flac")
    press(bpy.ops.s2ag.generate)
    assert not doubled()


def test_icons_are_blenders():
    known = set(bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys())
    used = set()
    for path in (FOLDER / "ui").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "icon":
                used |= set(literals(node.value))
    assert len(used) > 20 and used <= known, used - known
