"""Films of images whose folder and name look like something else."""

from fractions import Fraction

import pytest

av = pytest.importorskip("av")

import numpy as np  # noqa: E402
from s2ag.core.batch import encode  # noqa: E402


@pytest.mark.parametrize("name", ["50% {x}", "12:30", "http:a"])
def test_a_path_is_a_path(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    images = tmp_path / name
    images.mkdir()
    for number in range(3, 6):
        coder = av.CodecContext.create("png", "w")
        coder.width, coder.height, coder.pix_fmt, coder.time_base = 32, 16, "rgb24", Fraction(1)
        picture = av.VideoFrame.from_ndarray(np.full((16, 32, 3), 40 * number, np.uint8))
        packets = [*coder.encode(picture), *coder.encode(None)]
        (images / f"{number:06d}.png").write_bytes(b"".join(map(bytes, packets)))
    film = tmp_path / f"{name}.mp4"
    encode.film(images, 3, 3, 10.0, [], film)
    with av.open(f"file:{film}") as source:
        assert [picture.width for picture in source.decode(video=0)] == [32, 32, 32]
