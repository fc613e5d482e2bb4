"""Every setting is declared in one place, :mod:`s2ag.core.settings`, and named in few others; what is made of it is as ever.

How files are counted: in the syntax trees of core, rigs and s2ag_blender (without core/learning and core/study, which train and
measure). A file names a setting where it has

- an attribute of that name on something that holds settings: an expression whose last word is one of :data:`HOLDERS`
  (``self.request.hands``, ``options.hands``, ``armature.s2ag.hands``), or ``self`` in a class of :data:`CLASSES`;
- a string constant that is the name, anywhere but in docstrings, unless it is a key of :data:`DOCUMENTS` or of a dictionary
  that is written as JSON at once, a kind or a group;
- a keyword of that name in a call of :data:`CALLS`, all of which make or change settings;
- an annotated field of that name in a class of :data:`CLASSES`.

The same word for something else is not counted: the ``hands`` of a motion, the ``turn`` of a pelvis, the ``rate`` of a sound
file. Attributes and keywords are told apart by what they belong to, keys by the mapping. What is left is read:
:data:`ELSEWHERE` lists files in which the word is always something else, and folders in which the string is; in these,
attributes and keywords count. Who reads a setting without naming it (``request.identities`` for the number of takes,
``checkpoint_of(options)``, ``names_with(words=True)``) is not counted: that is what keeps a name in few files.
"""

import ast
from functools import cache
from pathlib import Path

import pytest
from s2ag.core.declaration import sliders, table
from s2ag.core.settings import CURVES, Affects, Documents, Models, Settings, names_with

