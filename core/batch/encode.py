"""Numbered images and recordings to a film: H.264 and AAC, muxed by FFmpeg's libraries in the package ``av``."""

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np

from ..errors import AudioUnreadable, OutputUnwritable
from ..sound import audio

PATTERN = "%06d.png"
"""Names of the images, for FFmpeg; Blender writes the same."""
_RATE = 48000
_BLOCK = 1024
"""Samples an AAC frame holds."""


def film(
    images: Path,
    first: int,
    count: int,
    fps: float,
    sounds: Sequence[tuple[str, float]],
    path: Path,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Write ``path`` (``.mp4``) from ``count`` images of the folder ``images``, numbered from ``first``, at ``fps``.

    ``sounds`` are recordings and the seconds at which they begin; several are mixed. Raises :class:`OutputUnwritable` where
    an image is missing and :class:`AudioUnreadable`.
    """
    import av

    rate = Fraction(fps).limit_denominator(1001)
    try:
        with av.open(audio.local(path), "w", options={"movflags": "faststart"}) as out:
            video = voice = None
            mixed = _mixed(sounds, int(count / rate * _RATE)) if sounds else iter(())
            for index, picture in enumerate(_pictures(images, first, count, rate)):
                if video is None:
                    video = _video_stream(out, picture, rate)
                    voice = out.add_stream("aac", rate=_RATE, layout="stereo", bit_rate=160_000) if sounds else None
                picture.pts, picture.time_base = index, 1 / rate
                out.mux(video.encode(picture.reformat(video.width, video.height, "yuv420p")))
                while voice is not None and voice.frames * _BLOCK / _RATE <= index / rate and (block := next(mixed, None)):
                    out.mux(voice.encode(block))
                progress((index + 1) / count)
            out.mux(video.encode())
            for block in mixed:
                out.mux(voice.encode(block))
            if voice is not None:
                out.mux(voice.encode())
    except av.FFmpegError as error:
        message = f"The images in {images} could not be made a film: {error}."
        raise OutputUnwritable(message, "Render the clip again.") from error


def _video_stream(out, picture, rate: Fraction):
    stream = out.add_stream("libx264", rate=rate, options={"crf": "18", "preset": "veryfast"})
    stream.width, stream.height = picture.width // 2 * 2, picture.height // 2 * 2
    stream.pix_fmt, stream.time_base = "yuv420p", 1 / rate
    stream.codec_context.thread_count = 1  # as many processes as cores do this at once
    return stream


def _pictures(images: Path, first: int, count: int, rate: Fraction) -> Iterator:
    import av

    shown = 0
    options = {"start_number": str(first), "framerate": str(rate)}
    pattern = audio.local(str(images).replace("%", "%%") + "/" + PATTERN)
    with av.open(pattern, format="image2", options=options) as source:
        for picture in source.decode(video=0):
            if shown == count:
                return
            shown += 1
            yield picture
    if shown < count:
        raise OutputUnwritable(f"{images} holds {shown} of {count} images.", "Render the clip again.")


def _mixed(sounds: Sequence[tuple[str, float]], length: int) -> Iterator:
    """Stereo frames of ``length`` samples in all."""
    import av

    tracks = [_Track(path, delay) for path, delay in sounds]
    for start in range(0, length, _BLOCK):
        block = sum(track.take(min(_BLOCK, length - start)) for track in tracks)
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(np.clip(block, -1, 1), np.float32), "fltp", "stereo")
        frame.sample_rate, frame.pts, frame.time_base = _RATE, start, Fraction(1, _RATE)
        yield frame


class _Track:
    """A recording as an endless stream of samples ``(2, n)``: silence, the sound, silence."""

    def __init__(self, path: str, delay: float):
        self._pieces = _pieces(path)
        self._buffer = np.zeros((2, round(delay * _RATE)), np.float32)

    def take(self, count: int) -> np.ndarray:
        pieces, have = [self._buffer], self._buffer.shape[1]
        while have < count:
            piece = next(self._pieces, None)
            if piece is None:
                piece = np.zeros((2, count - have), np.float32)
            pieces.append(piece)
            have += piece.shape[1]
        whole = np.concatenate(pieces, axis=1)
        self._buffer = whole[:, count:]
        return whole[:, :count]


def _pieces(path: str) -> Iterator[np.ndarray]:
    import av

    try:
        with audio.opened(path) as container:
            yield from audio.pieces(container, container.streams.audio[0], _RATE, "stereo")
    except (av.FFmpegError, OSError) as error:
        raise AudioUnreadable(f"{path} cannot be decoded ({error}).", "Export the recording again.") from error
