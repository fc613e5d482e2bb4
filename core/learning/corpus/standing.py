"""How captured people stand: where the pelvis is over the feet, how it sways, and how weight goes from foot to foot.

``python -m s2ag.core.learning.corpus.standing --material PATH -o core/performance/standing.npz``
"""

import argparse
import io
from os import PathLike
from pathlib import Path

import numpy as np

from ...files import whole_file
from ...motion import skeleton
from ...smoothing import gaussian
from . import skm

SWAY_FPS = 7.5
"""Frames a second of sway, which is slow."""
STANDING = ("Idle02", "Idle01", "Idle03")
"""Captured standing: on both feet first, then twice on the left one."""
CHANGES = (("Idle02_ToIdle01", True), ("Idle02_ToIdle03", True), ("Idle01_ToIdle02", False), ("Idle03_ToIdle02", False))
"""Changes between them, and whether they lead onto a foot."""
_NAMES = {"base": "JtRoot"} | {
    f"{short}_{joint}": f"Jt{joint.capitalize()}{side}"
    for short, side in (("l", "Lf"), ("r", "Rt"))
    for joint in ("hip", "knee", "ankle")
}
"""The recordings' names of joints and their skeleton's."""
_SMOOTH = 0.12
"""Seconds, as the width of a Gaussian."""
_EDGE = 0.02
"""Share of a change's way that its first and its last frame have at most left."""


def read(folder: str | PathLike, name: str, joints: list[skm.Joint] | None = None) -> tuple[np.ndarray, float]:
    """Pelvis of a recording ``(frames, 6)``, canonical, and frames a second.

    Its place over the middle of both ankles in heights of the hips, and its turn as a rotation vector in radians. Down is how
    far the straighter leg is from straight: how wide people stand apart, which lowers them, too, is another's affair.
    """
    joints = joints or skm.load_skeleton(Path(folder) / "ChrRachel.sk")
    recording = skm.load_recording(Path(folder) / f"ChrBrad@{name}.skm")
    channels = {(_NAMES.get(joint, joint), kind): values for (joint, kind), values in recording.channels.items()}
    wanted = {"JtPelvis", *(f"Jt{joint}{side}" for joint in ("Hip", "Knee", "Ankle") for side in ("Lf", "Rt"))}
    positions, rotations = skm.forward(joints, skm.Recording(recording.times, channels, {}), wanted)
    rest, _ = skm.forward(joints, None, wanted)

    def over_feet(at):
        return 0.5 * (at["JtHipLf"] + at["JtHipRt"] - at["JtAnkleLf"] - at["JtAnkleRt"])

    tall = 0.5 * (rest["JtHipLf"] + rest["JtHipRt"])[0, 1]
    place = over_feet(positions) - over_feet(rest)
    place[:, 1] = -np.min([_length(rest, side) - _reach(positions, side) for side in ("Lf", "Rt")], 0)
    place /= tall
    fps = (len(recording.times) - 1) / (recording.times[-1] - recording.times[0])
    both = np.concatenate([place, _vector(rotations["JtPelvis"])], -1).reshape(-1, 2, 3)
    smooth = gaussian(both.reshape(len(place), 6), _SMOOTH * fps).reshape(-1, 2, 3)
    return skeleton.y_up_to_canonical(smooth).reshape(-1, 6), float(fps)


def learn(folder: str | PathLike) -> dict[str, np.ndarray]:
    """What :mod:`s2ag.core.performance.stance` draws from.

    ``postures`` ``(3, 6)`` of :data:`STANDING`, away from standing straight; ``sway0`` and so on ``(frames, 6)`` about them at
    :data:`SWAY_FPS`, without a seam; ``change0`` and so on ``(frames, 7)`` at 15 fps: the share of the sideward way, and what
    place and turn do beside it; ``onto`` whether a change leads onto a foot and ``ways`` how far it goes, sidewards.
    """
    joints = skm.load_skeleton(Path(folder) / "ChrRachel.sk")
    found, postures = {}, []
    for number, name in enumerate(STANDING):
        track, fps = read(folder, name, joints)
        postures.append(track.mean(0))
        found[f"sway{number}"] = _at(track - track.mean(0), fps, SWAY_FPS)
    ways = []
    for number, (name, _) in enumerate(CHANGES):
        found[f"change{number}"], way = _change(*read(folder, name, joints))
        ways.append(way)
    postures = np.array(postures)
    postures[:, 2:] -= postures[0, 2:]  # which way the performer leans and faces on both feet is nobody's
    return {"postures": postures, "onto": np.array([onto for _, onto in CHANGES]), "ways": np.array(ways)} | found


def _length(rest: dict, side: str) -> float:
    joints = [rest[f"Jt{joint}{side}"][0] for joint in ("Hip", "Knee", "Ankle")]
    return float(np.linalg.norm(np.diff(joints, axis=0), axis=-1).sum())


def _reach(positions: dict, side: str) -> np.ndarray:
    return np.linalg.norm(positions[f"JtHip{side}"] - positions[f"JtAnkle{side}"], axis=-1)


def _change(track: np.ndarray, fps: float) -> tuple[np.ndarray, float]:
    track = _at(track, fps, skeleton.FPS)
    first, last = track[0], track[-1]
    share = (track[:, 0] - first[0]) / (last[0] - first[0])
    busy = np.flatnonzero((share > _EDGE) & (share < 1 - _EDGE))
    track = track[max(busy[0] - 4, 0) : busy[-1] + 5]
    first, last = track[0], track[-1]
    share = (track[:, 0] - first[0]) / (last[0] - first[0])
    beside = track - first - share[:, None] * (last - first)
    return np.concatenate([share[:, None], beside], -1), float(last[0] - first[0])


def _at(track: np.ndarray, fps: float, wanted: float) -> np.ndarray:
    at = np.arange(0, len(track) - 1, fps / wanted)
    return np.stack([np.interp(at, np.arange(len(track)), column) for column in track.T], -1)


def _vector(turns: np.ndarray) -> np.ndarray:
    """Rotation vectors (frames, 3) of quaternions."""
    turns = np.where(turns[:, :1] < 0, -turns, turns)
    sine = np.linalg.norm(turns[:, 1:], axis=-1, keepdims=True)
    return turns[:, 1:] / np.maximum(sine, 1e-12) * 2 * np.arctan2(sine, turns[:, :1])


def main() -> None:
    """The command of this module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--material", required=True, type=Path, help="folder with smartbody/idle/")
    parser.add_argument("-o", "--output", required=True, type=Path)
    options = parser.parse_args()
    learnt = learn(options.material / "smartbody" / "idle")
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{name: values.astype(np.float16) for name, values in learnt.items()})
    with whole_file(options.output) as temporary:
        temporary.write_bytes(buffer.getbuffer())
    for name, posture in zip(STANDING, learnt["postures"], strict=True):
        print(name, "place", posture[:3].round(4), "turn", np.degrees(posture[3:]).round(1), "degrees")
    print(f"{len(buffer.getbuffer())} bytes")


if __name__ == "__main__":
    main()
