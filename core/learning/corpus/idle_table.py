"""Packs captured bodies that stand idle, for :mod:`s2ag.core.synthesis.idling`.

``python -m s2ag.core.learning.corpus.idle_table --material PATH -o core/assets/idle.npz``
"""

import argparse
import io
from os import PathLike
from pathlib import Path

import numpy as np

from ...files import atomic_file
from ...motion import hand_channels
from ...synthesis.idling import STEPS
from . import rocketbox_clips

STANDING = ("[fm]_idle_*", "f_gestic_listen_neutral_01")
"""Patterns of clips in which people stand and wait."""
LEFT_OUT = ("m_idle_angry_02", "f_idle_breathe_01", "m_idle_breathe_01", "f_idle_shake_leg_01", "m_idle_shake_leg_01")
"""Acted, too short, or about legs, which the product moves by weight alone."""


def pack(folder: str | PathLike) -> dict[str, np.ndarray]:
    """Return the table: ``names`` ``(clips,)``, ``ends`` ``(clips,)`` in frames at 15 fps, and ``steps``
    ``(27 + SIZE, frames)`` int16: changes from frame to frame, a clip's first as it is, of directions and
    :mod:`hand_channels` in shares of :data:`idling.STEPS`.
    """
    paths = sorted(path for pattern in STANDING for path in Path(folder).glob(f"{pattern}.npz") if path.stem not in LEFT_OUT)
    if not paths:
        raise FileNotFoundError(f"{folder} holds no clips of {', '.join(STANDING)}")
    tracks = []
    for capture in map(rocketbox_clips.load, paths):
        assert capture.hands is not None
        hands = hand_channels.to_channels(capture.hands, capture.directions)
        numbers = np.concatenate([capture.directions.reshape(len(hands), 27), hands], axis=1)
        tracks.append(np.diff(np.round(numbers * STEPS), axis=0, prepend=0).astype(np.int16))
    ends = np.cumsum([len(track) for track in tracks])
    steps = np.ascontiguousarray(np.concatenate(tracks).T)  # rows of one kind pack better
    return {"names": np.array([path.stem for path in paths]), "ends": ends.astype(np.int32), "steps": steps}


def main() -> None:
    """Run the command of this module."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--material", required=True, type=Path, help=f"folder with {rocketbox_clips.FOLDER}/")
    parser.add_argument("-o", "--output", required=True, type=Path)
    options = parser.parse_args()
    table = pack(options.material / rocketbox_clips.FOLDER)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **table)
    with atomic_file(options.output) as temporary:
        temporary.write_bytes(buffer.getbuffer())
    print(f"{len(table['names'])} clips, {table['ends'][-1] / 15:.0f} s, {len(buffer.getbuffer())} bytes")


if __name__ == "__main__":
    main()
