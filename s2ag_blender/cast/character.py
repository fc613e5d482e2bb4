"""A character in the scene: an armature, the meshes it moves, and the collection they live in."""

from dataclasses import dataclass

from ...rigs.plain import Mapping


@dataclass(frozen=True)
class Character:
    """``armature`` is the armature object to animate, ``meshes`` the objects it deforms, ``collection`` may be None.

    ``mapping`` says which bones are which parts of the body; where it is None they are recognised. ``disarmed`` are
    sentences on what its file would have run or written (:mod:`disarm`).
    """

    armature: object
    meshes: tuple = ()
    collection: object = None
    mapping: Mapping | None = None
    disarmed: tuple[str, ...] = ()
