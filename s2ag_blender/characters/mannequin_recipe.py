"""Designs the mannequin: ``python -m s2ag.s2ag_blender.characters.mannequin_recipe`` writes its bones and limbs as data.

:mod:`mannequin` builds the character from that file, so this is of the Python package alone."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

_Bones = dict[str, tuple[np.ndarray, np.ndarray, str | None]]
_Profile = Sequence[tuple[float, float, float]]

DATA = Path(__file__).with_name("mannequin.json")
BODY, JOINT, FACE = 0, 1, 2
"""Materials."""

_MIDDLE = {
    "hips": ((0, 0.005, 0.95), (0, 0.0, 1.06), None),
    "spine": ((0, 0.0, 1.06), (0, 0.005, 1.22), "hips"),
    "chest": ((0, 0.005, 1.22), (0, 0.015, 1.45), "spine"),
    "neck": ((0, 0.015, 1.45), (0, -0.005, 1.54), "chest"),
    "head": ((0, -0.005, 1.54), (0, -0.005, 1.78), "neck"),
}
_LEFT = {
    "shoulder": ((0.03, 0.01, 1.425), (0.175, 0.02, 1.42), "chest"),
    "upper_arm": ((0.175, 0.02, 1.42), (0.305, 0.03, 1.165), "shoulder"),
    "lower_arm": ((0.305, 0.03, 1.165), (0.395, -0.02, 0.945), "upper_arm"),
    "hand": ((0.395, -0.02, 0.945), (0.445, -0.055, 0.785), "lower_arm"),
    "thigh": ((0.095, 0.0, 0.93), (0.11, -0.01, 0.51), "hips"),
    "shin": ((0.11, -0.01, 0.51), (0.12, 0.025, 0.09), "thigh"),
    "foot": ((0.12, 0.025, 0.09), (0.13, -0.12, 0.02), "shin"),
}
"""Bones as (head, tail, parent) in metres; ``_LEFT`` exists twice, with .L and mirrored with .R."""

_LIMBS = {
    "hips": (-0.55, 1.0, 3.2, [(0, 0.100, 0.075), (0.5, 0.150, 0.105), (1, 0.110, 0.085)]),
    "spine": (-0.12, 1.1, 3.2, [(0, 0.100, 0.076), (0.5, 0.096, 0.074), (1, 0.110, 0.082)]),
    "chest": (-0.2, 0.98, 2.8, [(0, 0.110, 0.086), (0.35, 0.140, 0.108), (0.65, 0.160, 0.114), (1, 0.128, 0.076)]),
    "neck": (-0.25, 1.2, 5, [(0, 0.056, 0.054), (0.5, 0.044, 0.045), (1, 0.046, 0.048)]),
    "head": (-0.06, 1.0, 2.15, [(0, 0.066, 0.080), (0.35, 0.082, 0.100), (0.65, 0.094, 0.116), (1, 0.092, 0.112)]),
    "shoulder": (-0.15, 1.05, 3, [(0, 0.030, 0.036), (0.5, 0.038, 0.042), (1, 0.048, 0.046)]),
    "upper_arm": (0.06, 0.93, 3.5, [(0, 0.048, 0.050), (0.35, 0.050, 0.052), (1, 0.034, 0.035)]),
    "lower_arm": (0.08, 0.95, 3.5, [(0, 0.038, 0.038), (0.3, 0.040, 0.041), (1, 0.022, 0.026)]),
    "thigh": (0.03, 0.93, 3.5, [(0, 0.086, 0.088), (0.3, 0.084, 0.090), (1, 0.050, 0.052)]),
    "shin": (0.06, 0.96, 3.5, [(0, 0.050, 0.052), (0.3, 0.052, 0.062), (1, 0.030, 0.034)]),
}
"""Limbs around bones: from and to (shares of the bone), roundness of the ends, [(share, half width, half depth) metres]."""

_BALLS = {"spine": 0.078, "upper_arm": 0.049, "lower_arm": 0.036, "hand": 0.027, "thigh": 0.070, "shin": 0.050, "foot": 0.034}
_FINGERS = {
    "little": (-0.030, 0.070, 0.0085),
    "ring": (-0.010, 0.082, 0.0095),
    "middle": (0.010, 0.078, 0.0095),
    "index": (0.028, 0.062, 0.0085),
}
"""Sideways offset at the knuckles, length and radius in metres."""


def text() -> str:
    """Return the design as JSON, a line for each bone and limb."""
    bones = _bones()
    rows = [[name, list(head), list(tail), parent] for name, (head, tail, parent) in bones.items()]
    lists = (",\n".join(map(json.dumps, items)) for items in (rows, _limbs(bones)))
    return '{{"bones": [\n{}\n],\n"limbs": [\n{}\n]}}\n'.format(*lists)


def _bones() -> _Bones:
    """Return ``{name: (head, tail, parent or None)}`` of both sides."""
    bones: _Bones = {name: (np.array(head), np.array(tail), parent) for name, (head, tail, parent) in _MIDDLE.items()}
    for suffix, side in ((".L", 1), (".R", -1)):
        flip = np.array([side, 1, 1])
        for name, (head, tail, parent) in _LEFT.items():
            owner = parent if parent in _MIDDLE else parent + suffix
            bones[name + suffix] = (np.multiply(head, flip), np.multiply(tail, flip), owner)
        wrist, tip, _ = bones["hand" + suffix]
        for finger, (points, _) in _digits(wrist, tip, side).items():
            bones[f"{finger}_1{suffix}"] = (points[0], points[1], "hand" + suffix)
            bones[f"{finger}_2{suffix}"] = (points[1], points[2], f"{finger}_1{suffix}")
    return bones


def _limbs(bones: _Bones) -> Iterator[dict]:
    """Yield every limb and joint, each rigid on its bone, in the order of the bones."""
    for name, (head, tail, _) in bones.items():
        plain = name.split(".")[0]
        if plain in _LIMBS:
            start, end, roundness, profile = _LIMBS[plain]
            yield _limb(name, head + start * (tail - head), head + end * (tail - head), profile, roundness)
        if plain in _BALLS:
            reach, size = np.array([0, 0, _BALLS[plain]]), _BALLS[plain]
            yield _limb(name, head - reach, head + reach, [(0, size, size), (1, size, size)], 2, JOINT)
        if plain == "hand":
            yield from _hand(head, tail, name.removeprefix("hand"))
        if plain == "foot":
            profile = [(0, 0.034, 0.036), (0.6, 0.044, 0.030), (1, 0.040, 0.020)]
            yield _limb(name, head + [0, 0.045, -0.045], tail + [0, 0, 0.016], profile, 3)
        if plain == "head":
            yield from _face(head, tail)


def _limb(
    bone: str,
    start: np.ndarray,
    end: np.ndarray,
    profile: _Profile,
    roundness: float,
    material: int = BODY,
    front: Sequence[float] | np.ndarray = (0, -1, 0),
    fine: int = 28,
) -> dict:
    """Return a limb as :mod:`mannequin` reads it; ``fine`` is the number of points around it."""
    return {
        "bone": bone,
        "start": list(start),
        "end": list(end),
        "profile": profile,
        "roundness": roundness,
        "material": material,
        "front": list(front),
        "fine": fine,
    }


def _frame(wrist: np.ndarray, tip: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return unit vectors (3,) along a hand, out of its palm, and across it to the thumb."""
    along = (tip - wrist) / np.linalg.norm(tip - wrist)
    palm = np.array([-side * 0.9, 0.1, -0.2])
    palm -= along * (palm @ along)
    palm /= np.linalg.norm(palm)
    across = np.cross(along, palm) * side
    return along, palm, across * np.sign(-across[1])


