"""Manages the versions of a take, one for each edit, each an action of its own."""

from collections.abc import Sequence
from typing import Any

import bpy

from ..datablocks import ArmatureObject
from . import take_list


def add_version(
    armature: ArmatureObject, former: bpy.types.Action, action: bpy.types.Action, warnings: Sequence[str] = (), title: str = ""
) -> bool:
    """Add ``action`` as the newest version of the take that plays ``former``, with a ``title`` that says what is new; return
    False if no take plays that."""
    settings = armature.s2ag
    number = next((number for number, take in enumerate(settings.takes) if take.action == former), None)
    if number is None:
        return False
    take = settings.takes[number]
    if not len(take.versions):
        _add(take, former, take.warnings)
    _add(take, action, "\n".join(warnings), title)
    _play(armature, number, len(take.versions) - 1)
    return True


def version_position(take: Any) -> tuple[int, int]:
    """Return (number of the version that a take plays, from 1, count of versions); (1, 1) for one that was never edited."""
    at = next((number for number, one in enumerate(take.versions, 1) if one.action == take.action), 1)
    return at, max(len(take.versions), 1)


def version_title(take: Any) -> str:
    """Return what the version that a take plays did; "" for the first one."""
    return next((one.title for one in take.versions if one.action == take.action), "")


def flip(armature: ArmatureObject, by: int) -> None:
    """Play the version of the selected take that is ``by`` further on, cyclically."""
    take = take_list.active(armature)
    count = len(take.versions)
    at = version_position(take)[0] - 1
    for step in range(1, count):
        version = (at + by * step) % count
        if take.versions[version].action is not None:
            _play(armature, armature.s2ag.active_take, version)
            return


def drop_others(armature: ArmatureObject) -> int:
    """Delete all versions of the selected take except the one that it plays; return their number."""
    take = take_list.active(armature)
    others = [one.action for one in take.versions if one.action not in (None, take.action)]
    take.versions.clear()
    for action in others:
        take_list.discard(armature, action)
    return len(others)


def version_actions(take: Any) -> list[bpy.types.Action]:
    """Return all existing actions of a take."""
    candidates = [take.action, *(one.action for one in take.versions)]
    return list(dict.fromkeys(action for action in candidates if action is not None))


def _add(take: Any, action: bpy.types.Action, warnings: str, title: str = "") -> None:
    one = take.versions.add()
    one.name, one.action, one.warnings, one.title = str(len(take.versions)), action, warnings, title


def _play(armature: ArmatureObject, number: int, version: int) -> None:
    settings = armature.s2ag
    take, one = settings.takes[number], settings.takes[number].versions[version]
    take.action, take.warnings = one.action, one.warnings
    take_list.note_frames(take)
    take_list.rename(armature, take)
    settings.active_take = number  # shows it
