"""What a user does and sees: undo steps, curves of an action, poses, and a sheet to draw panels on."""

import time

import bpy
import numpy as np
from s2ag.rigs import slices
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.keys import keyframes
from s2ag.s2ag_blender.takes import generate, preview, take_list


def press(operator, **options):
    """Run an operator as a button does, with its own undo step."""
    return operator("EXEC_DEFAULT", True, **options)


def lay(armature, *motions, **settings):
    """Finish a run with these motions, after these settings are made; returns its actions."""
    for name, value in settings.items():
        setattr(armature.s2ag, name, value)
    return generate.finish(generate.plan(bpy.context, armature), {"motions": list(motions)}).actions


def take_of(armature, audio, **settings):
    """Press Generate for a recording, after these settings are made; returns the take's action."""
    for name, value in {"audio": str(audio), **settings}.items():
        setattr(armature.s2ag, name, value)
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    return now(armature)


def now(armature=None):
    """The action of the take that a character shows; of the file's mannequin if none is named."""
    return take_list.active(armature or bpy.data.objects["Mannequin"]).action


def settle(seconds=60.0):
    """Run the preview's timer until it has nothing left to do."""
    began = time.monotonic()
    while preview.tick() is not None:
        assert time.monotonic() - began < seconds, "no draft"
        time.sleep(0.002)


def curves(action):
    """``{(path, index): (keys, 2)}`` of all curves of an action."""
    found = {}
    for curve in compat.curves(action):
        points = np.empty(len(curve.keyframe_points) * 2)
        curve.keyframe_points.foreach_get("co", points)
        found[curve.data_path, curve.array_index] = points.reshape(-1, 2)
    return found


def same_curves(one, other):
    """Whether two actions have exactly the same keys."""
    first, second = (found if isinstance(found, dict) else curves(found) for found in (one, other))
    return first.keys() == second.keys() and all(np.array_equal(first[key], second[key]) for key in first)


def pose(armature, frame):
    """Posed matrices ``{bone: (4, 4)}`` in armature space on a frame."""
    bpy.context.scene.frame_set(frame)
    posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return {bone.name: np.array(bone.matrix) for bone in posed.pose.bones}


def apart(one, other):
    """Largest angle in degrees between the bones of two poses."""
    worst = 0.0
    for name in one:
        turn = one[name][:3, :3] @ np.linalg.inv(other[name][:3, :3])
        # of the distance, because an arc cosine near one makes 0.03 degrees of float32's last bit
        worst = max(worst, np.degrees(2 * np.arcsin(min(np.linalg.norm(turn - np.eye(3)) / np.sqrt(8), 1))))
    return worst


def animate(armature, bones, frames=(1, 40), turn=0.4, name="walk"):
    """A plain action of the user's: each bone turns from rest about its own x; returns the action, which is active."""
    rotations = {}
    for bone in bones:
        half = np.linspace(0, turn, len(frames)) / 2
        rotations[bone] = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], -1)
    action, slot = slices.run_to_end(keyframes.write_action(name, armature, rotations, np.array(frames)))
    compat.assign_action(armature, action, slot)
    return action


def overridden(armature, folder):
    """The character linked from a file into an empty one, as a library override; its armature is active."""
    library = str(folder / "library.blend")
    collection = bpy.data.collections.new("Figure")
    bpy.context.scene.collection.children.link(collection)
    for item in [armature, *armature.children]:
        collection.objects.link(item)
    bpy.data.libraries.write(library, {collection}, fake_user=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.collections = ["Figure"]
    bpy.context.scene.collection.children.link(wanted.collections[0])
    wanted.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, do_fully_editable=True)
    override = next(item for item in bpy.data.objects if item.override_library and item.type == "ARMATURE")
    bpy.context.view_layer.objects.active = override
    return override


def cut_off(strip, left, right):
    """Hide so many frames at either end of a strip."""
    if hasattr(strip, "left_handle"):
        strip.left_handle, strip.right_handle = strip.left_handle + left, strip.right_handle - right
    else:
        strip.frame_offset_start, strip.frame_offset_end = left, right


class Sheet:
    """A layout that notes what is drawn on it; properties and operators that do not exist cannot be drawn."""

    def __init__(self, drawn=None, above=()):
        self.drawn = [] if drawn is None else drawn
        self.above, self.active, self.enabled = above, True, True
        self.use_property_split = self.use_property_decorate = self.alert = False
        self.scale_y = 1.0

    def column(self, **_):
        return Sheet(self.drawn, (*self.above, self))

    row = box = split = column

    def panel(self, name, default_closed=False):
        return self.column(), self.column()

    def prop(self, settings, name, text=None, **_):
        assert name in settings.bl_rna.properties, name
        getattr(settings, name)
        self.drawn.append((name, self))

    def prop_search(self, settings, name, *_, **__):
        self.prop(settings, name)

    def label(self, text="", icon="NONE", translate=True):
        self.drawn.append((text, self))

    def operator(self, name, **_):
        group, _, verb = name.partition(".")
        kind = getattr(getattr(bpy.ops, group), verb).get_rna_type()
        self.drawn.append((name, self))
        return type("Options", (), dict.fromkeys(kind.properties.keys()))()

    def progress(self, factor=0.0, text="", **_):
        self.drawn.append((text, self))

    def template_list(self, kind, name, data, prop, active_data, active, **_):
        self.drawn.append((kind, self))
        for number, item in enumerate(getattr(data, prop)):
            getattr(bpy.types, kind).draw_item(None, bpy.context, self, data, item, 0, active_data, active, number)

    def separator(self, **_):
        pass

    def menu(self, name, **_):
        """Menus are drawn where they open."""
        self.drawn.append((name, self))
        getattr(bpy.types, name).draw(type("Stand", (), {"layout": self})(), bpy.context)

    def operator_menu_enum(self, name, prop, **_):
        options = self.operator(name)
        assert prop in options.__class__.__dict__, prop
        return options

    def popover(self, panel, **_):
        self.drawn.append((panel, self))


def drawn(*panels):
    """What panels show now: ``{property, operator or text: whether it is active}``; all of the extension's if none is named."""
    from s2ag.s2ag_blender import registration
    from s2ag.s2ag_blender.ui import panel, subpanels

    every = [panel.S2AG_PT_gestures, *[one for one in registration.classes_of(subpanels) if issubclass(one, bpy.types.Panel)]]
    sheet = Sheet()
    for cls in panels or every:
        if not hasattr(cls, "poll") or cls.poll(bpy.context):
            stand_in = type("Stand", (), {"layout": sheet, "draw_settings": getattr(cls, "draw_settings", None)})()
            if hasattr(cls, "draw_header"):
                cls.draw_header(stand_in, bpy.context)
            cls.draw(stand_in, bpy.context)
    return active(sheet)


def active(sheet):
    """What is drawn on a sheet, in its order: whether it is active."""
    return {what: all(layout.active for layout in (*where.above, where)) for what, where in sheet.drawn}
