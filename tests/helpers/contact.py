"""How deep the parts of a posed body lie in each other: arms and hands as capsules, the trunk as ellipses, the head as a ball.

Everything is read from where joints are, so that it holds for any solver: by formula, or from Blender.
"""

import numpy as np
from s2ag.rigs import fingers
from s2ag.rigs.goals import SIDES
from s2ag.rigs.skeleton import character_frame

PALM, FINGER, THUMB = (0.10, 0.09), (0.068, 0.06, 0.05, 0.045), (0.085, 0.072, 0.055, 0.05)
"""Radii in hand lengths (wrist to the farthest joint): at wrist and knuckles, and along fingers and thumb."""
FOREARM, UPPER = (0.29, 0.19), (0.34, 0.30)
NECK, HEAD = 0.42, 0.58
LAST = 0.8
"""Length of a finger's last link, by the one before, where its tip is no joint."""


class Solids:
    """The capsules of a body: ``hand``, ``forearm`` and ``upper_arm`` of each side, ``neck`` and ``head``.

    ``of`` gives ends (frames, capsules, 2, 3) and radii (capsules, 2) for posed heads (frames, n, 3).
    """

    def __init__(self, bones, mapping, girth, usable=None):
        self.bones, self.mapping, self.girth = bones, mapping, girth
        self.frame = character_frame(bones, mapping)
        self.hands = {side: fingers.find_hand(bones, mapping, side, usable) for side in SIDES}
        self.length = float(np.mean([hand.length for hand in self.hands.values()]))
        self.rows = {part: [bones.row(name) for name in chain] for part, chain in mapping.chains.items()}
        self.origin = 0.5 * sum(bones.heads[self.rows[f"{side}_upper_arm"][0]] for side in SIDES)

    def hand(self, side, heads):
        """Palm, fingers and thumb."""
        hand, wrist = self.hands[side], heads[:, self.rows[f"{side}_hand"][0]]
        ends, radii = [], []
        for chain in hand.fingers:
            ends.append((wrist, heads[:, chain[0]]))
            radii.append(PALM)
        chains = [(chain, FINGER) for chain in hand.fingers] + [(hand.thumb, THUMB)] * bool(hand.thumb)
        for chain, thick in chains:
            points = [heads[:, row] for row in chain[:4]]
            if len(points) < 4:
                points.append(points[-1] + LAST * (points[-1] - points[-2]))
            for place in range(len(points) - 1):
                ends.append((points[place], points[place + 1]))
                radii.append(thick[place : place + 2])
        return np.stack([np.stack(pair, 1) for pair in ends], 1), self.length * np.array(radii)

    def limb(self, side, part, heads):
        """A forearm or an upper arm."""
        joints = {"upper_arm": ("upper_arm", "forearm"), "forearm": ("forearm", "hand")}[part]
        pair = np.stack([heads[:, self.rows[f"{side}_{name}"][0]] for name in joints], 1)
        return pair[:, None], self.length * np.array([UPPER if part == "upper_arm" else FOREARM])

    def middle(self, heads):
        """Neck and head, one capsule each."""
        shoulders = 0.5 * sum(heads[:, self.rows[f"{side}_upper_arm"][0]] for side in SIDES)
        neck = heads[:, self.rows["neck"][0]] if "neck" in self.rows else shoulders
        return neck, heads[:, self.rows["head"][-1]]

    def trunk_depth(self, ends, radii, heads, orientations):
        """How deep capsules lie in the trunk (frames, capsules)."""
        steps = np.linspace(0, 1, 4)
        points = ends[:, :, :1] + steps[:, None] * (ends[:, :, 1:] - ends[:, :, :1])
        thick = radii[:, :1] + steps * (radii[:, 1:] - radii[:, :1])
        chest = self.rows["torso"][-1]
        turn = orientations[:, chest] @ self.bones.matrices[chest, :3, :3].T
        shoulders = self.bones.heads[chest]
        seen = np.einsum("fji,fckj->fcki", turn, points - heads[:, None, None, chest]) + shoulders
        hips = self.rows["torso"][0]
        below = points - heads[:, None, None, hips] + self.bones.heads[hips]
        seen, below = (self.frame @ (place - self.origin)[..., None] for place in (seen, below))
        seen, below = seen[..., 0], below[..., 0]
        share = np.clip(seen[..., 2:] / self.girth.waist, 0, 1)
        return self.girth.depth(seen + share * (below - seen), thick).max(-1)


def between(a, thick_a, b, thick_b):
    """How deep capsules lie in others (frames, n, m): ends (frames, n, 2, 3) and radii (n, 2)."""
    p, q = a[:, :, None, 0], b[:, None, :, 0]
    d1, d2 = a[:, :, None, 1] - p, b[:, None, :, 1] - q
    r = p - q
    aa, ee, bb = (np.sum(x * y, -1) for x, y in ((d1, d1), (d2, d2), (d1, d2)))
    c, f = np.sum(d1 * r, -1), np.sum(d2 * r, -1)
    denominator = aa * ee - bb * bb
    s = np.clip(np.where(denominator > 1e-12 * aa * ee, (bb * f - c * ee) / np.maximum(denominator, 1e-30), 0.5), 0, 1)
    t = np.clip((bb * s + f) / np.maximum(ee, 1e-30), 0, 1)
    s = np.clip((bb * t - c) / np.maximum(aa, 1e-30), 0, 1)
    gap = np.linalg.norm(r + s[..., None] * d1 - t[..., None] * d2, axis=-1)
    first = thick_a[:, None, 0] + s * (thick_a[:, None, 1] - thick_a[:, None, 0])
    second = thick_b[None, :, 0] + t * (thick_b[None, :, 1] - thick_b[None, :, 0])
    return first + second - gap


def depths(solids: Solids, heads, orientations) -> dict[str, np.ndarray]:
    """Depth (frames,) of what lies deepest in what, by the names of the pair, in the armature's units; negative apart."""
    parts = {}
    for side in SIDES:
        parts[side] = {
            "hand": solids.hand(side, heads),
            "forearm": solids.limb(side, "forearm", heads),
            "upper_arm": solids.limb(side, "upper_arm", heads),
        }
    left, right = parts["left"], parts["right"]

    def pair(one, other):
        return between(*left[one], *right[other]).max((-1, -2))

    found = {"hand hand": pair("hand", "hand"), "forearm forearm": pair("forearm", "forearm")}
    for other in ("forearm", "upper_arm"):
        found[f"hand {other}"] = np.maximum(pair("hand", other), pair(other, "hand"))
    found["forearm upper_arm"] = np.maximum(pair("forearm", "upper_arm"), pair("upper_arm", "forearm"))
    for name in ("hand", "forearm"):
        found[f"{name} trunk"] = np.max(
            [solids.trunk_depth(*parts[side][name], heads, orientations).max(-1) for side in SIDES], 0
        )
        found |= {f"{name} {what}": value for what, value in _head(solids, [parts[side][name] for side in SIDES], heads)}
    return found


def _head(solids, sides, heads):
    neck, head = solids.middle(heads)
    up = head - neck
    up = up / np.linalg.norm(up, axis=-1, keepdims=True)
    h = solids.length
    column = np.stack([neck, head], 1)[:, None]
    skull = np.stack([head + 0.25 * h * up, head + 0.6 * h * up], 1)[:, None]
    for what, ends, radius in (("neck", column, NECK), ("head", skull, HEAD)):
        yield what, np.max([between(*side, ends, h * np.full((1, 2), radius)).max((-1, -2)) for side in sides], 0)
