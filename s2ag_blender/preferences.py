"""Where the engine runs: the Python interpreter that has torch."""

from pathlib import Path

import bpy

_FOLDER = Path(__file__).resolve().parents[1]


class S2AG_Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__.rpartition(".")[0]

    interpreter: bpy.props.StringProperty(
        name="Engine Python",
        description="Python interpreter in which s2ag's engine is installed; leave empty to find one",
        subtype="FILE_PATH",
    )

    def draw(self, context):
        self.layout.prop(self, "interpreter")
        column = self.layout.column(align=True)
        column.label(text="The engine runs beside Blender, never inside it. Once, in a terminal:")
        column.label(text="python -m venv s2ag-engine")
        column.label(text=f's2ag-engine/bin/pip install "{_FOLDER}[engine]"')
        column.label(text="Then choose that environment's python above.")


def interpreter(context) -> str | None:
    """The interpreter set by the user, or None to let the client find one."""
    addon = context.preferences.addons.get(S2AG_Preferences.bl_idname)
    path = bpy.path.abspath(addon.preferences.interpreter) if addon else ""
    return path or None