ROOT = Path(__file__).resolve().parents[1]
MOST = 5
"""Files that may name a setting."""
HOLDERS = {"request", "settings", "options", "params", "wanted", "clip", "s2ag", "sheet", "cell", "kept", "unit"}
CLASSES = {"Request", "Clip", "Sheet", "Cell", "Settings", "Models", "Documents", "Affects", "Session", "S2AG_Settings"}
CALLS = {"Request", "Session", "Clip", "Cell", "add_options", "dict", "plan", "remake_arguments", "request"}
DOCUMENTS = {"meta", "edit", "edits", "content", "facts", "found", "result", "segment", "best", "data"}
DOCUMENTS |= {"read", "require", "origin", "_KINDS"}
"""Mappings that are no settings: provenance, edits, facts of an engine, its replies, transcripts of other tools."""
BLENDERS = {"takes", "curves", "end_pose"}
"""Properties of the panel that share only the name: the list of a character's takes, whether every frame or only poses are
keyed, and how a take ends (a choice).
"""
_EDITS = "core/editing/edits.py", "core/editing/edit_actions.py", "core/editing/targets.py"  # kinds of edits
_DECISIONS = "s2ag_blender/takes/decisions.py", "s2ag_blender/ui/decisions.py"  # words and fields of edits
_STATED = ("core/synthesis/postprocess.py",)  # keys of provenance
ELSEWHERE: dict[str, tuple[str, ...]] = {
    "hand": (  # of a gesture or an edit; a bone or its part of a rig
        *("core/cli/meaning.py", "core/meaning/"),
        *("core/editing/", "core/motion/stroke_requests.py", "rigs/", "s2ag_blender/characters/", "s2ag_blender/rig/"),
        "s2ag_blender/render/sheet.py",
        *("s2ag_blender/takes/constraints.py", "s2ag_blender/ui/directing.py", "s2ag_blender/ui/gesture_panel.py", *_DECISIONS),
    ),
    "hands": ("s2ag_blender/keys/", "s2ag_blender/rig/"),  # which bones are keyed
    "face": (  # arrays of a motion's face, a part of a character, a group of rows
        *("core/cli/rig.py", "core/motion/", "s2ag_blender/characters/", "s2ag_blender/ui/subpanels.py"),
    ),
    "affect": ("core/model/",),  # a part of imported networks
    "meanings": ("core/meaning/sentence.py", "core/model/"),  # a folder, a part of a network
    "meaning": ("core/motion/stroke_requests.py",),  # a channel
    "rate": ("core/motion/",),  # frames a second
    "turn": ("core/meaning/",),  # of a palm
    "listen": ("s2ag_blender/takes/stages.py",),  # a stage of the engine
    "spread": ("core/motion/", "core/synthesis/accent_selection.py", "core/sampling/", "rigs/"),  # of fingers, chances
    "rhubarb": ("core/motion/",),  # a format
    "language": ("core/words/",),  # what a recogniser takes
    "vectors": ("core/cli/data.py",),  # what is made of them
    "vocabulary": ("core/cli/checkpoint.py", "core/model/"),  # words of an imported network
    "device": ("core/cli/", "s2ag_blender/"),  # of training, of Blender's renderer
    "curves": ("s2ag_blender/keys/", "s2ag_blender/ui/subpanels.py"),  # BLENDERS
    "end_pose": ("s2ag_blender/",),
    "takes": ("s2ag_blender/takes/stored_settings.py", "s2ag_blender/ui/subpanels.py", "s2ag_blender/ui/__init__.py"),
    "kept": ("s2ag_blender/takes/take_list.py",),  # an argument of plan, the settings of a take
    "pose": (*_EDITS[:2], "s2ag_blender/takes/constraints.py", "s2ag_blender/takes/decisions.py"),
    "style": (  # a kind of edit, a column, a point of a map, the field of an operator
        *(*_EDITS, "core/batch/manifest.py", "core/declaration.py", *_STATED, "s2ag_blender/takes/decisions.py"),
        *("s2ag_blender/ui/from_here.py", "s2ag_blender/ui/gesture_panel.py", "s2ag_blender/ui/menus.py"),
        "s2ag_blender/ui/subpanels.py",
    ),
    "seed": (  # of an edit, of the program that places words, of a study
        *("core/editing/edits.py", "core/words/aligner/sphinx_engine.py", "core/cli/study.py"),
        *("s2ag_blender/takes/gesture_edits.py", "s2ag_blender/ui/decisions.py"),
    ),
    "take": (  # a motion file, a word, a gesture, and the number in a record or in provenance
        *("core/cli/edit.py", "core/batch/summary.py", *_STATED),
    ),
    "near": _STATED,
    "chance": ("core/synthesis/style_sequence.py",),  # a fact of a speaker
    "transcript": _STATED,  # a digest
    "text": (  # a kind of setting, a key of other programs' files, an argument of Blender's
        *("core/batch/manifest.py", "core/declaration.py", "core/words/readers/", "s2ag_blender/ui/setting_properties.py"),
    ),
    "recognise": ("core/words/transcript.py",),  # a name in the cache
    "checkpoint": (  # a command, a check's name, a hash in a sheet
        *("core/cli/parser.py", "core/cli/machine_checks.py", "core/sampling/", "core/worker/inventory.py", *_STATED),
    ),
    "edits": (  # the worker's own parameter, a list of edits, not the path of a document
        *("core/worker/server.py", "s2ag_blender/takes/generate.py", "s2ag_blender/takes/gesture_edits.py"),
    ),
    "step": ("s2ag_blender/ui/setting_properties.py",),  # of a slider's arrows
}
"""Setting -> files in which the word, or folders in which the same string, is something else."""


@cache
def _trees():
    """Every file in question with its syntax tree."""
    trees = []
    for path in sorted(path for package in ("core", "rigs", "s2ag_blender") for path in (ROOT / package).rglob("*.py")):
        place = path.relative_to(ROOT).as_posix()
        if not place.startswith(("core/learning", "core/study")):
            trees.append((place, ast.parse(path.read_text("utf-8"))))
    return trees


def _last(node):
    """The last word of an expression: ``request`` of ``self.request``."""
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def _receivers(node):
    """Last words of what a key is looked up in: ``meta`` of ``motion.meta``, ``read`` of ``(read(action) or {})``."""
    if isinstance(node, ast.BoolOp):
        return set().union(*map(_receivers, node.values))
    return {_last(node.func if isinstance(node, ast.Call) else node)}


