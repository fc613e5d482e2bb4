"""Packs captured bodies that stand idle or listen, for :mod:`s2ag.core.synthesis.idling`.

``python -m s2ag.core.learning.corpus.idle_table --material PATH -o core/assets/idle.npz``, and with ``--listeners`` those who
listen to ``core/assets/listener.npz``.
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


LISTENERS: dict[str, tuple[str, slice]] = {
    "f_listen_1": ("f_gestic_listen_neutral_01", slice(None)),
    "f_listen_2": ("f_gestic_listen_neutral_02", slice(0, 72)),
    "f_listen_3": ("f_gestic_listen_neutral_02", slice(96, 160)),
    "f_listen_4": ("f_gestic_listen_neutral_02", slice(192, None)),
    "f_listen_5": ("f_gestic_listen_neutral_03", slice(0, 112)),
    "f_listen_6": ("f_gestic_listen_accept_05", slice(None)),
    **{
        f"{one[0]}_{one[2:]}": (f"{one[0]}_gestic_listen_{one[2:]}", slice(None))
        for one in ("f_accept_01", "f_accept_02", "f_accept_03", "m_accept_01", "m_accept_02", "m_accept_04")
        + ("f_deny_01", "f_deny_02", "f_deny_03", "m_deny_01", "m_deny_02")
    },
}
"""Clip and frames of each stretch of people who listen: who waits while another speaks, without the gestures made between (an
arm more than 25 degrees from where it hangs), nods, and denials, of which none moves the arms far."""


def pack(folder: str | PathLike, listeners: bool = False) -> dict[str, np.ndarray]:
    """Return the table: ``names`` ``(clips,)``, ``ends`` ``(clips,)`` in frames at 15 fps, and ``steps``
    ``(27 + SIZE, frames)`` int16: changes from frame to frame, a clip's first as it is, of directions and
    :mod:`hand_channels` in shares of :data:`idling.STEPS`.
    """
    paths = [path for pattern in STANDING for path in Path(folder).glob(f"{pattern}.npz")]
    found = sorted(path.stem for path in paths if path.stem not in LEFT_OUT)
    if not found:
        raise FileNotFoundError(f"{folder} holds no clips of {', '.join(STANDING)}")
    names = LISTENERS if listeners else {name: (name, slice(None)) for name in found}
    tracks = []
    for stem, rows in names.values():
        capture = rocketbox_clips.load(Path(folder) / f"{stem}.npz")
        assert capture.hands is not None
        hands = hand_channels.to_channels(capture.hands, capture.directions)
        numbers = np.concatenate([capture.directions.reshape(len(hands), 27), hands], axis=1)[rows]
        tracks.append(np.diff(np.round(numbers * STEPS), axis=0, prepend=0).astype(np.int16))
    ends = np.cumsum([len(track) for track in tracks])
    steps = np.ascontiguousarray(np.concatenate(tracks).T)  # rows of one kind pack better
    return {"names": np.array([*names]), "ends": ends.astype(np.int32), "steps": steps}


def main() -> None:
    """Run the command of this module."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--material", required=True, type=Path, help=f"folder with {rocketbox_clips.FOLDER}/")
    parser.add_argument("-o", "--output", required=True, type=Path)
    parser.add_argument("--listeners", action="store_true", help="pack those who listen instead of those who wait")
    options = parser.parse_args()
    table = pack(options.material / rocketbox_clips.FOLDER, options.listeners)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **table)
    with atomic_file(options.output) as temporary:
        temporary.write_bytes(buffer.getbuffer())
    print(f"{len(table['names'])} clips, {table['ends'][-1] / 15:.0f} s, {len(buffer.getbuffer())} bytes")


if __name__ == "__main__":
    main()
