"""Materials that look alike in Workbench, Eevee and Cycles: a Principled shader and the same colour for the viewport."""

import bpy
import numpy as np


def plain(name: str, colour, roughness: float = 0.6, metallic: float = 0.0, specular: float = 0.5):
    """One linear RGB colour; ``specular`` is the dielectric level of the Principled shader."""
    material, shader = _principled(name, roughness, metallic, specular)
    shader.inputs["Base Color"].default_value = (*colour, 1)
    material.diffuse_color = (*colour, 1)
    return material


def painted(name: str, image: bpy.types.Image, colour, roughness: float = 0.55, specular: float = 0.4):
    """An image as base colour; its node is active, which is where Workbench looks. ``colour`` stands in where none is shown."""
    material, shader = _principled(name, roughness, 0.0, specular)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    texture.location = (-320, 240)
    links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    nodes.active = texture
    material.diffuse_color = (*colour, 1)
    return material


def image(name: str, colours: np.ndarray):
    """A packed sRGB image from linear RGB ``colours`` (height, width, 3), bottom row first."""
    height, width, _ = colours.shape
    picture = bpy.data.images.new(name, width, height, alpha=False)
    encoded = np.where(colours <= 0.0031308, colours * 12.92, 1.055 * np.maximum(colours, 1e-6) ** (1 / 2.4) - 0.055)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = np.clip(encoded, 0, 1)
    picture.pixels.foreach_set(pixels.ravel())
    picture.pack()
    return picture


def _principled(name, roughness, metallic, specular):
    material = bpy.data.materials.new(name)
    if not material.node_tree:  # since 5.0 every material has one
        material.use_nodes = True
    material.roughness, material.metallic = roughness, metallic
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    shader.inputs["Specular IOR Level"].default_value = specular
    return material, shader