def _of_documents(tree):
    """Identities of string constants that structure tells to be something else: keys of documents, kinds and groups."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Subscript) and _receivers(node.value) & DOCUMENTS:
            yield id(node.slice)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in ("get", "pop"):
            if node.args and _receivers(node.func.value) & DOCUMENTS:
                yield id(node.args[0])
        elif isinstance(node, ast.Compare):
            yield from _of_comparison(node.left, node.ops[0], node.comparators[0])
        elif isinstance(node, ast.Assign | ast.AugAssign) and isinstance(node.value, ast.Dict):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if _last(target) in DOCUMENTS:
                yield from map(id, node.value.keys)
        elif isinstance(node, ast.keyword) and node.arg in ("kind", "group"):
            yield id(node.value)
        elif isinstance(node, ast.Call) and _last(node.func) == "dumps" and isinstance(node.args[0], ast.Dict):
            yield from map(id, node.args[0].keys)


def _of_comparison(left, how, right):
    if isinstance(how, ast.In | ast.NotIn) and _receivers(right) & DOCUMENTS:
        yield id(left)
    elif isinstance(left, ast.Subscript) and _receivers(left.value) & DOCUMENTS or _last(left) == "kind":
        yield from map(id, ast.walk(right))
    elif isinstance(left, ast.Call) and isinstance(left.func, ast.Attribute) and _receivers(left.func.value) & DOCUMENTS:
        yield from map(id, ast.walk(right))  # content.keys() <= {...}


def _names(tree, blender=False):
    """Words of a syntax tree that would name settings, by the rules of this file: as names, and as strings."""
    texts = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)} | set(_of_documents(tree))
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef) and node.name in CLASSES]
    own = {id(inner) for node in classes for inner in ast.walk(node)}
    named, strings = set(), set()
    for node in ast.walk(tree):
        holders = HOLDERS | {"self"} if id(node) in own else HOLDERS
        if isinstance(node, ast.Attribute) and _last(node.value) in holders:
            if not (blender and node.attr in BLENDERS and _last(node.value) in ("settings", "s2ag", "kept")):
                named.add(node.attr)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in texts:
            strings.add(node.value)
        elif isinstance(node, ast.Call) and (_last(node.func) in CALLS or _replaces(node)):
            named |= {word.arg for word in node.keywords}
        elif isinstance(node, ast.AnnAssign) and id(node) in own and not (blender and _last(node.target) in BLENDERS):
            named.add(_last(node.target))
    return named, strings


def _replaces(call):
    """Whether a call is ``replace(request, ...)``, of something that holds settings."""
    return _last(call.func) == "replace" and bool(call.args) and _last(call.args[0]) in HOLDERS


def naming():
    """Files that name each setting."""
    found = {name: set() for cls in (Settings, Affects, Models, Documents) for name in table(cls)}
    for place, tree in _trees():
        named, strings = _names(tree, place.startswith("s2ag_blender/"))
        for name, files in found.items():
            others = ELSEWHERE.get(name, ())
            if place not in others and (name in named or (name in strings and not place.startswith(others or "nowhere"))):
                files.add(place)
    return found


def test_a_setting_is_named_in_five_files_at_most():
    found = naming()
    over = {name: sorted(files) for name, files in found.items() if len(files) > MOST}
    assert not over, "\n".join(f"{name}: {len(files)} files: {', '.join(files)}" for name, files in over.items())


def test_what_is_not_counted_is_there():
    """Every entry of :data:`ELSEWHERE` is about a word in a file, or in some file of a folder, that would count otherwise."""
    words = {place: set().union(*_names(tree, place.startswith("s2ag_blender/"))) for place, tree in _trees()}
    stale = [
        (name, where)
        for name, places in ELSEWHERE.items()
        for where in places
        if not any(name in every for place, every in words.items() if place.startswith(where))
    ]
    assert not stale


def test_every_setting_is_declared_in_the_table_alone():
    """No other class has a field of the name of a slider, so that its range and texts stand once."""
    named_once = {one.name for one in sliders(Settings)} - BLENDERS - {"style", "seed"}  # a cell has its own
    for place, tree in _trees():
        fields = {
            _last(inner.target)
            for node in ast.walk(tree)
            if isinstance(node, ast.ClassDef) and node.name in CLASSES
            for inner in node.body
            if isinstance(inner, ast.AnnAssign)
        }
        assert place == "core/settings.py" or not fields & named_once, place


def test_declarations_make_sense():
    for cls in (Settings, Affects, Models, Documents):
        for name, one in table(cls).items():
            assert one.kind, name
            assert bool(one.label) == bool(one.tip), name
            assert one.low is None or one.high is None or one.parts or one.low <= one.default <= one.high, name
            assert not one.tip.endswith(".") and not one.help.endswith("."), name


@pytest.mark.parametrize("locale", sorted(path.stem for path in (ROOT / "s2ag_blender" / "translations").glob("*.json")))
def test_labels_tips_and_errors_are_translated(locale):
    import json

    tables = ROOT / "s2ag_blender" / "translations"
    words, errors = (json.loads((folder / f"{locale}.json").read_text("utf-8")) for folder in (tables, tables / "errors"))
    for one in sliders(Settings) + sliders(Models):
        assert {one.label, one.tip, one.short} - {""} <= words.keys(), one.name
    for one in [*table(Settings).values()]:
        assert {one.wrong, one.remedy, *one.conflict} - {""} <= errors.keys(), one.name
    assert {"{} {} is out of range.", "Give a number from {} to {}."} <= errors.keys()


# What users' scripts, manifests and files rely on. More may be added; nothing may go.
OPTIONS = """audio chosen transcript text recognise no_transcript style seed takes intensity affect rate hand curves meaning
hands stance face rhubarb face_smoothness mirror listen turn hears later toward checkpoint vectors language aligner_model
vocabulary recogniser_model backend device cache"""
PARAMETERS = """audio transcript text style seed takes intensity affect rate hand curves changes meaning hands stance face
face_smoothness mirror pose end_pose kept take near spread step recognise listen turn hears later toward made_by"""
MODELS = "checkpoint vectors backend device aligner_model recogniser_model cache language vocabulary"
COLUMNS = """name audio transcript text recognise no_transcript style seed take takes intensity affect rate hand meaning hands
stance face face_smoothness mirror cell latent listen turn hears later toward rhubarb edits curves checkpoint vectors
aligner_model recogniser_model language vocabulary backend device outputs character gender armature map face_map scene delay
preset engine resolution fps start_frame"""


def test_options_are_as_ever():
    import argparse

    from s2ag.core.cli import synthesis_options

    parser = argparse.ArgumentParser()
    synthesis_options.add_options(parser)
    listed, ever = [action.dest for action in parser._actions], OPTIONS.split()
    assert [name for name in listed if name in ever] == ever
    options = parser.parse_args(["a.wav", "--face", "--hand", "left", "--affect", "arousal=0.5,valence=1", "--no-transcript"])
    wanted = synthesis_options.request(options)
    assert (wanted.face, wanted.hand, wanted.affect) == (1.0, -1.0, {"arousal": 0.5, "valence": 1.0})
    assert (wanted.hands, wanted.stance, options.device) == (1.0, 1.0, "cpu")


def test_parameters_of_the_worker_are_as_ever():
    from s2ag.core.worker import server

    assert server._PARAMETERS.keys() >= set(PARAMETERS.split()) and set(server._MODELS) >= set(MODELS.split())
    assert server._PARAMETERS["style"] == (str, dict) and server._PARAMETERS["stance"] == (int, float)
    assert server._PARAMETERS["kept"] is list and server._PARAMETERS["mirror"] is bool and server._PARAMETERS["step"] is int


def test_columns_of_manifests_are_as_ever():
    from dataclasses import fields

    from s2ag.core.batch import clip, manifest

    assert set(manifest.COLUMNS) >= set(COLUMNS.split())
    assert {one.name for one in fields(clip.Clip)} == set(manifest.COLUMNS) - {"cell"} | {"line"}
    row = clip.Clip(1, "a", "a.wav")
    assert (row.hands, row.stance, row.face, row.curves, row.device) == (1.0, None, 0.0, None, "cpu")


def test_a_session_takes_every_model():
    import inspect

    from s2ag.core.synthesis.session import Session

    taken = inspect.signature(Session).parameters
    assert taken.keys() - {"remember"} == table(Models).keys()
    assert all(taken[name].default == one.default for name, one in table(Models).items())


def test_provenance_cells_and_curves_are_as_ever():
    always = "seed intensity affect rate hand meaning hands stance mirror"
    assert set(names_with(meta="always")) >= set(always.split())
    assert set(names_with(meta="set")) >= {"curves", "changes", "listen", "turn", "later", "toward", "face"}
    shared = {"transcript", "text", "recognise", "intensity", "hand", "meaning", "mirror"}
    assert set(names_with(cell="sheet")) >= shared
    assert CURVES[:6] == ("intensity", "arousal", "valence", "dominance", "rate", "hand")
