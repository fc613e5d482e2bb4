"""Makes the small pictures of the shipped styles that menus show, ``core/assets/styles``: a figure from the front, the ways of
its left hand (orange) and its right one (blue) through the shipped recording, and its arms in a large gesture. In an
environment with the extras ``engine`` and ``dev`` (Pillow comes with matplotlib), from the root of a checkout::

    python docs/style_pictures.py
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from s2ag import Request, Session
from s2ag.core.model import checkpoint_metadata
from s2ag.core.motion import skeleton

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "core" / "assets" / "styles"
SIZE, FINER, COLOURS = 64, 4, 32
"""Pixels of a picture's side, times those it is drawn with, and its colours."""
METRE, MIDDLE, DROPPED, HEAD = 48.0, (32.0, 24.0), 0.25, 0.1
"""Pixels of a metre, where the neck's root lies, metres of the trunk below the spine joint, and of the head's radius."""
BODY, HANDS = (150, 150, 156, 255), ((255, 168, 64, 150), (96, 184, 255, 150))
LARGE = 90
"""Percentile of how high both hands are at which the arms are shown."""


def flat(points: np.ndarray) -> list[tuple[float, float]]:
    """Return where points ``(n, 3)`` in metres, y down, lie in the fine picture; the figure's left is on the right."""
    places = (points[:, :2] * [-METRE, METRE] + MIDDLE) * FINER
    return [(float(x), float(y)) for x, y in places]


def draw(directions: np.ndarray) -> Image.Image:
    """Return the picture of a performance ``(frames, 9, 3)``."""
    joints = skeleton.to_positions(directions)
    joints = joints - joints[:, [skeleton.EDGES[1][0]]]
    wrists = joints[:, [skeleton.EDGES[fore][1] for _, fore in skeleton.ARMS]]
    height = -wrists[..., 1].sum(1)
    posed = joints[np.abs(height - np.percentile(height, LARGE)).argmin()]
    image = Image.new("RGBA", (SIZE * FINER, SIZE * FINER))
    pen = ImageDraw.Draw(image, "RGBA")
    trunk = np.stack([posed[0] + [0, DROPPED, 0], posed[skeleton.EDGES[1][0]]])
    pen.line(flat(trunk), BODY, 9 * FINER)
    (x, y), radius = flat(posed[[skeleton.EDGES[1][0]]] + [[0, -0.2, 0]])[0], HEAD * METRE * FINER
    pen.ellipse((x - radius, y - radius, x + radius, y + radius), BODY)
    for arm, (upper, fore) in enumerate(skeleton.ARMS):
        (shoulder, elbow), wrist = skeleton.EDGES[upper], skeleton.EDGES[fore][1]
        pen.line(flat(posed[[skeleton.EDGES[1][0], shoulder, elbow, wrist]]), BODY, 4 * FINER, "curve")
        way = Image.new("RGBA", image.size)
        ImageDraw.Draw(way).line(flat(wrists[:, arm]), HANDS[arm], round(1.6 * FINER), "curve")
        image.alpha_composite(way)
    return image.resize((SIZE, SIZE), Image.Resampling.LANCZOS)


def main() -> None:
    """Draw a picture of each style."""
    session = Session()
    FOLDER.mkdir(exist_ok=True)
    for style in checkpoint_metadata.describe(checkpoint_metadata.locate(""))["speakers"]:
        takes = session.synthesize(Request(ROOT / "examples/hello.flac", style=style["name"], takes=3)).motions
        image = draw(np.concatenate([motion.directions for motion in takes]))
        image.quantize(COLOURS).save(FOLDER / f"{style['name']}.png", optimize=True)


if __name__ == "__main__":
    main()
