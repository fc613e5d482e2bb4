"""Renders many takes as low-poly figures in a grid, at once, with Workbench: ``start.py -- s2ag_blender.render.sheet
JOB.json``.

The job is a JSON object: ``cells``, each with ``motion`` (``.npz``), ``row``, ``column`` and ``label`` (two lines of text);
``audio`` or null, ``fps``, and ``outputs``: ``.mp4`` for a film, ``.png`` for a contact sheet of stills. Events and exit status
are those of :mod:`job`.
"""

import tempfile
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Matrix

from ...core import json_text
from ...core.errors import UsageError
from ...core.files import atomic_file, check_output
from ...core.motion.motion import Motion
from ...core.motion.skeleton import canonical_to_blender
from .. import program
from ..characters import mannequin, materials
from ..datablocks import ArmatureObject, MeshObject, current_context
from ..keys.apply import apply_motion
from . import render, stage
from .sound import add_sound

WIDTH, HEIGHT = 1.56, 1.36
"""Least size of a cell in metres: from the hips to above the head with the label below."""
_ARM, _FINGERS, _MARGIN = ("shoulder", "upper_arm", "lower_arm", "hand"), 1.1, 0.08
"""Bones of an arm; a hand with its fingers, in lengths of its bone; metres for trunks that sway and hands that bend out."""
LABEL = 0.24
"""Height of a cell's label in metres."""
CELL = 320
"""Width of a cell in pixels, in sheets with few columns."""
WIDEST = 1920
"""Most pixels of a sheet's width."""
MOMENTS = 6
"""Stills of every cell on a contact sheet."""
_FACE_SHARE = 0.25
"""Share of the mannequin's faces that a figure keeps."""
_CUT_HEIGHT = 0.80
"""Height in metres of a figure's lower edge."""
_TURN = np.radians(14)
"""Figures are turned a little, which shows how far forward a hand is."""
_GREY, _DARK, _PAPER = (0.30, 0.335, 0.36), (0.02, 0.022, 0.025), (0.75, 0.77, 0.78)


