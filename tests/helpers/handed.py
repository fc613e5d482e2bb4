"""Hands and a pelvis that move smoothly, for tests of what carries them."""

import numpy as np
from bodies import pose
from s2ag.core.motion import handshape, quaternion, skeleton
from s2ag.core.motion.hands import FOREARMS, Hands
from s2ag.core.motion.pelvis import Pelvis
from s2ag.rigs import fingers
from s2ag.rigs.goals import SIDES, Goals, Options
from s2ag.rigs.retarget import rotations


def hands(directions: np.ndarray, fps: float = 15.0) -> Hands:
    """Wrists that bend by up to 25 degrees and turn with the arms ``(frames, 9, 3)``, fingers that open and close."""
    time = np.arange(len(directions)) / fps
    fore = directions[:, FOREARMS]
    inward = np.array([[1.0, 0.3, 0.2], [-1.0, 0.3, 0.2]])
    bend = 0.4 * np.sin(2 * np.pi * 0.5 * time)[:, None, None]
    waves = np.sin(2 * np.pi * 0.4 * time[:, None, None] + np.arange(12) + np.arange(2)[:, None])
    return Hands.of(fore + bend * inward, inward - 0.3 * bend * fore, handshape.RELAXED + 9 * waves)


def pelvis(frames: int, fps: float = 15.0) -> Pelvis:
    """Weight that goes from one foot to the other and back in four seconds."""
    wave = np.sin(2 * np.pi * 0.25 * np.arange(frames) / fps)[:, None]
    place = wave * [0.05, 0.01, 0.01] + [0, 0.01, 0]
    return Pelvis(place.astype(np.float32), (wave * [0.01, 0.04, 0.06]).astype(np.float32))


def read_back(bones, mapping, side: str, heads: np.ndarray, palm: np.ndarray, usable=None) -> tuple[np.ndarray, np.ndarray]:
    """Knuckles and palm's normal (frames, 3) that posed ``heads`` (frames, n, 3) show; ``palm`` (3,) is the normal at rest.

    ``usable`` as in :func:`fingers.find_hand`."""
    hand = fingers.find_hand(bones, mapping, side, usable)
    wrist = bones.row(mapping.chains[f"{side}_hand"][0])

    def shown(at):
        roots = at[..., [chain[0] for chain in hand.fingers], :]
        along = roots.mean(-2) - at[..., wrist, :]
        return skeleton.normalize(along), skeleton.normalize(np.cross(roots[..., 0, :] - roots[..., -1, :], along))

    along, normal = shown(heads)
    return along, normal * np.sign(shown(bones.heads)[1] @ palm)


def within_reach(bones, mapping, frame, directions: np.ndarray, size: float = 15.0, seed: int = 0, free=None) -> Hands:
    """Hands that wrists and forearms can have on these arms: as they hang on them, each turned by up to ``size`` degrees.

    ``free`` as in :class:`Goals`.
    """
    goals = Goals(bones, mapping, directions, options=Options(clear_body=False, palms=0.0), frame=frame, free=free)
    _, orientations = pose(bones, rotations(goals))
    found = []
    for place, side in enumerate(SIDES):
        palm, row = goals.hand(side), bones.row(mapping.chains[f"{side}_forearm"][-1])
        turned = orientations[:, row] @ bones.matrices[row, :3, :3].T
        time = np.arange(len(directions))[:, None] / 9.0 + np.arange(3) + place + seed
        turn = np.radians(size) * np.sin(time) / np.sqrt(3)
        angle = np.linalg.norm(turn, axis=-1)
        q = quaternion.about(turn / angle[:, None], angle)
        seen = (turned @ palm.knuckles, turned @ palm.normal)
        found.append([skeleton.blender_to_canonical(quaternion.rotate(q, way) @ frame.T) for way in seen])
    along, normal = (np.stack([one[part] for one in found], 1) for part in (0, 1))
    return Hands.of(along, normal, hands(directions).shape)
