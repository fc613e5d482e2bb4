"""Measures hands and legs of a character on a chair for ``s2ag evaluate --seated``, on the vertices of its meshes.

``python -m s2ag.s2ag_blender.render.seated_trial JOB.json`` with the fields ``character``, ``gender``, ``fps``, ``motions``
(paths of ``.npz``), ``tables`` (heights in metres above the hip joints, 0 without one), ``rests``, the height of a chair's arm
rests, which are meant where a table has it, and, where a ``.blend`` of every motion is wanted, ``keep`` (a path's beginning).
"""

import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from ...core import json_text
from ...core.motion.motion import Motion
from ...rigs import legs
from ...rigs.goals import SIDES, Options
from ...rigs.skeleton import Mapping, character_frame
from .. import program
from ..datablocks import ArmatureObject, MeshObject, current_context
from ..rig import body_shape, reading, solver

PARTS = ("hands", "forearms")
_FAR = 0.1
"""Metres within which the surface of a thigh is looked for."""
REST = 0.24, 0.32, 0.25
"""Metres from the middle of a chair to the inner and the outer side of its arm rests, and of their front ahead of the hips."""


class Sitter:
    """A character whose thighs are turned up by ``degrees``, knees bent by as much; ``left``, ``back``, ``up`` are its own."""

    def __init__(self, item: ArmatureObject, degrees: float = 84.0, mapping: Mapping | None = None):
        self.item, self.bones = item, reading.read(item)
        self.mapping = reading.resolve_mapping(item, self.bones) if mapping is None else mapping
        self.left, self.back, self.up = character_frame(self.bones, self.mapping)
        found = legs.find(self.bones, self.mapping, self.up)
        assert found is not None, "the character has no legs"
        self.legs = found
        for leg in self.legs.pair:
            outward = np.sign(self.bones.heads[leg.thigh] @ self.left)
            self.turn(leg.thigh, self.left, -degrees)
            self.turn(leg.thigh, self.up, 8 * outward)
            self.turn(leg.shin, self.left, degrees)
        self._skins = [_Skin(one, self) for one in body_shape.meshes(item)]

    def turn(self, row: int, axis: np.ndarray, degrees: float) -> None:
        """Turn a bone about an axis (3,) through its head."""
        _update()
        bone = self.item.pose.bones[self.bones.names[row]]
        about = Matrix.Translation(bone.matrix.translation)
        bone.matrix = about @ Matrix.Rotation(np.radians(degrees), 4, Vector(axis.tolist())) @ about.inverted() @ bone.matrix
        _update()

    def hips(self) -> np.ndarray:
        """Return the middle between the hip joints (3,) in the scene."""
        heads = [self.item.matrix_world @ self.item.pose.bones[self.bones.names[leg.thigh]].head for leg in self.legs.pair]
        return np.mean(np.array(heads), axis=0)

    def posed(self) -> np.ndarray:
        """Return the matrices (n, 4, 4) of pelvis, legs and feet, as they are now."""
        rows = [row for row in range(len(self.bones.names)) if {row, *self.bones.ancestors(row)} & set(self.legs.rows()[1:])]
        _update()
        return np.array([self.item.pose.bones[self.bones.names[row]].matrix for row in (self.legs.pelvis, *rows)])

    def below(self, row: int, without: int = -1) -> set[str]:
        """Return the names of a bone and all below it, but for the bone ``without`` and those below that."""
        lines = {one: {one, *self.bones.ancestors(one)} for one in range(len(self.bones.names))}
        return {self.bones.names[one] for one, line in lines.items() if row in line and without not in line}

    def edge(self, table: float) -> float:
        """Return how far ahead of the hips a ``table`` of this height begins."""
        trunk = body_shape.read_trunk(self.item, self.bones, self.mapping)
        seat = solver.find_seat(self.item, self.bones, self.mapping, Options(table=table), trunk)
        assert seat is not None, "the character does not sit"
        return (seat.edge + seat.joints[:, 0, 1].mean()) * self.item.matrix_world.to_scale()[1]

    def ahead(self, points: np.ndarray) -> np.ndarray:
        """Return how far (n,) points (n, 3) of the scene are ahead of the hips."""
        turned = np.array(self.item.matrix_world.to_3x3()) @ -self.back
        return (points - self.hips()) @ (turned / np.linalg.norm(turned))

    def in_rests(self, points: np.ndarray, high: float) -> float:
        """Return the metres by which the deepest of ``points`` (n, 3) of the scene lies in arm rests of this height."""
        side = np.array(self.item.matrix_world.to_3x3()) @ self.left
        aside = np.abs((points - self.hips()) @ (side / np.linalg.norm(side)))
        inner, outer, front = REST
        depths = np.stack([high - points[:, 2], aside - inner, outer - aside, front - self.ahead(points)]).min(0)
        return max(float(depths.max()), 0.0)

    def depth(self, frame: int) -> tuple[dict[str, float], dict[str, np.ndarray]]:
        """Return the metres by which vertices of each of :data:`PARTS` lie in a thigh, at most, and these vertices (n, 3)."""
        current_context().scene.frame_set(frame)
        points: dict[str, list[np.ndarray]] = {part: [] for part in PARTS}
        trees: list[tuple[BVHTree, np.ndarray]] = []
        for skin in self._skins:
            places = skin.places()
            if places is None:
                continue
            if skin.faces:
                trees.append(surface(places[skin.thighs], skin.faces))
            for part in PARTS:
                points[part].append(places[skin.rows[part]])
        joined = {part: np.concatenate(each) for part, each in points.items()}
        return {part: max((depth(*tree, each) for tree in trees), default=0.0) for part, each in joined.items()}, joined


