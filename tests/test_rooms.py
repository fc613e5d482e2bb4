"""The order of the rooms: each imports only from itself and from rooms below, and no files import each other in a circle."""

from pathlib import Path

from imports import ALL, ROOT, statements

ROOF = ("s2ag_blender.gesture_library", "s2ag_blender.registration")
"""Files that are rooms of their own."""
ORDER = (
    *ROOF,
    *("s2ag_blender.ui", "s2ag_blender.takes", "s2ag_blender.render", "s2ag_blender.keys", "s2ag_blender.characters"),
    *("s2ag_blender.rig", "s2ag_blender.engine", "s2ag_blender.translations", "s2ag_blender"),
    *("core.cli", "core.batch", "core.study", "core.learning", "core.worker", "core.sampling", "core.editing"),
    *("core.synthesis", "core.face", "core.meaning", "core.model", "core.vectors", "core.words", "core.sound"),
    *("rigs", "core.motion", "core"),
)
"""Rooms of all three packages, from the roof to the ground. A package's own name stands for its loose files."""


def room(name):
    """The room of a module by its dotted name; a module may be a room of its own."""
    parts = name.split(".")
    return ".".join(parts[:2]) if ".".join(parts[:2]) in ORDER else parts[0]


def climbs(known):
    """``file:line: what it does`` of every import that goes up."""
    return [
        f"{path}:{line}: {name} imports {imported}"
        for name, path in sorted(known.items())
        for imported, line in statements(name, known=known)
        if imported in known and ORDER.index(room(imported)) < ORDER.index(room(name))
    ]


def circles(known):
    """Groups of files that import each other, each with the lines that make it one."""
    arrows = {name: {to: line for to, line in statements(name, known=known) if to in known and to != name} for name in known}
    while True:  # what imports nothing that is left is in no circle
        free = {name for name, to in arrows.items() if not to.keys() & arrows.keys()}
        if not free:
            break
        arrows = {name: to for name, to in arrows.items() if name not in free}
    return [f"{known[name]}:{line}: {name} -> {to}" for name in arrows for to, line in arrows[name].items() if to in arrows]


def test_every_room_of_the_plan_is_there():
    rooms = {".".join(name.split(".")[:2]) for name, path in ALL.items() if name.count(".") > 1 or path.name == "__init__.py"}
    rooms = {name for name in rooms if not name.startswith("rigs.")} | set(ROOF)
    assert rooms == set(ORDER) == {room(name) for name in ALL}


def test_imports_between_rooms_go_down():
    assert not climbs(ALL)


def test_no_circle_of_files():
    assert not circles(ALL)


def _planted(tmp_path, file, line):
    """All modules, of which one is a copy of ``file`` that begins with an import."""
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.write_text(f"{line}\n{(ROOT / file).read_text('utf-8')}", "utf-8")
    return {**ALL, ".".join(Path(file).with_suffix("").parts): path}


def test_a_planted_climb_is_told_with_file_and_line(tmp_path):
    found = climbs(_planted(tmp_path, "core/sound/audio.py", "from ..synthesis import session"))
    assert found == [f"{tmp_path}/core/sound/audio.py:1: core.sound.audio imports core.synthesis.session"]


def test_a_planted_circle_is_told_with_file_and_line(tmp_path):
    found = circles(_planted(tmp_path, "core/motion/skeleton.py", "from . import rest"))
    assert f"{tmp_path}/core/motion/skeleton.py:1: core.motion.skeleton -> core.motion.rest" in found


def test_rigs_and_blender_keep_apart(tmp_path):
    found = climbs(_planted(tmp_path, "rigs/arms.py", "from ..core.synthesis import session"))
    assert len(found) == 1 and "rigs/arms.py:1" in found[0]
