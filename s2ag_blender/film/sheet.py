"""Many takes in one picture: light figures in a grid, rendered at once with Workbench.

``start.py -- s2ag_blender.film.sheet JOB.json`` makes it.

The job is a JSON object: ``cells``, each with ``motion`` (``.npz``), ``row``, ``column`` and ``label`` (two lines of text);
``audio`` or null, ``fps``, and ``outputs``: ``.mp4`` for a film, ``.png`` for a contact sheet of stills. Events and exit status
are those of :mod:`job`.
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...core import json_text
from ...core.errors import UsageError
from ...core.files import check_output, whole_file
from ...core.motion.motion import Motion
from .. import program
from ..cast import mannequin, materials
from ..datablocks import ArmatureObject
from ..keys.apply import apply_motion
from . import render, stage
from .sound import add_sound

WIDTH, HEIGHT = 1.56, 1.36
"""Metres of a cell: arms held wide, and from the hips to above the head with the label below."""
LABEL = 0.24
"""Metres of a cell's foot that its label has."""
CELL = 320
"""Pixels of a cell's width, in sheets of few columns."""
WIDEST = 1920
MOMENTS = 6
"""Stills of every cell on a contact sheet."""
_DETAIL = 0.25
"""Share of the mannequin's faces that a figure has."""
_FLOOR = 0.80
"""Height at which a figure is cut off, metres."""
_TURN = np.radians(14)
"""Figures are seen a little from the side, which shows how far forward a hand is."""
_GREY, _DARK, _PAPER = (0.30, 0.335, 0.36), (0.02, 0.022, 0.025), (0.75, 0.77, 0.78)


def main(arguments: list[str]) -> int:
    """Run the sheet file that ``arguments`` names; returns the exit status."""
    return program.run(arguments, lambda path, voice: perform(_read(path), voice))


