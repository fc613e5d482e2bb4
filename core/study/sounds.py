"""Replaces the sound of films, encoding original and replaced sound alike so that only the speech differs."""

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError
from ..files import open_file
from ..sound import av_decoding

RATE = 48000


def film_seconds(film: str | PathLike) -> float:
    """Return the seconds of a film's picture; raises :class:`UsageError` if it is unreadable or lacks picture or sound."""
    with _open(film) as container:
        stream = container.streams.video[0]
        if stream.duration and stream.time_base:
            return float(stream.duration * stream.time_base)
        return float(container.duration or 0) / 1e6


def sound_partners(lengths: dict[str, float]) -> dict[str, str]:
    """Return for every excerpt the one whose sound it gets: the next longer one, or for the longest the second longest.

    Raises :class:`UsageError` for fewer than two.
    """
    ranked = sorted(lengths, key=lambda name: (lengths[name], name))
    if len(ranked) < 2:
        raise UsageError("Another sound needs a second excerpt.", "Give every condition two clips or more.")
    return dict(zip(ranked, [*ranked[1:], ranked[-2]], strict=True))


def replace_sound(film: str | PathLike, heard: str | PathLike, out: str | PathLike) -> None:
    """Write ``film``'s picture with the sound of the film ``heard`` to ``out``, as long as the picture."""
    import av.error

    film, out = Path(film), Path(out)
    samples = _samples(heard, int(round(film_seconds(film) * RATE)))
    try:
        with _open(film) as own, av.open(av_decoding.ffmpeg_path(out), "w") as target:
            source = own.streams.video[0]
            # Older PyAV takes the template as an argument of add_stream.
            old: Any = target.add_stream
            add = getattr(target, "add_stream_from_template", None) or (lambda template: old(template=template))
            picture = add(source)
            sound = target.add_stream("libopus" if out.suffix.lower() == ".webm" else "aac", rate=RATE)
            sound.layout = "mono"
            for packet in own.demux(source):
                if packet.dts is not None:
                    packet.stream = picture
                    target.mux(packet)
            for begin in range(0, len(samples), RATE):
                frame = av.AudioFrame.from_ndarray(samples[None, begin : begin + RATE], "flt", "mono")
                frame.sample_rate, frame.pts = RATE, begin
                target.mux(sound.encode(frame))
            target.mux(sound.encode(None))
    except av.error.FFmpegError as error:
        raise UsageError(f"{film} cannot be given another sound: {error}.", "Encode it as H.264 in .mp4.") from error


def _samples(film: str | PathLike, count: int) -> np.ndarray:
    """Return ``count`` samples of a film's sound, float32, cut or padded with silence."""
    with _open(film) as container:
        parts = [piece[0] for piece in av_decoding.decode_pieces(container, container.streams.audio[0], RATE, "mono")]
    samples = np.concatenate(parts or [np.zeros(0, np.float32)])[:count]
    return np.pad(samples, (0, count - len(samples))).astype(np.float32)


def _open(film: str | PathLike) -> Any:
    """Open a film as a PyAV container; raises :class:`UsageError` if it is unreadable or lacks picture or sound."""
    try:
        import av.error
    except ImportError as error:
        raise UsageError("Films get another sound by the package av.", 'Install it: pip install "s2ag[engine]".') from error
    try:
        open_file(film).close()  # readers that open files by themselves would wait for a pipe
        container = av_decoding.open_container(film)
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise UsageError(f"{film} is no film.", "Give .mp4 or .webm that a browser plays.") from error
    if not (container.streams.video and container.streams.audio):
        container.close()
        raise UsageError(f"{film} lacks picture or sound.", "Give films with sound.")
    return container
