"""Makes README's pictures of the shipped recording: some seconds of its film, ``hello.webp``, and five moments, ``hello.png``.

In an environment with the extras ``blender`` and ``dev`` (Pillow comes with matplotlib), from the root of a checkout::

    python docs/moving_picture.py                     # films first, which takes a minute or two
    python docs/moving_picture.py film.mp4 0.3 10.6   # from a film that is there, and which seconds of it
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import av
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
FPS, SIDE, QUALITY, LARGEST = 12, 720, 66, 1_500_000
SECONDS = (0.3, 10.6)
"""From "I made this for you" to "needs both arms"."""
MOMENTS, SIZE = (1.0, 2.4, 5.1, 8.9, 9.4), (420, 420)
"""Seconds of the film that the gallery shows, and the size of each."""
CROP, SHOWN = (0.22, 0.04, 0.78, 0.60), (400, 400)
"""Left, top, right and bottom of what is shown of a square film, from the hips up, in shares of its side; and its size."""


def film(path: Path) -> None:
    """Film a person who says the shipped recording."""
    how = ["--character", "human", "--fps", str(FPS), "--resolution", f"{SIDE}x{SIDE}"]
    subprocess.run([sys.executable, "-m", "s2ag", "animate", ROOT / "examples/hello.flac", *how, "-o", path], check=True)


def pictures(path: Path) -> list[tuple[float, Image.Image]]:
    """Return the frames of a film with their seconds, as far as they are shown."""
    with av.open(str(path)) as opened:
        frames = [(float(frame.time or 0), frame.to_image()) for frame in opened.decode(video=0)]
    box = [round(share * frames[0][1].width) for share in CROP]
    return [(at, frame.crop(tuple(box))) for at, frame in frames]


def moments(frames: list[tuple[float, Image.Image]]) -> Image.Image:
    """Return a row of a film's moments."""
    row = Image.new("RGB", (len(MOMENTS) * SIZE[0], SIZE[1]))
    for number, moment in enumerate(MOMENTS):
        frame = next(frame for at, frame in frames if at >= moment)
        row.paste(frame.resize(SIZE, Image.Resampling.LANCZOS), (number * SIZE[0], 0))
    return row


def main(source: str = "", first: str = str(SECONDS[0]), last: str = str(SECONDS[1])) -> None:
    """Write both pictures, and say how large the moving one is."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(source or folder) / ("" if source else "hello.mp4")
        if not source:
            film(path)
        every = pictures(path)
    moments(every).save(ROOT / "docs" / "hello.png")
    frames = [frame.resize(SHOWN, Image.Resampling.LANCZOS) for at, frame in every if float(first) <= at < float(last)]
    out = ROOT / "docs" / "hello.webp"
    options = {"duration": 1000 // FPS, "loop": 0, "quality": QUALITY, "method": 4}
    frames[0].save(out, save_all=True, append_images=frames[1:], **options)
    size = out.stat().st_size
    print(f"{out}: {len(frames)} frames, {size} bytes")
    if size > LARGEST:
        sys.exit(f"{out} is larger than {LARGEST} bytes.")


if __name__ == "__main__":
    main(*sys.argv[1:])
