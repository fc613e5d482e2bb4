"""Twenty phrases and their neutral twins in one recording, by the shipped network: what is meant is seen, with figures.

``pytest tests/core/synthesis/test_phrases.py -rP`` prints them.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from s2ag.core.motion import handshape, skeleton
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session

TWINS = {
    "no idea": "blue table",
    "i don't know": "i don't eat",
    "who knows": "who walks",
    "maybe": "monday",
    "no": "soon",
    "never": "lever",
    "not at all": "not at noon",
    "of course not": "of coarse wool",
    "this big": "this green",
    "huge": "green",
    "so much": "so blue",
    "tiny": "wooden",
    "this small": "this warm",
    "stop it": "stack it",
    "hold on": "fold up",
    "first of all": "coast of wales",
    "second,": "seven",
    "number three": "number plate",
    "over there": "over night",
    "as for me": "as for tea",
}
STARTS = (2.0, 6.2, 10.4)
"""Seconds of the recording at which phrases are said, three in a row."""
TAKES = 6
"""Performances of the same: whether a phrase is shown is up to chance and style."""


def performed(folder, examples, said) -> list:
    """Motions of ``said``, a phrase for each of the starts, between words that mean nothing."""
    words = []
    for start, phrase in zip(STARTS, said, strict=False):
        words += [("so.", start - 0.6, start - 0.4)]
        text = f"{phrase}.".split() if phrase else ()
        words += [(word, start + 0.32 * place, start + 0.32 * place + 0.3) for place, word in enumerate(text)]
        words += [("and", start + 2.0, start + 2.2)]
    path = folder / "words.json"
    path.write_text(json.dumps(words))
    request = Request(examples / "hello.flac", transcript=path, style="sales rep", seed=1, takes=TAKES, hands=1.0)
    session = Session()
    first = {name: forms[:1] for name, forms in session.vocabulary.forms.items()}
    session.vocabulary = replace(session.vocabulary, forms=first)
    return session.synthesize(request).motions


def figures(motion, lands: float) -> dict:
    """What is seen a tenth of a second after a stroke has landed; the head around it."""
    at = round((lands + 0.1) * skeleton.FPS)
    points = skeleton.to_positions(motion.directions)[at]
    around = motion.directions[round((lands - 0.3) * skeleton.FPS) : round((lands + 0.9) * skeleton.FPS)]
    face = around[:, 1] - around[:, 2]
    yaw = np.degrees(np.arctan2(face[:, 0], face[:, 2]))
    wrists, shoulders = points[[6, 9]], points[[4, 7]]
    return {
        "apart": float(np.linalg.norm(wrists[0] - wrists[1])),
        "turns": float(np.abs(np.diff(yaw)).sum()),
        "palms up": -motion.hands.palms[at, :, 1],
        "shoulders": float(points[0, 1] - shoulders[:, 1].mean()),
        "reach": np.linalg.norm(wrists - shoulders, axis=-1),
        "aside": wrists[:, 0] * [-1, 1],
        "forward": wrists[:, 2] - shoulders[:, 2],
        "high": shoulders[:, 1] - wrists[:, 1],
        "straight": (handshape.columns(motion.hands.shape[at], "base") < 35).sum(-1),
    }


SEEN = {
    "shrug": lambda one, twin: one["palms up"].min() > 0.7 and one["shoulders"] > twin["shoulders"] + 0.03,
    "negation": lambda one, twin: one["turns"] > max(twin["turns"], 50),
    "big": lambda one, twin: one["apart"] > 0.9,
    "small": lambda one, twin: one["apart"] < 0.3,
    "refusal": lambda one, twin: one["forward"].min() > 0.45 and one["high"].min() > -0.2,
    "one": lambda one, twin: one["straight"].min() == 1 and one["high"].max() > -0.15,
    "two": lambda one, twin: one["straight"].min() == 2 and one["high"].max() > -0.15,
    "three": lambda one, twin: one["straight"].min() == 3 and one["high"].max() > -0.15,
    "there": lambda one, twin: one["straight"].min() == 1 and one["aside"].max() > 0.5 and one["reach"].max() > 0.6,
    "me": lambda one, twin: one["reach"].min() < 0.42 and one["aside"].min() < 0.1,
}
"""Gesture -> whether a performance of the phrase shows it, beside the same performance of the twin."""


@pytest.mark.slow
def test_every_phrase_differs_from_its_neutral_twin_as_meant(examples, tmp_path):
    phrases = list(TWINS)
    for first in range(0, len(phrases), len(STARTS)):
        said = phrases[first : first + len(STARTS)]
        takes, neutral = (performed(tmp_path, examples, each) for each in (said, [TWINS[one] for one in said]))
        for start, phrase in zip(STARTS, said, strict=False):
            shown = [
                (take, name, lands)
                for take, motion in enumerate(takes)
                for name, lands in motion.meta.get("shows", ())
                if start < lands < start + 1.2
            ]
            assert shown, phrase
            assert not [one for motion in neutral for one in motion.meta.get("shows", ()) if start < one[1] < start + 1.2]
            print(f"{phrase}: {shown[0][1]}, in {len(shown)} of {TAKES} takes")
            fits = []
            for take, name, lands in shown:
                one, twin = (figures(motions[take], lands) for motions in (takes, neutral))
                fits.append(SEEN[name](one, twin))
                for what, values in one.items():
                    print(f"    {what:10} {np.round(values, 2)}, twin {np.round(twin[what], 2)}")
            assert np.mean(fits) > 0.5, (phrase, fits)
