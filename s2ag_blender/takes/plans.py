"""What a run passes between its steps: the plan for the engine and Blender, and the outcome."""

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...rigs.goals import Options
from ...rigs.skeleton import Mapping
from . import recordings, retiming, sources, timing


@dataclass(frozen=True)
class Handle:
    """A reference to a datablock: by its ``session_uid``, else by its name."""

    uid: int
    name: str

    @classmethod
    def of(cls, datablock: bpy.types.ID) -> "Handle":
        """Return the reference to a datablock."""
        return cls(datablock.session_uid, datablock.name)

    def find(self, collection: Any) -> Any:
        """Return the datablock in a collection of ``bpy.data``, or None if it is gone."""
        return next((item for item in collection if item.session_uid == self.uid), None) or collection.get(self.name)


@dataclass(frozen=True)
class Plan:
    """Everything for a run: ``params`` for the engine, and how to key its motions."""

    armature: Handle
    scene: Handle
    params: dict[str, Any]
    voice: sources.Voice
    settings: dict[str, Any]
    mapping: Mapping | dict | None = None
    resolved: tuple[tuple, Mapping] | None = None
    """The rig's state (:func:`readiness.state`) when its mapping was resolved, and that mapping."""
    options: Options = field(default_factory=Options)
    pose: dict[str, np.ndarray] = field(default_factory=dict)
    draft: bool = False
    warnings: tuple[str, ...] = ()
    rate: float | None = None
    """The scene's frames per second, by which times became frames; None if it does not matter."""
    bones: frozenset[str] = frozenset()
    """Names of the character's bones, which must stay."""
    former: Handle | None = None
    """The action of an edited take, whose next version the result becomes."""
    pins: tuple[dict, ...] = ()
    """Additional constraints of that version (:mod:`constraints`)."""
    grown: bool = False
    """Whether the result shows more of the recording than the former version."""
    follows: bool = False
    """Whether no take is added: the selected one follows its sound, which plays this recording now (:mod:`retiming`)."""
    started: list | None = None
    """Edge directions ``(9, 3)`` of the pose that the take starts from; None for rest."""
    around: list | None = None
    """Poses before and after the take, which it keeps (:func:`context_poses.poses_around`)."""
    count: int = 1
    """How many motions the engine is asked for."""
    carried: Handle | None = None
    """The action of a directed take, whose decisions a new take keeps."""

    @property
    def lies(self) -> dict[str, Any]:
        """Return the provenance of a take with a time warp or a followed strip; {} for others."""
        voice = self.voice
        follows = {"path": voice.path, retiming.FILE: recordings.content_mark(voice.path)}
        timed = {timing.WAY: timing.time_map_as_meta(voice.way), retiming.FOLLOWS: follows}
        return timed if voice.followed or voice.way is not None else {}


@dataclass(frozen=True)
class Outcome:
    """The result of a run: actions, one per take, seconds of speech, and warnings and notes for the user."""

    actions: list[bpy.types.Action]
    seconds: float
    warnings: list[str]
    notes: list[str] = field(default_factory=list)
    said: str = ""
    """What an edit changed, in a sentence."""
