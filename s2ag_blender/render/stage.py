"""Sets up camera, lights and backdrop for gesturing upper bodies."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..characters import materials
from ..characters.character import Character
from ..datablocks import current_context
from ..rig import reading

LENS = 60.0
"""Focal length in millimetres on a 36 mm sensor: long enough not to enlarge hands that reach forward."""

_LOW_EDGE, _HIGH_EDGE, _FRAME_WIDTH = 0.40, 1.09, 1.03
"""Lower edge, upper edge and width of the frame in body heights: mid-thigh, above a raised hand, both arms held out."""

_BACKDROP = (0.30, 0.335, 0.36)
_STUDIO = "paint.sl"
"""Blender's studio light that suits skin best."""


@dataclass(frozen=True)
class Place:
    """Where characters stand: ``ground`` (3,) between the feet, ``height``, and unit vector ``facing`` (3,), in metres.

    ``breadth`` is the distance between the outermost of several characters."""

    ground: np.ndarray
    height: float
    facing: np.ndarray
    breadth: float = 0.0

    @property
    def left(self) -> np.ndarray:
        """Return the unit vector (3,) to the character's left."""
        return np.cross([0.0, 0.0, 1.0], self.facing)

    @classmethod
    def of_all(cls, characters: Sequence[Character]) -> "Place":
        """Measure a group of characters, facing their mean direction."""
        places = [cls.of(character) for character in characters]
        facing = np.sum([place.facing for place in places], axis=0)
        length = np.linalg.norm(facing)
        facing = facing / length if length > 1e-6 else places[0].facing
        spots = np.array([place.ground for place in places])
        along = spots @ np.cross([0.0, 0.0, 1.0], facing)
        centre = (spots[np.argmin(along)] + spots[np.argmax(along)]) / 2
        return cls(centre, max(place.height for place in places), facing, float(np.ptp(along)))

    @classmethod
    def of(cls, character: Character) -> "Place":
        """Measure a character by its meshes (else its bones) and its mapped arms."""
        current_context().view_layer.update()
        armature = character.armature
        frame = np.array(armature.matrix_world)
        joints = {bone.name: frame[:3, :3] @ bone.head_local + frame[:3, 3] for bone in armature.data.bones}
        corners = [np.array(mesh.matrix_world) @ [*corner, 1] for mesh in character.meshes for corner in mesh.bound_box]
        every = np.array(corners)[:, :3] if corners else np.array(list(joints.values()))
        low, high = every.min(0), every.max(0)
        chains = reading.resolve_mapping(armature, reading.read(armature), character.mapping).chains
        left, right = (joints[chains[f"{side}_upper_arm"][0]] for side in ("left", "right"))
        facing = np.cross(left - right, [0.0, 0.0, 1.0])
        length = np.linalg.norm(facing)
        facing = facing / length if length > 1e-6 else np.array([0.0, -1.0, 0.0])
        middle = (left + right) / 2
        return cls(np.array([middle[0], middle[1], low[2]]), float(high[2] - low[2]), facing)


def set_up_scene(
    scene: bpy.types.Scene, characters: Sequence[Character], resolution: tuple[int, int] = (960, 540), backdrop: bool = True
) -> None:
    """Set up a scene of our own: camera, three lights, backdrop, world, colours and Workbench settings."""
    place = Place.of_all(characters)
    render = scene.render
    render.resolution_x, render.resolution_y = resolution
    render.resolution_percentage = 100
    collection = bpy.data.collections.new("Stage")
    scene.collection.children.link(collection)
    _camera(scene, place, collection)
    _lights(place, collection)
    if backdrop:
        _backdrop(place, collection)
    scene.world = scene.world or _world()
    set_standard_view(scene)
    workbench(scene)


def set_standard_view(scene: Any) -> None:
    """Set the view transform to Standard, which keeps colours as they are."""
    scene.view_settings.view_transform = "Standard"


def add_missing_camera_and_light(scene: bpy.types.Scene, characters: Sequence[Character]) -> None:
    """Add a camera, and light, to a scene of the user's that lacks them; change nothing else."""
    objects = scene.objects
    bare = not any(item.type == "LIGHT" for item in objects) and scene.world is None
    if scene.camera is not None and not bare:
        return
    place = Place.of_all(characters)
    collection = bpy.data.collections.new("Stage")
    scene.collection.children.link(collection)
    if scene.camera is None:
        _camera(scene, place, collection)
    if bare:
        _lights(place, collection)
        scene.world = _world()


