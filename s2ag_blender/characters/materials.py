"""Creates materials that look alike in Workbench, Eevee and Cycles: a Principled shader with the same viewport colour."""

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np

Colour = Sequence[float] | np.ndarray
"""Linear RGB (3,)."""


def plain(
    name: str, colour: Colour, roughness: float = 0.6, metallic: float = 0.0, specular: float = 0.5
) -> bpy.types.Material:
    """Create a material of one linear RGB colour; ``specular`` is the dielectric level of the Principled shader."""
    material, shader = _principled(name, roughness, metallic, specular)
    shader.inputs["Base Color"].default_value = (*colour, 1)
    material.diffuse_color = (*colour, 1)
    return material


def painted(
    name: str, image: bpy.types.Image, colour: Colour, roughness: float = 0.55, specular: float = 0.4
) -> bpy.types.Material:
    """Create a material with an image as base colour, and ``colour`` for viewports that show no images.

    The image node is the active one, from which Workbench takes its texture."""
    material, shader = _principled(name, roughness, 0.0, specular)
    tree: Any = material.node_tree
    nodes, links = tree.nodes, tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    texture.location = (-320, 240)
    links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    nodes.active = texture
    material.diffuse_color = (*colour, 1)
    return material


def image(name: str, colours: np.ndarray) -> bpy.types.Image:
    """Create a packed sRGB image from linear RGB ``colours`` (height, width, 3), bottom row first."""
    height, width, _ = colours.shape
    picture = bpy.data.images.new(name, width, height, alpha=False)
    encoded = np.where(colours <= 0.0031308, colours * 12.92, 1.055 * np.maximum(colours, 1e-6) ** (1 / 2.4) - 0.055)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = np.clip(encoded, 0, 1)
    pixel_array: Any = picture.pixels
    pixel_array.foreach_set(pixels.ravel())
    picture.pack()
    return picture


def _principled(name: str, roughness: float, metallic: float, specular: float) -> tuple[bpy.types.Material, Any]:
    """Create a material; return it and its Principled shader node."""
    material = bpy.data.materials.new(name)
    if not material.node_tree:  # since 5.0 every material has one
        material.use_nodes = True
    material.roughness, material.metallic = roughness, metallic
    tree: Any = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    shader.inputs["Specular IOR Level"].default_value = specular
    return material, shader
