"""A private copy of a rig on which poses are tried and measured, so that the user's rig, scene and frame stay as they are.

The copy stands alone in a scene of its own: nothing else is evaluated than what its bones depend on. Measuring on the
rig itself would evaluate every mesh that it deforms, would need frame, pose and animation put back after each error, and
would leave traces in library overrides.
"""

import contextlib
import time
from collections.abc import Generator, Iterator, Sequence

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from ...rigs.plain import Bones
from . import dependencies

SLICE = 0.03
"""Seconds for which a copy is measured before Blender may go on, or as long as making it took if that is more."""


class StandIn:
    """A copy of an armature object without animation, every bone at rest."""

    def __init__(self, item: bpy.types.Object, scene: bpy.types.Scene, timed: bool):
        self.item, self.scene, self.timed = item, scene, timed

    def pose(self, rotations: dict[str, np.ndarray], frame: float | None = None) -> None:
        """Give bones their rotations (w, x, y, z) and evaluate, at a scene frame where something moves by itself."""
        bones = self.item.pose.bones
        for name, rotation in rotations.items():
            bones[name].matrix_basis = Quaternion(rotation).to_matrix().to_4x4()
        if self.timed and frame is not None:
            self.scene.frame_set(int(frame // 1), subframe=frame % 1)
        else:
            self.scene.view_layers[0].update()

    def matrices(self, names: Sequence[str]) -> np.ndarray:
        """Evaluated matrices (n, 4, 4) of bones in armature space, bone along its own y."""
        bones = self._evaluated()
        return np.array([bones[name].matrix for name in names], float).reshape(-1, 4, 4)

    def tails(self, names: Sequence[str]) -> np.ndarray:
        """Where bones end (n, 3) in armature space."""
        bones = self._evaluated()
        return np.array([bones[name].tail for name in names], float).reshape(-1, 3)

    def as_bones(self, bones: Bones) -> Bones:
        """``bones`` as they stand now, without scale, in place of how they were drawn."""
        matrices, tails = self.matrices(bones.names), self.tails(bones.names)
        matrices[:, :3, :3] = upright(matrices[:, :3, :3])
        lengths = np.linalg.norm(tails - matrices[:, :3, 3], axis=-1)
        return Bones(bones.names, bones.parents, matrices, lengths, bones.inherits)

    def _evaluated(self):
        # Every update may build the evaluated pose anew, so it is asked for each time.
        return self.item.evaluated_get(self.scene.view_layers[0].depsgraph).pose.bones


class Returning:
    """A :class:`StandIn` that is not there while Blender goes on: whatever is done or saved meanwhile knows nothing of it.

    ``rig`` is the one that is there; ``given`` are what :func:`stand_in` takes.
    """

    def __init__(self, *given):
        self.rig: StandIn | None = None
        self._given, self._stack, self._until = given, contextlib.ExitStack(), 0.0

    def __enter__(self) -> "Returning":
        began = time.perf_counter()
        self.rig = self._stack.enter_context(stand_in(*self._given))
        made = time.perf_counter()
        self._until = made + max(SLICE, made - began)
        return self

    def __exit__(self, *error) -> None:
        self.rig = None
        self._stack.close()

    def pause(self, always: bool = False) -> Generator[None, None, None]:
        """Let Blender go on if it is time, or ``always``; afterwards every bone is at rest again."""
        if always or time.perf_counter() >= self._until:
            self.__exit__()
            yield
            self.__enter__()


def upright(matrices: np.ndarray) -> np.ndarray:
    """The rotations (..., 3, 3) in matrices that may scale and mirror; y, along a bone, is kept."""
    y = matrices[..., 1] / np.linalg.norm(matrices[..., 1], axis=-1, keepdims=True)
    x = matrices[..., 0] - y * np.sum(y * matrices[..., 0], -1, keepdims=True)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], -1)


@contextlib.contextmanager
def stand_in(
    armature: bpy.types.Object,
    scene: bpy.types.Scene,
    bones: Sequence[str],
    values: dict[str, float] | None = None,
    frame: float | None = None,
) -> Iterator[StandIn]:
    """A :class:`StandIn` for ``armature``, of use for measuring ``bones``; gone with all that it needed afterwards.

    ``values`` are settings of the copy, by data path from the object; ``frame`` is when it stands there (the scene's, if
    None).
    """
    made = []
    with _silence():
        try:
            item = _copy(armature, made)
            others = dependencies.between(item, armature)
            copies = {armature: item} | {other: _keep(other.copy(), made) for other in others}
            for copy in copies.values():
                dependencies.redirect(copy, copies)
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
            yield StandIn(item, stage, dependencies.moves_by_itself(stage.view_layers[0].depsgraph, item))
        finally:
            _remove(made)


def _copy(armature, made: list) -> bpy.types.Object:
    item = _keep(armature.copy(), made)
    item.data = _keep(armature.data.copy(), made)
    item.data.pose_position = "POSE"
    if item.animation_data is not None:
        item.animation_data.use_nla = False
        item.animation_data.action = None
    for bone in item.pose.bones:
        bone.matrix_basis = Matrix()
        bone.custom_shape = None
    return item


def _keep(datablock, made: list):
    made.append(datablock)
    return datablock


def _remove(made: list) -> None:
    # With its data an object would go as well, so objects go first.
    for kind, collection in (("SCENE", "scenes"), ("OBJECT", "objects"), ("ARMATURE", "armatures")):
        for datablock in [datablock for datablock in made if datablock.id_type == kind]:
            made.remove(datablock)
            getattr(bpy.data, collection).remove(datablock)


@contextlib.contextmanager
def _silence():
    """Without the handlers of other add-ons, which could hold on to data that is about to vanish."""
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
