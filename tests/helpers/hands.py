"""Hands for the bodies of the tests: fingers as joints below the wrists."""

import numpy as np
from bodies import Body, body
from s2ag.core.motion import skeleton

FINGERS = {"index": -2.8, "middle": -0.8, "ring": 1.2, "little": 3.0}
"""Centimetres from the middle of the hand to each knuckle, away from the thumb's side."""


def with_hands(pose: str = "T", curl: float = 0.0, fingers=tuple(FINGERS), thumb: bool = True, extras: bool = False) -> Body:
    """A body whose fingers have three joints and an end, each bent by ``curl`` degrees; thumbs point forwards.

    ``extras`` adds what files have: bones in the palm, a helper, and something that the hand holds.
    """
    whole = body(pose)
    joints = dict(whole.joints)
    for side, sign in (("left", 1), ("right", -1)):
        wrist, elbow = (np.array(joints[f"{side}_{name}"][0], float) for name in ("hand", "fore"))
        along = skeleton.normalize(wrist - elbow)
        thumbwards = np.array([0.0, -1, 0]) - along * (along @ [0.0, -1, 0])
        thumbwards /= np.linalg.norm(thumbwards)
        palm = np.cross(along, thumbwards) * sign
        for name in fingers:
            above = f"{side}_hand"
            if extras:
                joints[f"{side}_{name}_palm"] = (wrist + 2 * along - 0.2 * FINGERS[name] * thumbwards, above)
                above = f"{side}_{name}_palm"
            at = wrist + 9 * along - FINGERS[name] * thumbwards
            _finger(joints, f"{side}_{name}", above, at, (along, palm), (4.2, 2.6, 2.0), curl)
        if thumb:
            aside = skeleton.normalize(along + 0.9 * thumbwards)
            root = wrist + 2.5 * along + 2 * thumbwards
            _finger(joints, f"{side}_thumb", f"{side}_hand", root, (aside, palm), (4, 3, 2.5), 0)
        if extras:
            joints[f"{side}_prop"] = (wrist + 8 * along + 3 * palm, f"{side}_hand")
            joints[f"{side}_prop_end"] = (wrist + 90 * along + 3 * palm, f"{side}_prop")
            joints[f"{side}_socket"] = (wrist + 5 * along, f"{side}_hand")
    return Body(joints, whole.chains)


def _finger(joints: dict, name: str, above: str, at, plane, lengths, curl: float) -> None:
    for link, length in enumerate((*lengths, 0.0), 1):
        joints[f"{name}{link}"] = (at, above)
        above = f"{name}{link}"
        angle = np.radians(curl * (link - 1))
        at = at + length * (np.cos(angle) * plane[0] + np.sin(angle) * plane[1])
