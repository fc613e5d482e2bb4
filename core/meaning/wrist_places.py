"""From places of a wrist beside its shoulder to the directions of the arm that reaches them."""

import numpy as np

from ..motion import skeleton

_UPPER, _FORE = (float(skeleton.LENGTHS[edge]) for edge in skeleton.ARMS[0])
_ELBOW = skeleton.normalize(np.array([-0.45, 1.0, -0.25]))
"""Where elbows hang: down, a little outward and back."""
_SHORTEST, _LONGEST = 0.16, _UPPER + _FORE - 0.01


def reach(places: np.ndarray) -> np.ndarray:
    """Return directions ``(n, 2, 3)`` of the left upper arm and forearm whose wrist is at ``places`` ``(n, 3)``.

    Places are metres outward, up and forward from the shoulder; those out of reach are approached."""
    target = np.asarray(places, float) * (-1.0, -1.0, 1.0)
    far = np.linalg.norm(target, axis=1, keepdims=True)
    toward = np.where(far > 1e-6, target / np.maximum(far, 1e-6), (0.0, 0.0, 1.0))
    far = np.clip(far, _SHORTEST, _LONGEST)
    along = (_UPPER**2 + far**2 - _FORE**2) / (2 * far)
    aside = skeleton.normalize(_ELBOW - (toward @ _ELBOW)[:, None] * toward)
    elbow = along * toward + np.sqrt(np.maximum(_UPPER**2 - along**2, 0)) * aside
    return skeleton.normalize(np.stack([elbow, far * toward - elbow], 1))