class _Skin:
    """A mesh of a :class:`Sitter`: ``rows`` of vertices by part, those of its ``thighs`` and the ``faces`` between them."""

    def __init__(self, item: MeshObject, sitter: Sitter):
        self.item, chains, row = item, sitter.mapping.chains, sitter.bones.row
        thighs = set.union(*(sitter.below(leg.thigh, leg.shin) for leg in sitter.legs.pair))
        hands = set.union(*(sitter.below(row(chains[f"{side}_hand"][0])) for side in SIDES))
        fore = set.union(*(sitter.below(row(chains[f"{side}_forearm"][0])) for side in SIDES)) - hands
        names = {group.index: group.name for group in item.vertex_groups if group.name in sitter.bones.names}
        pulls = ([(one.weight, names[one.group]) for one in body_shape.vertex_weights(vertex) if one.group in names]
                 for vertex in item.data.vertices)  # fmt: skip
        owners = [max(each, default=(0, ""))[1] for each in pulls]
        rows = [np.array([place for place, owner in enumerate(owners) if owner in own], int) for own in (hands, fore, thighs)]
        self.count, self.thighs, self.rows = len(owners), rows[2], dict(zip(PARTS, rows, strict=False))
        new = {int(old): place for place, old in enumerate(self.thighs)}
        faces = (list(face.vertices) for face in item.data.polygons)
        self.faces = [[new[corner] for corner in face] for face in faces if new.keys() >= set(face)]

    def places(self) -> np.ndarray | None:
        """Return the vertices (n, 3) in the scene as they are posed now, or None if a modifier changes their number."""
        seen = self.item.evaluated_get(current_context().evaluated_depsgraph_get())
        mesh = seen.to_mesh()
        if mesh is None or len(mesh.vertices) != self.count:
            return None
        flat = np.empty(3 * self.count, np.float32)
        mesh.vertices.foreach_get("co", flat)
        seen.to_mesh_clear()
        turn = np.array(seen.matrix_world)
        return flat.reshape(-1, 3) @ turn[:3, :3].T + turn[:3, 3]


def surface(points: np.ndarray, faces: list[list[int]]) -> tuple[BVHTree, np.ndarray]:
    """Return the surface of ``faces`` between ``points`` (n, 3), and the box (2, 3) around it."""
    tree = BVHTree.FromPolygons(points.tolist(), faces)
    assert tree is not None
    return tree, np.stack([points.min(0), points.max(0)])


def depth(tree: BVHTree, box: np.ndarray, points: np.ndarray) -> float:
    """Return how deep the deepest of ``points`` (n, 3) lies in a surface within ``box`` (2, 3) that may be open at its ends."""
    up, deepest = Vector((0, 0, 1)), 0.0
    for point in map(Vector, points[((points >= box[0]) & (points <= box[1])).all(1)].tolist()):
        near, normal, _, apart = tree.find_nearest(point, _FAR)
        if near is None or normal is None or apart is None or apart <= deepest or (point - near).dot(normal) >= 0:
            continue
        if all(tree.ray_cast(point, way)[0] for way in (up, -up)):
            deepest = apart
    return deepest


def main(arguments: list[str]) -> int:
    """Run the job file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(json_text.read(path), voice))


def perform(job: dict, voice: program.EventWriter) -> dict:
    """Key every motion of the job with and without tables and measure it; return the ``result`` event's content."""
    from ..characters import loading

    scene, characters, _ = loading.build_scene([(job["character"], job.get("gender", "female"), None, None)])
    scene.render.fps, scene.render.fps_base = job["fps"], 1.0
    sitter = Sitter(characters[0].armature, mapping=characters[0].mapping)
    rows = []
    asked = [(table, number) for table in job["tables"] for number in range(len(job["motions"]))]
    for done, (table, number) in enumerate(asked):
        rows.append({"table": table, "motion": number} | _measured(sitter, job, job["motions"][number], table))
        voice.progress("frames", (done + 1) / len(asked))
        if "keep" in job:
            bpy.ops.wm.save_as_mainfile(filepath=f"{job['keep']}-{number}{f'-{table:g}' * bool(table)}.blend", copy=True)
    return {"rows": rows}


def _measured(sitter: Sitter, job: dict, path: str, table: float) -> dict:
    """Key a motion and return its figures: metres at every frame, and how far anything of hips, legs and feet moved."""
    from ..keys.apply import apply_motion

    motion, scene, hips = Motion.load(path), current_context().scene, sitter.hips()
    high = float(hips[2] + table) if table else 0.0
    about = {"scene": scene, "mapping": sitter.mapping, "options": Options(table=high)}
    before, edge = sitter.posed(), sitter.edge(high) if table else 0.0
    apply_motion(sitter.item, motion, 1, **about)
    scene.frame_start, scene.frame_end = 1, int((len(motion.directions) - 1) / motion.fps * job["fps"]) + 1
    figures: dict[str, list[float]] = {f"{part} in {what}": [] for part in PARTS for what in ("thigh", "table", "arm rest")}
    moved = 0.0
    for frame in range(1, scene.frame_end + 1):
        thighs, places = sitter.depth(frame)
        for part in PARTS:
            figures[f"{part} in thigh"].append(thighs[part])
            solid = table and table != job["rests"]
            inside = np.minimum(high - places[part][:, 2], sitter.ahead(places[part]) - edge) if solid else np.zeros(1)
            figures[f"{part} in table"].append(max(float(inside.max()), 0.0))
            figures[f"{part} in arm rest"].append(sitter.in_rests(places[part], float(hips[2]) + job["rests"]))
        moved = max(moved, float(np.abs(sitter.posed() - before).max()))
    return {"figures": figures, "moved": moved}


def _update() -> None:
    current_context().view_layer.update()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