def _digits(wrist: np.ndarray, tip: np.ndarray, side: int) -> dict[str, tuple[np.ndarray, tuple[float, float]]]:
    """Return ``{finger: (knuckle, joint and tip (3, 3), radii of both links)}`` of slightly curled fingers and a thumb."""
    along, palm, across = _frame(wrist, tip, side)
    digits = {}
    for finger, (offset, length, radius) in _FINGERS.items():
        knuckle = wrist + 0.09 * along + offset * across
        bend = knuckle + 0.5 * length * (along + 0.22 * palm + 2.0 * offset * across)
        end = bend + 0.55 * length * (0.85 * along + 0.6 * palm)
        digits[finger] = np.array([knuckle, bend, end]), (radius, 0.9 * radius)
    root = wrist + 0.03 * along + 0.026 * across
    bend = root + 0.04 * along + 0.03 * across + 0.012 * palm
    end = bend + 0.036 * along + 0.006 * across + 0.010 * palm
    return digits | {"thumb": (np.array([root, bend, end]), (0.011, 0.0095))}


def _hand(wrist: np.ndarray, tip: np.ndarray, suffix: str) -> Iterator[dict]:
    """Yield a palm on the hand's bone, four fingers and a thumb on bones of their own."""
    side = 1 if suffix == ".L" else -1
    along, palm, _ = _frame(wrist, tip, side)
    profile = [(0, 0.024, 0.020), (0.6, 0.038, 0.017), (1, 0.040, 0.013)]
    yield _limb("hand" + suffix, wrist, wrist + 0.1 * along, profile, 4, front=palm)
    for finger, (points, radii) in _digits(wrist, tip, side).items():
        for link in (0, 1):
            start, end, radius = points[link], points[link + 1], radii[link]
            reach = (end - start) / np.linalg.norm(end - start) * radius * 0.6
            profile = [(0, radius, radius), (1, 0.85 * radius, 0.85 * radius)]
            yield _limb(f"{finger}_{link + 1}{suffix}", start - reach, end + reach, profile, 3, fine=12)


def _face(neck: np.ndarray, crown: np.ndarray) -> Iterator[dict]:
    """Yield a visor and the hint of a nose, which show where the head faces."""
    height = crown[2] - neck[2]
    eyes = neck + [0, -0.058, 0.53 * height]
    visor = [(0, 0.022, 0.046), (0.5, 0.032, 0.062), (1, 0.022, 0.046)]
    yield _limb("head", eyes - [0.076, 0, 0], eyes + [0.076, 0, 0], visor, 3, FACE)
    nose = neck + [0, -0.103, 0.36 * height]
    profile = [(0, 0.006, 0.008), (1, 0.014, 0.014)]
    yield _limb("head", nose + [0, 0.012, 0.034], nose + [0, -0.006, -0.014], profile, 3)


if __name__ == "__main__":
    DATA.write_text(text(), "utf-8")
