"""The skeleton (ten joints, nine edges) and all conversions between coordinate systems.

Canonical frame (that of the TED Gesture data, reference section B.3): right-handed, x towards the character's right,
y down, z forward, so the left arm lies at -x. A *direction* is a unit vector from an edge's parent joint to its child
joint. Arrays end in ``(9, 3)`` for directions and ``(10, 3)`` for positions; any leading axes are kept."""

import numpy as np

JOINTS = (
    "spine", "neck", "nose", "head",
    "left_shoulder", "left_elbow", "left_wrist", "right_shoulder", "right_elbow", "right_wrist",
)  # fmt: skip
EDGES = ((0, 1), (1, 2), (2, 3), (1, 4), (4, 5), (5, 6), (1, 7), (7, 8), (8, 9))
EDGE_NAMES = (
    "torso", "neck", "head",
    "left_clavicle", "left_upper_arm", "left_forearm", "right_clavicle", "right_upper_arm", "right_forearm",
)  # fmt: skip
ARM_EDGES = (4, 5, 7, 8)
"""Upper arm and forearm, left then right."""
ARMS = (ARM_EDGES[:2], ARM_EDGES[2:])
"""The same, grouped by arm."""
HEAD = (1, 2)
"""Neck and head."""
LENGTHS = np.array([0.26, 0.18, 0.14, 0.22, 0.36, 0.33, 0.22, 0.36, 0.33], np.float32)
FPS = 15.0
MEAN = np.array(
    [
        [0.0154009, -0.9690125, -0.0884354],
        [-0.0022264, -0.8655276, 0.4342174],
        [-0.0035145, -0.8755367, -0.4121039],
        [-0.9236511, 0.3061306, -0.0012415],
        [-0.5155854, 0.8129665, 0.0871897],
        [0.2348464, 0.1846561, 0.8091402],
        [0.9271948, 0.2960011, -0.013189],
        [0.5233978, 0.8092403, 0.0725451],
        [-0.2037076, 0.1924306, 0.8196916],
    ],
    np.float32,
)
"""Mean directions of the TED Gesture training set; not unit vectors (reference section B.1)."""

MIRRORED_EDGES = np.array([0, 1, 2, 6, 7, 8, 3, 4, 5])
_PARENT, _CHILD = np.array(EDGES).T
_TO_BLENDER = np.array([[-1, 0, 0], [0, 0, -1], [0, -1, 0]], np.float32)
_TO_Y_UP = np.array([[-1, 0, 0], [0, -1, 0], [0, 0, 1]], np.float32)
_MIRROR = np.array([-1, 1, 1], np.float32)


def length(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths ``(...)`` of vectors ``(..., n)``; of short ones three times as fast as by :mod:`numpy.linalg`."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


def normalize(vectors: np.ndarray) -> np.ndarray:
    """Scale vectors along the last axis to unit length; zero vectors stay zero."""
    vectors = np.asarray(vectors)
    far = length(vectors)[..., None]
    return vectors / np.where(far > 0, far, far.dtype.type(1))


MEAN_UNIT = normalize(MEAN)
""":data:`MEAN` as unit vectors."""
REST = MEAN_UNIT.copy()
REST[list(ARM_EDGES)] = normalize(
    np.array([[-0.23, 0.97, -0.02], [-0.08, 0.95, 0.30], [0.23, 0.97, -0.02], [0.08, 0.95, 0.30]], np.float32)
)
"""Rest pose: the trunk as in the mean, the arms hanging with slightly bent elbows."""


def wrists(directions: np.ndarray) -> np.ndarray:
    """Return the wrists ``(..., 2, 3)``, left and right, in metres from their shoulders, of unit directions ``(..., 9, 3)``."""
    steps = np.asarray(directions, float) * LENGTHS[:, None]
    return np.stack([steps[..., upper, :] + steps[..., fore, :] for upper, fore in ARMS], -2)


def to_positions(directions: np.ndarray, lengths: np.ndarray = LENGTHS) -> np.ndarray:
    """Return joint positions ``(..., 10, 3)`` of directions ``(..., 9, 3)``, with the spine at the origin (paper eq. 11).

    Directions are normalised first, so bone lengths hold for any input; ``lengths`` are metres."""
    steps = np.moveaxis(normalize(directions) * np.asarray(lengths)[:, None], -2, 0)
    positions = np.zeros((len(JOINTS), *steps.shape[1:]), steps.dtype)
    for step, (parent, child) in zip(steps, EDGES, strict=True):
        np.add(positions[parent], step, out=positions[child])
    return np.moveaxis(positions, 0, -2)


def bent_limb(reach: np.ndarray, joint: np.ndarray, upper: float, lower: float, most: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions ``(frames, 3)`` of a limb's two bones, so long, that end ``reach`` ``(frames, 3)`` from its root,
    as far as ``most`` of their lengths allow, bent to the side of ``joint`` ``(frames, 3)`` (law of cosines)."""
    size = length(reach)[..., None]
    along = reach / np.maximum(size, 1e-9)
    size = np.clip(size, 1.01 * abs(upper - lower), most * (upper + lower))
    cosine = (upper**2 + size**2 - lower**2) / (2 * upper * size)
    aside = normalize(joint - along * np.sum(joint * along, -1, keepdims=True))
    first = cosine * along + np.sqrt(np.maximum(1 - cosine**2, 0)) * aside
    return first, normalize(size * along - upper * first)


def to_directions(positions: np.ndarray) -> np.ndarray:
    """Return unit directions ``(..., 9, 3)`` of joint positions ``(..., 10, 3)``."""
    positions = np.asarray(positions)
    return normalize(positions[..., _CHILD, :] - positions[..., _PARENT, :])


def mirror(directions: np.ndarray) -> np.ndarray:
    """Mirror directions: reflect them and swap left and right. Its own inverse."""
    return np.asarray(directions)[..., MIRRORED_EDGES, :] * _MIRROR


def canonical_to_blender(vectors: np.ndarray) -> np.ndarray:
    """Convert canonical vectors to Blender's frame (z up, character facing -y, left at +x), a proper rotation."""
    return np.asarray(vectors) @ _TO_BLENDER.T


def blender_to_canonical(vectors: np.ndarray) -> np.ndarray:
    """Inverse of :func:`canonical_to_blender`."""
    return np.asarray(vectors) @ _TO_BLENDER


def canonical_to_y_up(vectors: np.ndarray) -> np.ndarray:
    """Convert canonical vectors to y up, z forward, left at +x (BVH, SmartBody, Trinity), a half turn about z."""
    return np.asarray(vectors) @ _TO_Y_UP.T


def y_up_to_canonical(vectors: np.ndarray) -> np.ndarray:
    """Inverse of :func:`canonical_to_y_up`."""
    return np.asarray(vectors) @ _TO_Y_UP


def rotate_about_axis(vectors: np.ndarray, axis: int, degrees: np.ndarray) -> np.ndarray:
    """Rotate vectors ``(frames, ..., 3)`` about a coordinate axis by angles ``(frames,)`` in degrees."""
    angle = np.radians(degrees).reshape(-1, *[1] * (vectors.ndim - 2))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    result = vectors.copy()
    result[..., u] = np.cos(angle) * vectors[..., u] - np.sin(angle) * vectors[..., v]
    result[..., v] = np.sin(angle) * vectors[..., u] + np.cos(angle) * vectors[..., v]
    return result
