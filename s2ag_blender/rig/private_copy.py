"""Makes a private copy of a rig for measuring poses, so that the user's rig, scene and frame stay unchanged.

The copy is alone in a scene of its own, so Blender evaluates only what its bones depend on. Measuring on the rig itself
would evaluate every mesh that it deforms, would need frame, pose and animation restored after each error, and would leave
traces in library overrides."""

import contextlib
import time
from collections.abc import Generator, Iterator, Sequence
from typing import Any, TypeVar, cast

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from ...rigs.skeleton import Bones
from ..datablocks import ArmatureObject
from . import dependencies

_ID = TypeVar("_ID", bound=bpy.types.ID)

SLICE = 0.03
"""Seconds of measuring before control returns to Blender, or as long as making the copy took if that is more."""


class RigCopy:
    """A copy of an armature object without animation, every bone at rest; ``timed`` if what it depends on changes with time."""

    def __init__(self, item: ArmatureObject, scene: bpy.types.Scene, timed: bool) -> None:
        self.item, self.scene, self.timed = item, scene, timed

    def pose(self, rotations: dict[str, np.ndarray], frame: float | None = None) -> None:
        """Set rotations (w, x, y, z) of bones and evaluate, at scene ``frame`` if the rig is ``timed``."""
        bones = self.item.pose.bones
        for name, rotation in rotations.items():
            bones[name].matrix_basis = Quaternion(rotation).to_matrix().to_4x4()  # pyright: ignore[reportArgumentType]
        if self.timed and frame is not None:
            self.scene.frame_set(int(frame // 1), subframe=frame % 1)
        else:
            self.scene.view_layers[0].update()

    def matrices(self, names: Sequence[str]) -> np.ndarray:
        """Return the evaluated matrices (n, 4, 4) of bones in armature space, each bone along its own y axis."""
        bones = self._evaluated()
        return np.array([bones[name].matrix for name in names], float).reshape(-1, 4, 4)

    def tails(self, names: Sequence[str]) -> np.ndarray:
        """Return the tails (n, 3) of bones in armature space."""
        bones = self._evaluated()
        return np.array([bones[name].tail for name in names], float).reshape(-1, 3)

    def as_bones(self, bones: Bones) -> Bones:
        """Return ``bones`` with their current evaluated pose, without scale, as the rest pose."""
        matrices, tails = self.matrices(bones.names), self.tails(bones.names)
        matrices[:, :3, :3] = rotations_without_scale(matrices[:, :3, :3])
        lengths = np.linalg.norm(tails - matrices[:, :3, 3], axis=-1)
        return Bones(bones.names, bones.parents, matrices, lengths, bones.inherits)

    def _evaluated(self) -> Any:
        # Every update may rebuild the evaluated pose, so no reference to it is kept.
        return cast(ArmatureObject, self.item.evaluated_get(_depsgraph(self.scene))).pose.bones


class PausableCopy:
    """A :class:`RigCopy` that is removed whenever control returns to Blender, so that nothing done or saved then sees it.

    ``arguments`` are those of :func:`rig_copy`."""

    def __init__(self, *arguments: Any) -> None:
        self._rig: RigCopy | None = None
        self._arguments, self._stack, self._until = arguments, contextlib.ExitStack(), 0.0

    @property
    def rig(self) -> RigCopy:
        """The current copy; only inside the ``with`` block, and not while Blender runs."""
        assert self._rig is not None
        return self._rig

    def __enter__(self) -> "PausableCopy":
        start = time.perf_counter()
        self._rig = self._stack.enter_context(rig_copy(*self._arguments))
        end = time.perf_counter()
        self._until = end + max(SLICE, end - start)
        return self

    def __exit__(self, *error: object) -> None:
        self._rig = None
        self._stack.close()

    def pause(self, always: bool = False) -> Generator[None, None, None]:
        """Return control to Blender if the slice is over, or ``always``; afterwards every bone is at rest again."""
        if always or time.perf_counter() >= self._until:
            self.__exit__()
            yield
            self.__enter__()


def rotations_without_scale(matrices: np.ndarray) -> np.ndarray:
    """Return the rotations (..., 3, 3) in matrices that may scale and mirror; y, along a bone, keeps its direction."""
    y = matrices[..., 1] / np.linalg.norm(matrices[..., 1], axis=-1, keepdims=True)
    x = matrices[..., 0] - y * np.sum(y * matrices[..., 0], -1, keepdims=True)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], -1)


