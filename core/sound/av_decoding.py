"""Decodes sound by FFmpeg, with the package ``av``, which Blender's own Python lacks: the extension's zip leaves this out."""

import contextlib
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import AudioUnreadable

if TYPE_CHECKING:
    from av import AudioFrame, AudioStream
    from av.container import InputContainer

_CHOOSE = "Choose a recording, or a video with an audio track."


def open_container(path: str | PathLike) -> "InputContainer":
    """Open a file as an ``av`` container; tags in a wrong encoding are ignored.

    The path is never read as a URL, and a playlist can refer to local files only.
    """
    import av

    name, options = ffmpeg_path(path), {"protocol_whitelist": "file"}
    try:
        return av.open(name, metadata_errors="ignore", options=options)
    except TypeError:  # av 19 always ignores such errors and lacks the argument
        return av.open(name, options=options)


def ffmpeg_path(path: str | PathLike) -> str:
    """Return FFmpeg's name for the file at ``path``: without the protocol, ``12:30 talk.wav`` would be read as a URL."""
    return f"file:{path}"


def decode_pieces(
    container: "InputContainer", stream: "AudioStream", rate: int, layout: str | None = None
) -> Iterator[np.ndarray]:
    """Decode a stream of an open ``av`` container into pieces ``(channels, n)`` of float32 samples.

    The sound is resampled to ``rate`` and mixed to ``layout``, such as ``stereo`` (None keeps the channels). Damaged packets
    are skipped. Raises :class:`av.FFmpegError`.
    """
    import av
    import av.error

    stream.thread_type = "AUTO"  # pyright: ignore[reportAttributeAccessIssue]  # delegated to the codec context
    resampler = av.AudioResampler(format="flt", layout=layout, rate=rate)
    for packet in container.demux(stream):
        try:
            frames = packet.decode()
        except av.error.InvalidDataError:
            continue
        for frame in frames:
            frame.pts = None
            yield from (_channels(piece) for piece in resampler.resample(frame))
    yield from (_channels(piece) for piece in resampler.resample(None))


def _channels(frame: "AudioFrame") -> np.ndarray:
    """Return ``(channels, n)`` of a frame of interleaved samples; with more than seven planes ``av`` crashes the process."""
    return frame.to_ndarray().reshape(-1, frame.layout.nb_channels).T


@contextlib.contextmanager
def audio_container(path: Path) -> "Iterator[InputContainer]":
    """Open a file that has an audio stream; errors of ``av`` inside the block become :class:`AudioUnreadable`, too."""
    import av.error

    try:
        with open_container(path) as container:
            if not container.streams.audio:
                raise AudioUnreadable(f"{path} has no sound in it.", _CHOOSE)
            if container.streams.audio[0].codec_context is None:
                raise AudioUnreadable(f"The sound of {path} is of a kind that nothing here reads.", _CHOOSE)
            yield container
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: Exception) -> AudioUnreadable:
    what = f"{path} is not a readable recording ({_reason(error)})."
    return AudioUnreadable(what, "Export it again, for instance as WAV, FLAC or MP3.")


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).rstrip(".")
