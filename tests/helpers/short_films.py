"""Films of half a second and more that a browser plays."""

import numpy as np
import pytest


def films(folder, conditions, excerpts, other=False):
    """Films ``folder/condition/excerpt.mp4``, of one tone and length or, with ``other``, of one for each excerpt."""
    for condition in conditions:
        (folder / condition).mkdir()
        for number, excerpt in enumerate(excerpts):
            own = {"pitch": 3.0 + 2 * number, "frames": 8 + 2 * number} if other else {}
            film(folder / condition / f"{excerpt}.mp4", **own)
    return folder


def film(path, pitch=5.0, frames=8):
    """Grey that brightens, at 15 frames a second, with a tone of ``16000 / (2 pi pitch)`` hertz."""
    av = pytest.importorskip("av")
    with av.open(str(path), "w") as container:
        video, sound = container.add_stream("libx264", rate=15), container.add_stream("aac", rate=16000)
        video.width, video.height, video.pix_fmt, sound.layout = 64, 48, "yuv420p", "mono"
        for number in range(frames):
            image = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 160 // frames * number, np.uint8), "rgb24")
            container.mux(video.encode(image))
        tone = (8000 * np.sin(np.arange(frames * 1000) / pitch)).astype(np.int16)[None]
        frame = av.AudioFrame.from_ndarray(tone, "s16", "mono")
        frame.sample_rate = 16000
        container.mux(sound.encode(frame))
        container.mux(video.encode(None))
        container.mux(sound.encode(None))
