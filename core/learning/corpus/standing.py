"""Captured standing: the pelvis's place over the feet, its sway, and shifts of weight from foot to foot.

``python -m s2ag.core.learning.corpus.standing --material PATH -o core/synthesis/standing.npz``
"""

import argparse
import io
from os import PathLike
from pathlib import Path

import numpy as np

from ...files import atomic_file
from ...motion import skeleton
from ...smoothing import gaussian
from . import smartbody

SWAY_FPS = 7.5
"""Frames a second of sway; it is slow."""
STANDING = ("Idle02", "Idle01", "Idle03")
"""Captured postures: first on both feet, then two on the left one."""
CHANGES = (("Idle02_ToIdle01", True), ("Idle02_ToIdle03", True), ("Idle01_ToIdle02", False), ("Idle03_ToIdle02", False))
"""Captured transitions between the postures, and whether they end on one foot."""
_NAMES = {"base": "JtRoot"} | {
    f"{short}_{joint}": f"Jt{joint.capitalize()}{side}"
    for short, side in (("l", "Lf"), ("r", "Rt"))
    for joint in ("hip", "knee", "ankle")
}
"""Joint names of the recordings -> of the skeleton."""
_SMOOTHING = 0.12
"""Seconds: width of the Gaussian over the pelvis's motion."""
_EDGE = 0.02
"""A transition is cut where less than this share of its sideways path is done or left."""


def read_pelvis(folder: str | PathLike, name: str, joints: list[smartbody.Joint] | None = None) -> tuple[np.ndarray, float]:
    """Return the pelvis's motion ``(frames, 6)``, canonical axes, and frames a second.

    Its place over the middle of both ankles in hip heights, and its rotation vector in radians. The vertical part is how far
    the straighter leg is from straight; lowering by a wide stance is not part of it.
    """
    joints = joints or smartbody.load_skeleton(Path(folder) / "ChrRachel.sk")
    recording = smartbody.load_recording(Path(folder) / f"ChrBrad@{name}.skm")
    channels = {(_NAMES.get(joint, joint), kind): values for (joint, kind), values in recording.channels.items()}
    names = {"JtPelvis", *(f"Jt{joint}{side}" for joint in ("Hip", "Knee", "Ankle") for side in ("Lf", "Rt"))}
    positions, rotations = smartbody.forward_kinematics(joints, smartbody.Recording(recording.times, channels, {}), names)
    rest, _ = smartbody.forward_kinematics(joints, None, names)

    def over_feet(at: dict[str, np.ndarray]) -> np.ndarray:
        return 0.5 * (at["JtHipLf"] + at["JtHipRt"] - at["JtAnkleLf"] - at["JtAnkleRt"])

    tall = 0.5 * (rest["JtHipLf"] + rest["JtHipRt"])[0, 1]
    place = over_feet(positions) - over_feet(rest)
    place[:, 1] = -np.min([_length(rest, side) - _reach(positions, side) for side in ("Lf", "Rt")], 0)
    place /= tall
    fps = (len(recording.times) - 1) / (recording.times[-1] - recording.times[0])
    both = np.concatenate([place, _vector(rotations["JtPelvis"])], -1).reshape(-1, 2, 3)
    smooth = gaussian(both.reshape(len(place), 6), _SMOOTHING * fps).reshape(-1, 2, 3)
    return skeleton.y_up_to_canonical(smooth).reshape(-1, 6), float(fps)


def extract_tables(folder: str | PathLike) -> dict[str, np.ndarray]:
    """Return the table from which :mod:`s2ag.core.synthesis.stance` draws.

    ``postures`` ``(3, 6)`` of :data:`STANDING`, relative to standing straight; ``sway0`` and so on ``(frames, 6)`` about them
    at :data:`SWAY_FPS`; ``change0`` and so on ``(frames, 7)`` at 15 fps: share of the sideways path, and place and rotation
    relative to a linear blend by that share; ``onto``: whether a change ends on one foot; ``ways``: its sideways distance.
    """
    joints = smartbody.load_skeleton(Path(folder) / "ChrRachel.sk")
    tracks, postures = {}, []
    for number, name in enumerate(STANDING):
        track, fps = read_pelvis(folder, name, joints)
        postures.append(track.mean(0))
        tracks[f"sway{number}"] = _resample(track - track.mean(0), fps, SWAY_FPS)
    distances = []
    for number, (name, _) in enumerate(CHANGES):
        tracks[f"change{number}"], distance = _change(*read_pelvis(folder, name, joints))
        distances.append(distance)
    postures = np.array(postures)
    postures[:, 2:] -= postures[0, 2:]  # the captured person's own lean and heading are not part of the posture
    return {"postures": postures, "onto": np.array([onto for _, onto in CHANGES]), "ways": np.array(distances)} | tracks


def _length(rest: dict[str, np.ndarray], side: str) -> float:
    """Return the length of a straight leg from hip to ankle."""
    joints = [rest[f"Jt{joint}{side}"][0] for joint in ("Hip", "Knee", "Ankle")]
    return float(np.linalg.norm(np.diff(joints, axis=0), axis=-1).sum())


def _reach(positions: dict[str, np.ndarray], side: str) -> np.ndarray:
    """Return the distance from hip to ankle ``(frames,)``."""
    return np.linalg.norm(positions[f"JtHip{side}"] - positions[f"JtAnkle{side}"], axis=-1)


def _change(track: np.ndarray, fps: float) -> tuple[np.ndarray, float]:
    """Return a transition ``(frames, 7)`` as :func:`extract_tables` describes it, and its sideways distance."""
    track = _resample(track, fps, skeleton.FPS)
    first, last = track[0], track[-1]
    share = (track[:, 0] - first[0]) / (last[0] - first[0])
    busy = np.flatnonzero((share > _EDGE) & (share < 1 - _EDGE))
    track = track[max(busy[0] - 4, 0) : busy[-1] + 5]
    first, last = track[0], track[-1]
    share = (track[:, 0] - first[0]) / (last[0] - first[0])
    relative = track - first - share[:, None] * (last - first)
    return np.concatenate([share[:, None], relative], -1), float(last[0] - first[0])


def _resample(track: np.ndarray, fps: float, new_fps: float) -> np.ndarray:
    at = np.arange(0, len(track) - 1, fps / new_fps)
    return np.stack([np.interp(at, np.arange(len(track)), column) for column in track.T], -1)


def _vector(turns: np.ndarray) -> np.ndarray:
    """Return rotation vectors ``(frames, 3)`` of quaternions ``(frames, 4)``."""
    turns = np.where(turns[:, :1] < 0, -turns, turns)
    sine = np.linalg.norm(turns[:, 1:], axis=-1, keepdims=True)
    return turns[:, 1:] / np.maximum(sine, 1e-12) * 2 * np.arctan2(sine, turns[:, :1])


def main() -> None:
    """Run the command of this module."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--material", required=True, type=Path, help="folder with smartbody/idle/")
    parser.add_argument("-o", "--output", required=True, type=Path)
    options = parser.parse_args()
    learnt = extract_tables(options.material / "smartbody" / "idle")
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{name: values.astype(np.float16) for name, values in learnt.items()})
    with atomic_file(options.output) as temporary:
        temporary.write_bytes(buffer.getbuffer())
    for name, posture in zip(STANDING, learnt["postures"], strict=True):
        print(name, "place", posture[:3].round(4), "turn", np.degrees(posture[3:]).round(1), "degrees")
    print(f"{len(buffer.getbuffer())} bytes")


if __name__ == "__main__":
    main()