def _camera(scene: bpy.types.Scene, place: Place, collection: bpy.types.Collection) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.lens = LENS
    item = bpy.data.objects.new("Camera", camera)
    collection.objects.link(item)
    scene.camera = item
    width, height = scene.render.resolution_x, scene.render.resolution_y
    tall, wide = (_HIGH_EDGE - _LOW_EDGE) * place.height, _FRAME_WIDTH * place.height + place.breadth
    film = camera.sensor_width / LENS  # the longer side of the frame at one metre
    per_metre = np.array([film * width, film * height]) / max(width, height)
    distance = max(wide / per_metre[0], tall / per_metre[1])
    shown = distance * per_metre[1]  # more than needed where the width decides; the excess is below the lower edge
    aim = place.ground + [0, 0, max(_HIGH_EDGE * place.height - shown / 2, 0.45 * shown)]
    aside = np.radians(9)
    away = np.cos(aside) * place.facing + np.sin(aside) * place.left
    item.matrix_world = _look_at(aim + distance * away + [0, 0, 0.06 * place.height], aim)
    camera.clip_end = max(100.0, 4 * distance)


def _lights(place: Place, collection: bpy.types.Collection) -> None:
    """Add area lights sized to the character: key from the front left, fill from the right, rim from behind."""
    chest = place.ground + [0, 0, 0.78 * place.height]
    size = place.height + 0.5 * place.breadth
    for name, ahead, aside, up, power, reach, colour in (
        ("Key", 1.3, 1.0, 0.75, 34, 0.9, (1.0, 0.96, 0.90)),
        ("Fill", 1.4, -1.3, 0.25, 13, 1.3, (0.88, 0.94, 1.0)),
        ("Rim", -1.0, -0.7, 0.9, 36, 0.6, (1.0, 0.98, 0.95)),
    ):
        light: Any = bpy.data.lights.new(name, "AREA")
        light.energy, light.size, light.color = power * size**2, reach * size, colour
        item = bpy.data.objects.new(name, light)
        collection.objects.link(item)
        spot = chest + size * (ahead * place.facing + aside * place.left + [0, 0, up])
        item.matrix_world = _look_at(spot, chest)


def _backdrop(place: Place, collection: bpy.types.Collection) -> None:
    """Add a floor that bends up into a wall behind the character."""
    size = place.height + 0.5 * place.breadth
    angle = np.linspace(0, np.pi / 2, 13)
    bend = 0.9 * size
    behind = np.concatenate([[-4 * size], 1.3 * size + bend * np.sin(angle), [1.3 * size + bend]])
    up = np.concatenate([[0], bend * (1 - np.cos(angle)), [5 * size]])
    profile = place.ground - np.outer(behind, place.facing) + np.outer(up, [0, 0, 1])
    points = np.concatenate([profile - 6 * size * place.left, profile + 6 * size * place.left])
    count = len(profile)
    faces = [(i, i + 1, count + i + 1, count + i) for i in range(count - 1)]
    mesh = bpy.data.meshes.new("Backdrop")
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.shade_smooth()
    mesh.materials.append(materials.plain("Backdrop", _BACKDROP, 0.95, specular=0.1))
    collection.objects.link(bpy.data.objects.new("Backdrop", mesh))


def _world() -> bpy.types.World:
    world = bpy.data.worlds.new("World")
    world.color = (0.30, 0.33, 0.35)
    if not world.node_tree:
        world.use_nodes = True
    tree: Any = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (*world.color, 1)
    background.inputs["Strength"].default_value = 0.8
    return world


def workbench(scene: bpy.types.Scene) -> None:
    """Set Workbench to a bright studio light and textures, without cavity and shadow, which are slow without a GPU."""
    display: Any = scene.display
    light_brightly(display.shading)


def light_brightly(shading: Any) -> None:
    """Set a bright studio light and textures on the shading of Workbench or of a viewport."""
    shading.light, shading.color_type = "STUDIO", "TEXTURE"
    if any(light.name == _STUDIO for light in current_context().preferences.studio_lights):
        shading.studio_light = _STUDIO
    shading.show_cavity = shading.show_shadows = False
    shading.show_specular_highlight = True


def _look_at(from_point: np.ndarray, at_point: np.ndarray) -> Matrix:
    """Return the world matrix of a camera or light at one point that looks at another, upright."""
    origin = Vector(from_point.tolist())
    way = Vector(at_point.tolist()) - origin
    return Matrix.LocRotScale(origin, way.to_track_quat("-Z", "Y"), None)