def perform(content: dict, voice: program.Voice) -> dict:
    """Make the sheet in this Blender, whose open file is lost; gives the ``result`` event's content. Raises S2agError."""
    outputs = [check_output(path) for path in content["outputs"]]
    motions = [Motion.load(cell["motion"]) for cell in content["cells"]]
    with voice.stage("figures"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
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
                # Smoothing edges takes twice as long as all else in software.
                render.film(scene, path, render.Look(samples=1), lambda share, name=name: voice.progress(name, share))
            else:
                _contact_sheet(scene, path, content["cells"], motions)
    return {"outputs": content["outputs"], "seconds": voice.seconds}


def _read(path: str) -> dict:
    try:
        content = json_text.read(path)
        for key in ("cells", "audio", "fps", "outputs"):
            content[key]
        return content
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{path} is not a sheet: {error!r}", "Let s2ag sample write it.") from error


def _fill(scene: bpy.types.Scene, cells: list[dict], motions: list[Motion]) -> None:
    """Figures with their gestures, panels, labels, and the camera that sees them all."""
    first = _Figure(scene)
    figures = [first] + [first.again(scene) for _ in cells[1:]]
    panels = [materials.plain(f"Panel {shade}", np.array(_GREY) * shade, 1.0) for shade in (0.85, 1.0)]
    ink = materials.plain("Ink", _DARK, 1.0)
    for cell, figure, motion in zip(cells, figures, motions, strict=True):
        corner = np.array([cell["column"] * WIDTH, 0.0, -cell["row"] * HEIGHT])
        _panel(scene, corner, panels[(cell["row"] + cell["column"]) % 2])
        for line, text in enumerate(cell["label"]):
            _text(scene, text, corner + [0.05, 0, 0.135 - 0.095 * line], 0.095, ink)
        figure.place(corner + [WIDTH / 2, 0, LABEL - _FLOOR])
        apply_motion(figure.armature, motion, 1, scene=scene, report=lambda warning: None)
    columns, rows = (1 + max(cell[part] for cell in cells) for part in ("column", "row"))
    _camera(scene, columns, rows)


class _Figure:
    """The mannequin from the hips up, each bone with the part of the body that belongs to it: no skinning, so it is fast."""

    def __init__(self, scene: bpy.types.Scene, parts: list | None = None):
        if parts is None:
            whole = mannequin.build()
            self.armature, (body,) = whole.armature, whole.meshes
            self.parts = _split(body, self.armature)
            bpy.data.objects.remove(body)
        else:
            self.armature = bpy.data.objects.new("Figure", self._data)
            scene.collection.objects.link(self.armature)
            self.parts = parts
        for bone, mesh in self.parts:
            part = bpy.data.objects.new(f"{self.armature.name} {bone}", mesh)
            scene.collection.objects.link(part)
            part.parent, part.parent_type, part.parent_bone = self.armature, "BONE", bone

    def again(self, scene: bpy.types.Scene) -> "_Figure":
        """Another figure of the same meshes and bones."""
        other = _Figure.__new__(_Figure)
        other._data = self.armature.data
        other.__init__(scene, self.parts)
        return other

    def place(self, spot) -> None:
        """Let it stand at ``spot`` (3,), turned a little."""
        self.armature.matrix_world = Matrix.Translation(spot) @ Matrix.Rotation(_TURN, 4, "Z")


def _split(body, armature: ArmatureObject) -> list[tuple[str, bpy.types.Mesh]]:
    """The part of a rigidly weighted mesh that each bone above the hips moves, in the space of that bone's tail."""
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
        parts.append((bone.name, _lighter(part)))
    return parts


def _lighter(mesh: bpy.types.Mesh) -> bpy.types.Mesh:
    """The same shape of fewer faces: drawn small, and often, in software."""
    item = bpy.data.objects.new("Part", mesh)
    bpy.context.scene.collection.objects.link(item)
    item.modifiers.new("Decimate", "DECIMATE").ratio = _DETAIL
    bpy.context.view_layer.update()
    light = bpy.data.meshes.new_from_object(item.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(item)
    bpy.data.meshes.remove(mesh)
    light.shade_smooth()
    return light


def _panel(scene: bpy.types.Scene, corner, material: bpy.types.Material) -> None:
    """The wall behind a figure and the strip for its label before the figure's waist."""
    wall = [(0, 1, 0), (WIDTH, 1, 0), (WIDTH, 1, HEIGHT), (0, 1, HEIGHT)]
    _plane(scene, corner, wall, material)
    strip = bpy.data.materials.get("Paper") or materials.plain("Paper", _PAPER, 1.0)
    _plane(scene, corner, [(0, -1, 0), (WIDTH, -1, 0), (WIDTH, -1, LABEL), (0, -1, LABEL)], strip)


def _plane(scene: bpy.types.Scene, corner, points, material: bpy.types.Material) -> None:
    mesh = bpy.data.meshes.new("Panel")
    mesh.from_pydata((np.array(points) + corner).tolist(), [], [(0, 1, 2, 3)])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Panel", mesh))


def _text(scene: bpy.types.Scene, text: str, spot, size: float, material: bpy.types.Material) -> None:
    """One line of text that faces the camera, made narrower where a cell is too small for it."""
    curve = bpy.data.curves.new("Label", "FONT")
    curve.body, curve.size = text, size
    curve.materials.append(material)
    item = bpy.data.objects.new("Label", curve)
    scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    room = WIDTH - 0.1
    squeeze = min(1.0, room / max(item.dimensions.x, 1e-6))
    upright = Matrix.Rotation(np.pi / 2, 4, "X") @ Matrix.Scale(squeeze, 4, (1, 0, 0))
    item.matrix_world = Matrix.Translation(np.array(spot) + [0, -1.1, 0]) @ upright


def _camera(scene: bpy.types.Scene, columns: int, rows: int) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.clip_end = "ORTHO", 100
    item = bpy.data.objects.new("Camera", camera)
    scene.collection.objects.link(item)
    scene.camera = item
    wide, tall = columns * WIDTH, rows * HEIGHT
    camera.ortho_scale = max(wide, tall)
    item.matrix_world = Matrix.Translation((wide / 2, -20, HEIGHT - tall / 2)) @ Matrix.Rotation(np.pi / 2, 4, "X")
    pixels = min(CELL, WIDEST // columns) / WIDTH
    scene.render.resolution_x, scene.render.resolution_y = (round(size * pixels / 2) * 2 for size in (wide, tall))
    scene.view_settings.view_transform = "Standard"
    stage.workbench(scene)


def _contact_sheet(scene: bpy.types.Scene, path: Path, cells: list[dict], motions: list[Motion]) -> None:
    """A row for every cell with its stills, :data:`MOMENTS` of them, at moments when most of the figures gesture."""
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
    image.pixels.foreach_set(whole[::-1].ravel())
    with whole_file(path) as temporary:
        image.filepath_raw, image.file_format = str(temporary), "PNG"
        image.save()
    bpy.data.images.remove(image)


def _moments(scene: bpy.types.Scene, motions: list[Motion]) -> list[int]:
    """Scene frames, one in each of :data:`MOMENTS` equal spans: where the figures' hands are farthest from hanging down."""
    fps = scene.render.fps / scene.render.fps_base
    rows = min(len(motion.directions) for motion in motions)
    raised = sum(motion.directions[:rows, (5, 8), 1].sum(1) * -1 for motion in motions)  # forearms, y is down
    spans = np.array_split(np.arange(rows), MOMENTS)
    return [1 + round(int(span[np.argmax(raised[span])]) * fps / motions[0].fps) for span in spans if len(span)]


def _pixels(file: Path) -> np.ndarray:
    """A picture ``(height, width, 4)``, top row first, as stored (no change of colour space)."""
    image = bpy.data.images.load(str(file))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    shape = image.size[1], image.size[0], 4
    bpy.data.images.remove(image)
    return pixels.reshape(shape)[::-1]
