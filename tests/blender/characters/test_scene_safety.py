"""A foreign .blend runs nothing and writes nothing but what was asked for, whatever it holds."""

import bpy
import pytest
from s2ag.s2ag_blender.characters import loading, mannequin, scene_safety
from s2ag.s2ag_blender.program import EventWriter
from s2ag.s2ag_blender.render import job as jobs


def writes(path):
    """Python that leaves a trace."""
    return f"open({str(path)!r}, 'w').close()"


def text(name, content):
    found = bpy.data.texts.new(name)
    found.write(content)
    return found


def file_output(scene, folder):
    """A compositor that writes to ``folder`` by itself."""
    if hasattr(scene, "compositing_node_group"):
        tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
    source, node = (tree.nodes.new(kind) for kind in ("CompositorNodeRLayers", "CompositorNodeOutputFile"))
    if hasattr(node, "directory"):
        node.directory = str(folder)
        node.file_output_items.new("RGBA", "Image")
    else:
        node.base_path = str(folder)
    tree.links.new(source.outputs[0], node.inputs[0])


@pytest.fixture
def armed(tmp_path):
    """A mannequin's file that would leave a trace in each of several ways, and the folder of the traces."""
    traces = tmp_path / "traces"
    traces.mkdir()
    scene = bpy.context.scene
    figure = mannequin.build().armature
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera, camera.location, camera.rotation_euler = camera, (0, -5, 1), (1.57, 0, 0)
    scene.render.engine, scene.cycles.samples, scene.cycles.shading_system = "CYCLES", 1, True
    scene.render.use_freestyle, style = True, scene.view_layers[0].freestyle_settings
    style.mode = "SCRIPT"
    module = style.modules.new()
    module.script = text("style.py", writes(traces / "freestyle"))
    text("start.py", writes(traces / "registered")).use_module = True
    driver = figure.driver_add("location", 2).driver
    driver.expression = f"{writes(traces / 'driver')} or 0"
    file_output(scene, traces / "compositor")
    mesh = bpy.data.meshes.new("Cloth")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    cloth = bpy.data.objects.new("Cloth", mesh)
    scene.collection.objects.link(cloth)
    cache = cloth.modifiers.new("Cloth", "CLOTH").point_cache
    for one in traces.iterdir():
        one.unlink()  # making the driver may have run it: this Python is allowed to
    path = tmp_path / "armed.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    cache.use_disk_cache = True  # wants a saved file
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return path, traces


def test_rendering_a_foreign_file_runs_and_writes_nothing_of_its_own(armed, tmp_path, wave):
    path, traces = armed
    before = {one.name for one in tmp_path.iterdir()}
    motion, out = tmp_path / "motion.npz", tmp_path / "out.png"
    wave(4).save(motion)
    content = {"motions": [str(motion)], "character": str(path), "outputs": [str(out)], "engine": "cycles", "samples": 1}
    told = jobs.perform(jobs.Job.of({**content, "resolution": [16, 16]}), EventWriter(lambda line: None))["warnings"]
    assert out.read_bytes()[:4] == b"\x89PNG"
    assert list(traces.iterdir()) == []
    assert {one.name for one in tmp_path.iterdir()} == before | {"motion.npz", "out.png"}
    for what in ("1 scripts of Freestyle", "1 file outputs", "1 programs in OSL", "1 caches on disk"):
        assert sum(sentence.startswith(what) for sentence in told) == 1, told


def test_a_saved_copy_still_holds_what_was_switched_off(armed, tmp_path):
    character, theirs = loading.load_character(str(armed[0]))
    assert theirs and len(character.disarmed) == 4
    (module,) = bpy.context.scene.view_layers[0].freestyle_settings.modules
    assert module.script.name == "style.py" and not module.use
    assert scene_safety.disarm() == []


def test_a_file_of_ones_own_is_left_as_it_is_and_far_libraries_are_told(tmp_path):
    figure = mannequin.build().armature
    (tmp_path / "far").mkdir()
    (tmp_path / "near").mkdir()
    bpy.data.libraries.write(str(tmp_path / "far" / "rock.blend"), {bpy.data.meshes.new("Rock")})
    figure["note"] = "mine"
    plain = tmp_path / "near" / "plain.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(plain))
    assert loading.load_character(str(plain))[0].disarmed == ()
    with bpy.data.libraries.load(str(tmp_path / "far" / "rock.blend"), link=True) as (_, wanted):
        wanted.meshes = ["Rock"]
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Rock", wanted.meshes[0]))
    bpy.ops.wm.save_as_mainfile(filepath=str(plain))
    (told,) = loading.load_character(str(plain))[0].disarmed
    assert "linked to 1 libraries outside its folder" in told