def main(arguments: list[str]) -> int:
    """Run the sheet file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(_read(path), voice))


def perform(content: dict[str, Any], voice: program.EventWriter) -> dict[str, Any]:
    """Render the sheet in this Blender, whose open file is lost; return the ``result`` event's content. Raises S2agError."""
    outputs = [check_output(path) for path in content["outputs"]]
    motions = [Motion.load(cell["motion"]) for cell in content["cells"]]
    with voice.stage("figures"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = current_context().scene
        render.require_engine("workbench", scene)
        scene.render.fps, scene.render.fps_base = round(content["fps"]), round(content["fps"]) / content["fps"]
        _fill(scene, content["cells"], motions)
        if content["audio"]:
            add_sound(scene, content["audio"], 1)
        scene.frame_start = 1
        scene.frame_end = 1 + int(max(len(one.directions) / one.fps for one in motions) * content["fps"])
    for path in outputs:
        name = f"write {path.name}"
        with voice.stage(name):
            if path.suffix.lower() == ".mp4":
                # Without a GPU, antialiasing takes twice as long as everything else.
                render.film(scene, path, render.Look(samples=1), lambda share, name=name: voice.progress(name, share))
            else:
                _contact_sheet(scene, path, content["cells"], motions)
    return {"outputs": content["outputs"], "seconds": voice.seconds}


def _read(path: str) -> dict[str, Any]:
    try:
        content = json_text.read(path)
        for key in ("cells", "audio", "fps", "outputs"):
            content[key]
        return content
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{path} is not a sheet: {error!r}", "Let s2ag sample write it.") from error


def _fill(scene: bpy.types.Scene, cells: list[dict], motions: list[Motion]) -> None:
    """Add figures with their gestures, panels, labels, and a camera that shows them all."""
    first = _Figure(scene)
    width = cell_width(motions, first.armature)
    figures = [first] + [first.again(scene) for _ in cells[1:]]
    panels = [materials.plain(f"Panel {shade}", np.array(_GREY) * shade, 1.0) for shade in (0.85, 1.0)]
    ink = materials.plain("Ink", _DARK, 1.0)
    for cell, figure, motion in zip(cells, figures, motions, strict=True):
        corner = np.array([cell["column"] * width, 0.0, -cell["row"] * HEIGHT])
        _panel(scene, corner, panels[(cell["row"] + cell["column"]) % 2], width)
        for line, text in enumerate(cell["label"]):
            _text(scene, text, corner + [0.05, 0, 0.135 - 0.095 * line], 0.095, ink, width)
        figure.place(corner + [width / 2, 0, LABEL - _CUT_HEIGHT])
        apply_motion(figure.armature, motion, 1, scene=scene, report=lambda warning: None)
    columns, rows = (1 + max(cell[part] for cell in cells) for part in ("column", "row"))
    _camera(scene, columns, rows, width)


def cell_width(motions: list[Motion], armature: ArmatureObject) -> float:
    """Return the width of cells in metres in which every figure's hands stay: :data:`WIDTH`, or more for arms held wider."""
    bones = armature.data.bones
    long = [next(bone.length for bone in bones if bone.name.split(".")[0] == part) for part in _ARM]
    reach = WIDTH / 2
    for motion in motions:
        for arm in ((3, 4, 5), (6, 7, 8)):
            ways = canonical_to_blender(motion.directions[:, arm].astype(float))
            place = sum(length * ways[:, link] for link, length in enumerate(long[:3])) + long[3] * ways[:, 2] * _FINGERS
            across = place[:, 0] * np.cos(_TURN) - place[:, 1] * np.sin(_TURN)
            reach = max(reach, float(np.abs(across).max()) + _MARGIN)
    return 2 * reach


class _Figure:
    """The mannequin from the hips up, each part a child of its bone: faster than skinning."""

    def __init__(self, scene: bpy.types.Scene, template: "_Figure | None" = None) -> None:
        if template is None:
            character = mannequin.build()
            self.armature, (body,) = character.armature, character.meshes
            self.parts = _split(body, self.armature)
            bpy.data.objects.remove(body)
        else:
            self.armature = cast(ArmatureObject, bpy.data.objects.new("Figure", template.armature.data))
            scene.collection.objects.link(self.armature)
            self.parts = template.parts
        for bone, mesh in self.parts:
            part = bpy.data.objects.new(f"{self.armature.name} {bone}", mesh)
            scene.collection.objects.link(part)
            part.parent, part.parent_type, part.parent_bone = self.armature, "BONE", bone

    def again(self, scene: bpy.types.Scene) -> "_Figure":
        """Return another figure with the same meshes and bones."""
        return _Figure(scene, self)

    def place(self, spot: np.ndarray) -> None:
        """Place the figure at ``spot`` (3,), turned a little."""
        self.armature.matrix_world = Matrix.Translation(spot.tolist()) @ Matrix.Rotation(_TURN, 4, "Z")


def _split(body: MeshObject, armature: ArmatureObject) -> list[tuple[str, bpy.types.Mesh]]:
    """Return the part of a rigidly weighted mesh for each bone from the hips up, relative to that bone's tail."""
    mesh = body.data
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    owners = np.array([max(vertex.groups, key=lambda one: one.weight).group for vertex in mesh.vertices])
    faces = [tuple(face.vertices) for face in mesh.polygons]
    slots = [face.material_index for face in mesh.polygons]
    first = np.array([owners[face[0]] for face in faces])
    parts = []
    for group in body.vertex_groups:
        bone = armature.data.bones[group.name]
        own = np.flatnonzero(first == group.index)
        if bone.name.split(".")[0] in ("thigh", "shin", "foot") or not len(own):
            continue
        rows = np.flatnonzero(owners == group.index)
        index = np.full(len(points), -1)
        index[rows] = np.arange(len(rows))
        into = np.array((bone.matrix_local @ Matrix.Translation((0, bone.length, 0))).inverted())
        part = bpy.data.meshes.new(f"Figure {bone.name}")
        corners = [index[list(faces[k])].tolist() for k in own]
        part.from_pydata((points[rows] @ into[:3, :3].T + into[:3, 3]).tolist(), [], corners)
        part.polygons.foreach_set("material_index", np.array([slots[k] for k in own], np.int32))
        for material in mesh.materials:
            part.materials.append(material)
        parts.append((bone.name, _decimate(part)))
    return parts


def _decimate(mesh: bpy.types.Mesh) -> bpy.types.Mesh:
    """Return the mesh with fewer faces, since it is drawn small and without a GPU; the original is removed."""
    item = bpy.data.objects.new("Part", mesh)
    current_context().scene.collection.objects.link(item)
    modifier: Any = item.modifiers.new("Decimate", "DECIMATE")
    modifier.ratio = _FACE_SHARE
    current_context().view_layer.update()
    light = bpy.data.meshes.new_from_object(item.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(item)
    bpy.data.meshes.remove(mesh)
    light.shade_smooth()
    return light


def _panel(scene: bpy.types.Scene, corner: np.ndarray, material: bpy.types.Material, width: float) -> None:
    """Add the wall behind a figure and the strip for its label in front of the figure's waist."""
    wall = [(0, 1, 0), (width, 1, 0), (width, 1, HEIGHT), (0, 1, HEIGHT)]
    _plane(scene, corner, wall, material)
    strip = bpy.data.materials.get("Paper") or materials.plain("Paper", _PAPER, 1.0)
    _plane(scene, corner, [(0, -1, 0), (width, -1, 0), (width, -1, LABEL), (0, -1, LABEL)], strip)


def _plane(
    scene: bpy.types.Scene, corner: np.ndarray, points: list[tuple[float, float, float]], material: bpy.types.Material
) -> None:
    mesh = bpy.data.meshes.new("Panel")
    mesh.from_pydata((np.array(points) + corner).tolist(), [], [(0, 1, 2, 3)])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Panel", mesh))


def _text(
    scene: bpy.types.Scene, text: str, spot: np.ndarray, size: float, material: bpy.types.Material, width: float
) -> None:
    """Add a line of text that faces the camera, squeezed to the width of a cell."""
    curve: Any = bpy.data.curves.new("Label", "FONT")
    curve.body, curve.size = text, size
    curve.materials.append(material)
    item = bpy.data.objects.new("Label", curve)
    scene.collection.objects.link(item)
    current_context().view_layer.update()
    room = width - 0.1
    squeeze = min(1.0, room / max(item.dimensions.x, 1e-6))
    upright = Matrix.Rotation(np.pi / 2, 4, "X") @ Matrix.Scale(squeeze, 4, (1, 0, 0))
    item.matrix_world = Matrix.Translation((spot + [0, -1.1, 0]).tolist()) @ upright


def _camera(scene: bpy.types.Scene, columns: int, rows: int, width: float) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.clip_end = "ORTHO", 100
    item = bpy.data.objects.new("Camera", camera)
    scene.collection.objects.link(item)
    scene.camera = item
    wide, tall = columns * width, rows * HEIGHT
    camera.ortho_scale = max(wide, tall)
    item.matrix_world = Matrix.Translation((wide / 2, -20, HEIGHT - tall / 2)) @ Matrix.Rotation(np.pi / 2, 4, "X")
    pixels = min(CELL, WIDEST // columns) / width
    scene.render.resolution_x, scene.render.resolution_y = (round(size * pixels / 2) * 2 for size in (wide, tall))
    stage.set_standard_view(scene)
    stage.workbench(scene)


def _contact_sheet(scene: bpy.types.Scene, path: Path, cells: list[dict], motions: list[Motion]) -> None:
    """Write an image with a row of :data:`MOMENTS` stills for every cell, at moments when most figures gesture."""
    pictures = []
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        for frame in _moments(scene, motions):
            file = Path(folder) / f"{frame}.png"
            render.still(scene, file, frame, render.Look(samples=5))
            pictures.append(_pixels(file))
    columns, rows = (1 + max(cell[part] for cell in cells) for part in ("column", "row"))
    tall, wide = pictures[0].shape[0] // rows, pictures[0].shape[1] // columns
    strips = []
    for cell in cells:
        top, left = cell["row"] * tall, cell["column"] * wide
        strips.append(np.concatenate([picture[top : top + tall, left : left + wide] for picture in pictures], axis=1))
    whole = np.concatenate(strips)
    image = bpy.data.images.new("Contact sheet", whole.shape[1], whole.shape[0], alpha=False)
    pixels: Any = image.pixels
    pixels.foreach_set(whole[::-1].ravel())
    with atomic_file(path) as temporary:
        image.filepath_raw, image.file_format = str(temporary), "PNG"
        image.save()
    bpy.data.images.remove(image)


def _moments(scene: bpy.types.Scene, motions: list[Motion]) -> list[int]:
    """Return a scene frame in each of :data:`MOMENTS` equal spans, where the forearms of all figures are raised most."""
    fps = scene.render.fps / scene.render.fps_base
    rows = min(len(motion.directions) for motion in motions)
    raised = np.asarray(sum(motion.directions[:rows, (5, 8), 1].sum(1) * -1 for motion in motions))  # forearms, y is down
    spans = np.array_split(np.arange(rows), MOMENTS)
    return [1 + round(int(span[np.argmax(raised[span])]) * fps / motions[0].fps) for span in spans if len(span)]


def _pixels(file: Path) -> np.ndarray:
    """Read an image as ``(height, width, 4)``, top row first, without colour space conversion."""
    image: Any = bpy.data.images.load(str(file))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    shape = image.size[1], image.size[0], 4
    bpy.data.images.remove(image)
    return pixels.reshape(shape)[::-1]
