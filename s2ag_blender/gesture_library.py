"""Builds a .blend file of gestures as assets: ``python -m s2ag.s2ag_blender.gesture_library JOB.json``.

The job is JSON of :mod:`s2ag.core.cli.gestures`: ``output``, ``kinds``, a list or None for all, and ``idles``, seconds of each
idle. Beside the file lies the text that Blender reads the names of catalogues from."""

import sys
from pathlib import Path
from typing import Any

import bpy

from ..core import json_text
from ..core.errors import UsageError
from ..core.files import atomic_file
from ..core.synthesis import idling
from . import program, registration
from .datablocks import ArmatureObject
from .takes import engine_requests, gesture_assets
from .ui import gesture_assets as operators

ABOUT = {"author": "S2AG for Blender", "license": "CC0 1.0", "copyright": ""}
IDLES = "S2AG/Idles"
STYLES = ("warm host", "calm lecturer", "shy student", "eager storyteller")
"""Styles that the idles wait in, one after the other."""


def main(arguments: list[str]) -> int:
    """Run the job file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(json_text.read(path), voice), "job of a library")


def perform(asked: dict, voice: program.EventWriter) -> dict:
    """Do the job in this Blender; return the ``result`` event's content: names of the assets."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    registration.register()
    try:
        known = [name for name, *_ in operators._shown_kinds()]
        chosen = known if asked["kinds"] is None else asked["kinds"]
        unknown = sorted(set(chosen) - set(known))
        if unknown:
            raise UsageError(f"There is no kind of gesture called {unknown[0]}.", f"Kinds are {', '.join(sorted(known))}.")
        armature, made = engine_requests.add_character("mannequin"), []
        for number, kind in enumerate(chosen):
            made.append(_kind(armature, kind))
            voice.progress("gestures", number / len(chosen))
        for number, seconds in enumerate(asked["idles"]):
            made.append(_idle(armature, number, seconds))
            voice.progress("idles", number / len(asked["idles"]))
        _write(Path(asked["output"]), made)
        return {"assets": [action.name for action in made]}
    finally:
        registration.unregister()


def _kind(armature: ArmatureObject, kind: str) -> bpy.types.Action:
    before = set(gesture_assets.assets())
    call: Any = bpy.ops
    call.s2ag.save_gesture(what="KIND", kind=kind, author=ABOUT["author"], license=ABOUT["license"])
    (action,) = set(gesture_assets.assets()) - before
    return action


def _idle(armature: ArmatureObject, number: int, seconds: float) -> bpy.types.Action:
    style, stillness = STYLES[number % len(STYLES)], (0.2, 0.5, 0.8)[number % 3]
    motion = idling.idle(seconds, style, number, stillness, loop=True, fps=24)
    told = f"A loop of {seconds:g} seconds of somebody who waits, stillness {stillness}"
    facts = {"kind": "idle", "side": "both", "performer": style}
    return gesture_assets.save(armature, motion, f"Idle {number + 1}", IDLES, facts, description=told, **ABOUT)


def _write(path: Path, actions: list[bpy.types.Action]) -> None:
    """Write the actions alone, with what they need, and the names of their catalogues."""
    with atomic_file(path) as temporary:
        bpy.data.libraries.write(str(temporary), set(actions), fake_user=True, compress=True)
    gesture_assets.write_catalogues(path)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