@contextlib.contextmanager
def rig_copy(
    armature: ArmatureObject, scene: bpy.types.Scene, bones: Sequence[str], values: dict[str, float] | None = None,
    frame: float | None = None
) -> Iterator[RigCopy]:  # fmt: skip
    """Yield a :class:`RigCopy` for ``armature`` on which ``bones`` can be measured; remove it and its data afterwards.

    ``values`` are property values to set on the copy, by data path from the object; ``frame`` is the scene frame at which it
    is evaluated (the current one, if None)."""
    made = []
    with _silence():
        try:
            item = _copy(armature, made)
            needed = dependencies.dependencies_of(item) - {item, armature}
            others = [other for other in needed if armature in dependencies.dependencies_of(other)]  # they need each other
            copies: dict[bpy.types.ID, bpy.types.Object] = {armature: item}
            copies |= {other: _keep(other.copy(), made) for other in others}
            for copy in copies.values():
                dependencies.retarget_references(copy, copies)
            for path, value in (values or {}).items():
                dependencies.set_value(item, path, value)
            dependencies.trim(item, bones)
            stage = _keep(bpy.data.scenes.new(f"{armature.name} measured"), made)
            stage.render.fps, stage.render.fps_base = scene.render.fps, scene.render.fps_base
            for copy in copies.values():
                copy.hide_viewport = False
                stage.collection.objects.link(copy)
            frame = scene.frame_current_final if frame is None else frame
            stage.frame_set(int(frame // 1), subframe=frame % 1)
            yield RigCopy(item, stage, dependencies.moves_by_itself(_depsgraph(stage), item))
        finally:
            _remove(made)


def _depsgraph(scene: bpy.types.Scene) -> bpy.types.Depsgraph:
    return cast(bpy.types.Depsgraph, scene.view_layers[0].depsgraph)


def _copy(armature: ArmatureObject, made: list[bpy.types.ID]) -> ArmatureObject:
    """Return a copy of an armature object at rest, without NLA, action and custom shapes; add it and its data to ``made``."""
    item = cast(ArmatureObject, _keep(armature.copy(), made))
    item.data = _keep(armature.data.copy(), made)
    item.data.pose_position = "POSE"
    if item.animation_data is not None:
        item.animation_data.use_nla = False
        item.animation_data.action = None
    for bone in item.pose.bones:
        bone.matrix_basis = Matrix()
        bone.custom_shape = None
    return item


def _keep(datablock: _ID, made: list[bpy.types.ID]) -> _ID:
    made.append(datablock)
    return datablock


def _remove(made: list[bpy.types.ID]) -> None:
    # With its data an object would go as well, so objects go first.
    for kind, collection in (("SCENE", "scenes"), ("OBJECT", "objects"), ("ARMATURE", "armatures")):
        for datablock in [datablock for datablock in made if datablock.id_type == kind]:
            made.remove(datablock)
            getattr(bpy.data, collection).remove(datablock)


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Disable the handlers of other add-ons, which could keep references to data that is about to be removed."""
    handlers = bpy.app.handlers
    lists = [
        handlers.depsgraph_update_pre,
        handlers.depsgraph_update_post,
        handlers.frame_change_pre,
        handlers.frame_change_post,
    ]
    former = [list(functions) for functions in lists]
    for functions in lists:
        functions.clear()
    try:
        yield
    finally:
        for functions, before in zip(lists, former, strict=True):
            functions[:] = before
