"""Reports Blender's version and whether it renders without a display. Run by ``s2ag doctor``."""

import json
import sys
import tempfile
from pathlib import Path


def main(arguments: list[str]) -> int:
    """Print one ``result`` event with ``blender`` (version) and ``renders`` (whether a small Workbench frame was written)."""
    import bpy

    from .datablocks import current_context

    print(json.dumps({"event": "progress", "stage": "version", "value": 0, "blender": bpy.app.version_string}), flush=True)
    render = current_context().scene.render
    render.engine = "BLENDER_WORKBENCH"  # pyright: ignore[reportAttributeAccessIssue]
    render.resolution_x = render.resolution_y = 16
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        render.filepath = str(Path(folder) / "probe.png")
        bpy.ops.render.render(write_still=True)
        renders = Path(render.filepath).is_file()
    print(json.dumps({"event": "result", "blender": bpy.app.version_string, "renders": renders}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
