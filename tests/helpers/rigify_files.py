"""Builds Rigify's human and saves it: ``python rigify_files.py metarig.blend control.blend``.

A process of its own, because Blender's module before 5.0 hangs or crashes at exit once Rigify was on.
"""

import os
import subprocess
import sys
from pathlib import Path


def build(folder: Path) -> tuple[Path, Path]:
    """Files with the metarig and the control rig that Rigify generates of it."""
    files = folder / "metarig.blend", folder / "control.blend"
    result = subprocess.run([sys.executable, __file__, *map(str, files)], capture_output=True, text=True, timeout=300)
    assert all(file.is_file() for file in files), result.stdout[-2000:] + result.stderr[-2000:]
    return files


def main() -> None:
    import bpy  # first: it makes addon_utils importable
    import addon_utils  # isort: skip

    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("rigify", default_set=True)
    bpy.ops.object.armature_human_metarig_add()
    metarig = bpy.context.object
    bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])
    bpy.ops.pose.rigify_generate()
    bpy.data.objects.remove(metarig)
    bpy.ops.wm.save_as_mainfile(filepath=sys.argv[2])
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
