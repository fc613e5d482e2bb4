"""What a take was and became under its edits: versions to flip through in place, each an action of its own."""

from typing import Any

import bpy

from .. import provenance
from ..datablocks import ArmatureObject
from . import takes


def put(armature: ArmatureObject, former: bpy.types.Action, action: bpy.types.Action, warnings=()) -> bool:
    """Let the take that plays ``former`` play ``action``, its newest version; False where no take plays that (any more)."""
    settings = armature.s2ag
    number = next((number for number, take in enumerate(settings.takes) if take.action == former), None)
    if number is None:
        return False
    take = settings.takes[number]
    if not len(take.versions):
        _add(take, former, take.warnings)
    _add(take, action, "\n".join(warnings))
    _play(armature, number, len(take.versions) - 1)
    return True


def place(take: Any) -> tuple[int, int]:
    """Which of how many versions a take plays, from one on; (1, 1) for one that was never directed."""
    at = next((number for number, one in enumerate(take.versions, 1) if one.action == take.action), 1)
    return at, max(len(take.versions), 1)


def flip(armature: ArmatureObject, by: int) -> None:
    """Let the selected take play the version that is ``by`` further on, the first one after the last; nothing is made."""
    take = takes.active(armature)
    count = len(take.versions)
    at = place(take)[0] - 1
    for step in range(1, count):
        other = (at + by * step) % count
        if take.versions[other].action is not None:
            _play(armature, armature.s2ag.active_take, other)
            return


def drop_others(armature: ArmatureObject) -> int:
    """Delete all versions of the selected take but the one that it plays; returns how many."""
    take = takes.active(armature)
    others = [one.action for one in take.versions if one.action not in (None, take.action)]
    take.versions.clear()
    for action in others:
        takes.discard(armature, action)
    return len(others)


def actions(take: Any) -> list[bpy.types.Action]:
    """All actions of a take that are there."""
    found = [take.action, *(one.action for one in take.versions)]
    return list(dict.fromkeys(action for action in found if action is not None))


def edits(take: Any) -> list[list[dict]]:
    """What each version of a take came of."""
    return [list((provenance.of(action) or {}).get("edits", [])) for action in actions(take)]


def _add(take: Any, action: bpy.types.Action, warnings: str) -> None:
    one = take.versions.add()
    one.name, one.action, one.warnings = str(len(take.versions)), action, warnings


def _play(armature: ArmatureObject, number: int, version: int) -> None:
    settings = armature.s2ag
    take, one = settings.takes[number], settings.takes[number].versions[version]
    take.action, take.warnings = one.action, one.warnings
    takes.located(take)
    takes.rename(armature, take)
    settings.active_take = number  # shows it
