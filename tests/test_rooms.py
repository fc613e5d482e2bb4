"""The order of the rooms: each stands only on those below it, and no files import each other in a circle."""

import shutil

from imports import ALL, PACKAGES, ROOT, modules, statements

DOORS = "doors"
CORE = (
    *(DOORS, "cli", "batch", "study", "learning", "engine", "setup", "direction", "performance", "face"),
    *("meaning", "model", "vectors", "words", "sound", "motion", ""),
)
BLENDER = (DOORS, "ui", "takes", "film", "keys", "cast", "rig", "engine", "")
"""From the roof to the ground; "" are the loose files, on which everything may stand."""
ROOMS = {"core": CORE, "rigs": ("",), "s2ag_blender": BLENDER}
ROOF = {"core.synthesis", "s2ag_blender.apply", "s2ag_blender.generate", "s2ag_blender.registration"}
"""Loose files that hand on to the rooms: old names of what scripts use, and the list of what is registered."""
PACKAGE_ORDER = {"s2ag_blender": {"rigs", "core"}, "rigs": {"core"}, "core": {"rigs"}}
"""``core`` reads bone maps and writes BVH by ``rigs``, which knows of it only what a motion is, errors, files and JSON."""
_MOTION = ("skeleton", "hands", "handshape", "pelvis", "face")
GROUND_FOR_RIGS = ("core.errors", "core.files", "core.json_text", *(f"core.motion.{name}" for name in _MOTION))


def room(name):
    """Package, and room in it, of a module by its dotted name."""
    package, _, rest = name.partition(".")
    first = rest.split(".")[0]
    return package, DOORS if name in ROOF else first if first in ROOMS[package] else ""


def climbs(known):
    """``file:line: what it does`` of every import that goes up."""
    found = []
    for name, path in sorted(known.items()):
        here, mine = room(name)
        for imported, line in statements(name, known=known):
            package, theirs = room(imported) if imported.split(".")[0] in ROOMS and imported in known else (None, None)
            if package == here:
                wrong = ROOMS[here].index(theirs) < ROOMS[here].index(mine)
            else:
                wrong = package is not None and package not in PACKAGE_ORDER[here]
                wrong = wrong or (here == "rigs" and package == "core" and imported not in GROUND_FOR_RIGS)
            if wrong:
                found.append(f"{path}:{line}: {name} imports {imported}")
    return found


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
    there = {room(name) for name in ALL}
    assert there == {(package, one) for package, rooms in ROOMS.items() for one in rooms}


def test_imports_between_rooms_go_down():
    assert not climbs(ALL)


def test_no_circle_of_files():
    assert not circles(ALL)


def _planted(tmp_path, file, line):
    """A copy of the tree in which ``file`` begins with an import; its modules."""
    for package in PACKAGES:
        shutil.copytree(
            ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("*.safetensors", "*.npz", "__pycache__")
        )
    path = tmp_path / file
    path.write_text(f"{line}\n{path.read_text('utf-8')}", "utf-8")
    return modules(*PACKAGES, root=tmp_path)


def test_a_planted_climb_is_told_with_file_and_line(tmp_path):
    found = climbs(_planted(tmp_path, "core/sound/audio.py", "from ..performance import synthesis"))
    assert found == [f"{tmp_path}/core/sound/audio.py:1: core.sound.audio imports core.performance.synthesis"]


def test_a_planted_circle_is_told_with_file_and_line(tmp_path):
    found = circles(_planted(tmp_path, "core/motion/skeleton.py", "from . import rest"))
    assert f"{tmp_path}/core/motion/skeleton.py:1: core.motion.skeleton -> core.motion.rest" in found


def test_rigs_and_blender_keep_apart(tmp_path):
    found = climbs(_planted(tmp_path, "rigs/arms.py", "from ..core.performance import synthesis"))
    assert len(found) == 1 and "rigs/arms.py:1" in found[0]
