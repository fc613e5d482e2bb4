"""Golden motions: what the shipped weights perform, stored once, against which every change of the code is compared.

``python tests/golden/remake.py`` stores them anew after a change that is meant to be seen.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from s2ag.core.editing.director import Director
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis.session import Request, Session

FOLDER = Path(__file__).resolve().parents[1] / "golden"
MOTIONS, KEYS, TAKE = FOLDER / "motions.npz", FOLDER / "keys.npz", FOLDER / "take.npz"
"""Sampled motions, sampled keys on three rigs, and the whole take that is keyed."""
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STEPS = {"hello": 5, "sonnet": 25}
"""Of how many frames one is stored, by voice."""
FACE_STEP = 60
RIGS = ("mannequin", "human", "human:rigify")
_LEVELS = 32000
EDITS = {
    "moved": [{"do": "reroll", "from": 2.0, "to": 4.0, "seed": 2}, {"do": "add", "at": 7.0, "kind": "beat", "hand": "right"}],
    "styled": [{"do": "style", "at": 6.0, "style": "calm lecturer"}, {"do": "add", "word": "idea", "kind": "small"}],
    "placed": [{"do": "place", "from": 5.0, "to": 6.0, "hand": "left", "place": [-0.3, -0.35, 0.35]}],
}
"""Documents of edits that are done to takes of the shipped voice."""
SETTINGS = {
    "loud": {"intensity": 1.4, "mirror": True, "affect": {"arousal": 0.8, "valence": -0.5}},
    "quiet": {"intensity": 0.7, "rate": -0.6, "hand": -1.0, "affect": {"dominance": 0.7}, "meaning": 0.5},
    "curves": {"curves": {"arousal": [[0.0, -0.6], [10.0, 0.9]], "intensity": [[0.0, 1.0], [12.0, 0.5]]}},
    "walk": {"style": "stern > excited teenager", "face_smoothness": 0.9},
    "listener": {"listen": True, "toward": 40.0},
}
"""Requests of the shipped voice that use the other settings."""


def recordings(shared: Path | None) -> dict[str, dict]:
    """Fields of a :class:`Request` for each voice: the shipped one and, where ``shared`` is there, a reading of a sonnet."""
    voices = {"hello": {"audio": EXAMPLES / "hello.flac", "transcript": EXAMPLES / "hello.txt"}}
    if shared is not None:
        page = (shared / "speech" / "p001.xhtml").read_text("utf-8")
        lines = re.findall(r"<span[^>]*>([^<]+)</span>", page)
        voices["sonnet"] = {"audio": shared / "speech" / "p001.mp3", "text": "\n".join(lines)}
    return voices


def perform(shared: Path | None) -> Iterator[tuple[str, int, Motion]]:
    """Name, step and motion of every golden performance: all styles on every voice, other settings, and takes with edits."""
    session, whole = Session(cache="off"), {"hands": 1.0, "stance": 1.0, "face": 1.0}
    for voice, fields in recordings(shared).items():
        requests = [Request(**fields, **whole, style=style["name"], seed=1) for style in session.styles()]
        for request, result in zip(requests, session.synthesize_all(requests), strict=True):
            yield f"{voice}/{request.style}", STEPS[voice], result.motions[0]
    hello = recordings(None)["hello"]
    for name, settings in SETTINGS.items():
        request = Request(**hello, **{**whole, **settings}, seed=3)
        yield f"settings/{name}", STEPS["hello"], session.synthesize(request).motions[0]
    director = Director(Session(cache="off"))
    for name, edits in EDITS.items():
        motion = director.direct(Request(**hello, **whole, style="warm host", seed=2), edits).motions[0]
        yield f"edits/{name}", STEPS["hello"], motion


def arrays(motion: Motion) -> dict[str, np.ndarray]:
    """All that is compared of a motion, frame by frame."""
    assert motion.hands is not None and motion.pelvis is not None and motion.face is not None
    parts = {name: getattr(motion.hands, name) for name in ("knuckles", "palms", "shape")}
    parts |= {"directions": motion.directions, "place": motion.pelvis.place, "turn": motion.pelvis.turn}
    return {**parts, "face": motion.face.weights}


def sampled(motion: Motion, step: int) -> dict[str, np.ndarray]:
    """Every ``step``-th frame of a motion's arrays, and of its face."""
    return {name: values[:: FACE_STEP if name == "face" else step] for name, values in arrays(motion).items()}


def pack(named: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays as whole numbers of 16 bits, each beside the size of one level (``NAME:level``)."""
    packed = {}
    for name, values in named.items():
        level = max(float(np.abs(values).max(initial=0)), 1e-6) / _LEVELS
        packed[name], packed[f"{name}:level"] = np.round(values / level).astype(np.int16), np.float64(level)
    return packed


def assert_equal(named: dict[str, np.ndarray], stored: dict[str, np.ndarray], bound: float) -> None:
    """Assert that arrays are those that were :func:`pack` ed, within half a level and ``bound`` of their largest value or 1."""
    for name, values in named.items():
        level = float(stored[f"{name}:level"])
        expected = stored[name] * level
        assert values.shape == expected.shape, f"{name} has shape {values.shape}, not {expected.shape}"
        size = max(level * _LEVELS, 1.0)
        np.testing.assert_allclose(values, expected, rtol=0, atol=0.5001 * level + bound * size, err_msg=name)


def described(motion: Motion) -> str:
    """The motion's provenance as text, without where it ran."""
    return json.dumps(motion.meta, sort_keys=True)
