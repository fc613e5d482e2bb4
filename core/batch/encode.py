"""Encodes numbered images and recordings as a film (H.264 and AAC) with FFmpeg's libraries (package ``av``)."""

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import AudioUnreadable, OutputUnwritable
from ..sound import av_decoding

if TYPE_CHECKING:
    from av import AudioFrame, AudioStream, VideoFrame, VideoStream
    from av.container import OutputContainer

PATTERN = "%06d.png"
"""FFmpeg's pattern of the image names, as Blender writes them."""
_RATE = 48000
"""Sample rate of the sound in Hz."""
_BLOCK = 1024
"""Samples of an AAC frame."""


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

    ``sounds`` are recordings with their start times in seconds; several are mixed. ``progress`` is called with a share
    (0..1). Raises :class:`OutputUnwritable` if an image is missing, and :class:`AudioUnreadable`.
    """
    import av
    from av.error import FFmpegError

    rate = Fraction(fps).limit_denominator(1001)
    try:
        with av.open(av_decoding.ffmpeg_path(path), "w", options={"movflags": "faststart"}) as out:
            video = voice = None
            mixed = _mix(sounds, int(count / rate * _RATE)) if sounds else iter(())
            for index, picture in enumerate(_pictures(images, first, count, rate)):
                if video is None:
                    video = _video_stream(out, picture, rate)
                    voice = _audio_stream(out) if sounds else None
                picture.pts, picture.time_base = index, 1 / rate
                out.mux(video.encode(picture.reformat(video.width, video.height, "yuv420p")))
                while voice is not None and voice.frames * _BLOCK / _RATE <= index / rate and (block := next(mixed, None)):
                    out.mux(voice.encode(block))
                progress((index + 1) / count)
            if video is not None:
                out.mux(video.encode())
            if voice is not None:
                for block in mixed:
                    out.mux(voice.encode(block))
                out.mux(voice.encode())
    except FFmpegError as error:
        message = f"The images in {images} could not be made a film: {error}."
        raise OutputUnwritable(message, "Render the clip again.") from error


def _video_stream(out: "OutputContainer", picture: "VideoFrame", rate: Fraction) -> "VideoStream":
    """Add an H.264 stream of the picture's size, rounded down to even numbers."""
    stream = out.add_stream("libx264", rate=rate, options={"crf": "18", "preset": "veryfast"})
    stream.width, stream.height = picture.width // 2 * 2, picture.height // 2 * 2
    stream.pix_fmt, stream.time_base = "yuv420p", 1 / rate
    stream.codec_context.thread_count = 1  # one process per core runs at the same time
    return stream


def _audio_stream(out: "OutputContainer") -> "AudioStream":
    return out.add_stream("aac", rate=_RATE, layout="stereo", bit_rate=160_000)


def _pictures(images: Path, first: int, count: int, rate: Fraction) -> Iterator["VideoFrame"]:
    """Decode ``count`` images; raises :class:`OutputUnwritable` if there are fewer."""
    import av

    number = 0
    options = {"start_number": str(first), "framerate": str(rate)}
    pattern = av_decoding.ffmpeg_path(str(images).replace("%", "%%") + "/" + PATTERN)
    with av.open(pattern, format="image2", options=options) as source:
        for picture in source.decode(video=0):
            if number == count:
                return
            number += 1
            yield picture
    if number < count:
        raise OutputUnwritable(f"{images} holds {number} of {count} images.", "Render the clip again.")


def _mix(sounds: Sequence[tuple[str, float]], length: int) -> Iterator["AudioFrame"]:
    """Yield the sum of all sounds as stereo frames of ``length`` samples in total."""
    import av

    tracks = [_Track(path, delay) for path, delay in sounds]
    for start in range(0, length, _BLOCK):
        block = sum(track.take(min(_BLOCK, length - start)) for track in tracks)
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(np.clip(block, -1, 1), np.float32), "fltp", "stereo")
        frame.sample_rate, frame.pts, frame.time_base = _RATE, start, Fraction(1, _RATE)
        yield frame


class _Track:
    """A recording as an endless stream of samples ``(2, n)``: ``delay`` seconds of silence, the sound, silence."""

    def __init__(self, path: str, delay: float):
        self._pieces = _pieces(path)
        self._buffer = np.zeros((2, round(delay * _RATE)), np.float32)

    def take(self, count: int) -> np.ndarray:
        """Return the next ``count`` samples (2, count)."""
        pieces, length = [self._buffer], self._buffer.shape[1]
        while length < count:
            piece = next(self._pieces, None)
            if piece is None:
                piece = np.zeros((2, count - length), np.float32)
            pieces.append(piece)
            length += piece.shape[1]
        whole = np.concatenate(pieces, axis=1)
        self._buffer = whole[:, count:]
        return whole[:, :count]


def _pieces(path: str) -> Iterator[np.ndarray]:
    """Decode a recording as pieces (2, n) at ``_RATE``; raises :class:`AudioUnreadable`."""
    from av.error import FFmpegError

    try:
        with av_decoding.open_container(path) as container:
            yield from av_decoding.decode_pieces(container, container.streams.audio[0], _RATE, "stereo")
    except (FFmpegError, OSError) as error:
        raise AudioUnreadable(f"{path} cannot be decoded ({error}).", "Export the recording again.") from error
