"""Makes the pictures of Blender's window in README and docs: ``panel.png``, ``directing.png`` and ``bone-map.png``.

On a desktop with Blender 5.2, in any Python with Pillow, from a checkout, whose add-on is shown whatever is installed::

    python docs/window_pictures.py                          # S2AG_BLENDER names Blender where it is not in the path
    python docs/window_pictures.py --gpu-backend vulkan     # where the pictures come out black: options go on to Blender

It opens a window without the user's settings and runs itself in it: presses *Try It*, stops the playback, comes closer, and
takes a picture of each panel at a moment of the take. The window closes by itself; then the pictures are cut and written.
"""

import math
import os
import runpy
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

bpy: Any = sys.modules.get("bpy")
"""Blender's module in the window; None in the Python that opens it."""
ROOT = Path(__file__).resolve().parents[1]


class Picture(NamedTuple):
    panel: str
    """The panel that is open, below the main one."""
    frame: int
    height: int
    """Pixels from the window's top, to where a line of the panel ends."""
    at_end: bool = False
    """Whether the sidebar is scrolled to its end."""


WINDOW, LARGEST = (1000, 810), 60_000
"""Pixels of the window, such that its top cuts no line of a panel that is scrolled, and bytes of a picture."""
PICTURES = {
    "panel": Picture("S2AG_PT_takes", 16, 778),
    "directing": Picture("S2AG_PT_directing", 212, WINDOW[1], True),
    "bone-map": Picture("S2AG_PT_bone_map", 290, WINDOW[1], True),
}
TURNS = 20
"""Turns of the mouse wheel that scroll the sidebar to its end."""
DRAWN = 1.5
"""Seconds in which a slow computer draws the window."""
TURN, CLOSER, LOWER = -16.0, 0.78, 0.03
"""Degrees of the view about the person, to see the face from the front; what is left of the distance; how much lower it looks,
in heights of the window. *Try It* shows the person smaller."""


def view() -> dict[str, Any]:
    """Return the window, its largest viewport and that one's main region, as operators want them."""
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda one: (one.type == "VIEW_3D", one.width * one.height))
    return {"window": window, "area": area, "region": region(area, "WINDOW")}


def region(area: Any, kind: str) -> Any:
    return next(one for one in area.regions if one.type == kind)


def press(operator: Callable, *arguments: str, kind: str = "WINDOW", **options: Any) -> None:
    """Run an operator as if the mouse were over a region of the viewport."""
    where = view()
    with bpy.context.temp_override(**{**where, "region": region(where["area"], kind)}):
        operator(*arguments, **options)


def open_only(name: str) -> None:
    """Close all panels below the main one but the one whose class is called ``name``.

    Scripts cannot open a panel that was drawn, so each is registered again under a new name, in the state it starts with."""
    from s2ag.s2ag_blender.registration import CLASSES

    panels = [cls for cls in CLASSES if hasattr(cls, "bl_parent_id")]
    for cls in reversed(panels):
        bpy.utils.unregister_class(cls)
    names = {getattr(cls, "bl_idname", cls.__name__): f"{cls.__name__}_{name}" for cls in panels}
    for cls, new in zip(panels, names.values(), strict=True):
        cls.bl_idname = new
        cls.bl_parent_id = names.get(cls.bl_parent_id, cls.bl_parent_id)
        cls.bl_options = set() if cls.__name__ == name else {"DEFAULT_CLOSED"}
        bpy.utils.register_class(cls)


def come_closer() -> None:
    """Show the person larger, from the front, in the middle of what the sidebar leaves free."""
    from bpy_extras.view3d_utils import region_2d_to_location_3d
    from mathutils import Quaternion

    area, main = view()["area"], view()["region"]
    look = area.spaces.active.region_3d
    look.view_rotation = Quaternion((0, 0, 1), math.radians(TURN)) @ look.view_rotation
    look.view_distance *= CLOSER
    look.update()
    middle = (main.width + region(area, "UI").width) / 2, main.height * (0.5 - LOWER)
    look.view_location = region_2d_to_location_3d(main, look, middle, look.view_location)


def steps(folder: Path) -> Iterator[float]:
    """Take the pictures; yield the seconds to wait before each next step."""
    runpy.run_path(str(ROOT / "core" / "start.py"))["import_package"]().register()
    from s2ag.s2ag_blender.takes import session

    press(bpy.ops.screen.screen_full_area, use_hide_panels=True)
    yield DRAWN
    press(bpy.ops.s2ag.show_panel)
    yield DRAWN
    press(bpy.ops.s2ag.try_it, "INVOKE_DEFAULT")
    yield DRAWN
    while session.RUNS:
        yield DRAWN
    press(bpy.ops.screen.animation_cancel, restore_frame=False)
    come_closer()
    for name, picture in PICTURES.items():
        open_only(picture.panel)
        bpy.context.scene.frame_set(picture.frame)
        yield DRAWN
        for _ in range(TURNS * picture.at_end):
            press(bpy.ops.view2d.scroll_down, kind="UI")
        yield DRAWN
        press(bpy.ops.screen.screenshot_area, filepath=str(folder / f"{name}.png"))
    press(bpy.ops.wm.quit_blender)


def in_window(folder: Path) -> None:
    """Take the steps while Blender draws; an error ends it."""
    todo = steps(folder)

    def step() -> float | None:
        try:
            return next(todo, None)
        except Exception:
            traceback.print_exc()
            os._exit(1)

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(step, first_interval=DRAWN)


def few_colours(image: Any) -> Any:
    """Return an image with 256 colours, which makes small files: half of them by how often they are, for smooth shades, half
    by how they differ, for lips and eyes."""
    from PIL import Image  # which Blender's own Python may lack

    ways = Image.Quantize.MEDIANCUT, Image.Quantize.MAXCOVERAGE
    palette = Image.new("P", (1, 1))
    palette.putpalette([value for way in ways for value in image.quantize(128, way, kmeans=1).getpalette()[:384]])
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def main() -> None:
    """Open the window, and write what it showed, cut."""
    from PIL import Image

    blender, size = os.environ.get("S2AG_BLENDER", "blender"), map(str, (0, 0, *WINDOW))
    with tempfile.TemporaryDirectory() as folder:
        options = ["--factory-startup", "-p", *size, *sys.argv[1:], "--python", str(Path(__file__).resolve()), "--", folder]
        subprocess.run([blender, *options], check=True)
        for name, picture in PICTURES.items():
            shown = Image.open(Path(folder) / f"{name}.png").convert("RGB")
            if shown.size != WINDOW or shown.getbbox() is None:
                sys.exit(f"{name} is black or not of {WINDOW} pixels: try --gpu-backend vulkan, or a larger screen.")
            out = ROOT / "docs" / f"{name}.png"
            few_colours(shown.crop((0, 0, WINDOW[0], picture.height))).save(out, optimize=True)
            print(f"{out}: {out.stat().st_size} bytes")
            if out.stat().st_size > LARGEST:
                sys.exit(f"{out} is larger than {LARGEST} bytes.")


if __name__ == "__main__":
    main() if bpy is None else in_window(Path(sys.argv[-1]))
