"""Many short recordings by the neural voice, with a manifest: ``python tests/helpers/short_clips.py FOLDER COUNT [FILMS]``."""

import itertools
import json
import sys
from pathlib import Path

import numpy as np
from s2ag.core.learning.corpus.texts import Sentence
from s2ag.core.learning.corpus.voices import Manner, voice
from sounds import write_wav

STARTS = ("I think", "We know", "They say", "You see", "She told me", "He hopes", "Nobody doubts", "My friends believe")
MIDDLES = ("that this idea", "that the big house", "that our little plan", "that the road to the lake", "that every good story")
ENDS = ("changes everything", "will take some time", "goes from here to there", "is not what it was", "needs three more people")


def make(folder: Path, count: int, films: int) -> Path:
    """Write ``count`` recordings and transcripts and a manifest in which ``films`` of them are filmed; gives its path."""
    folder.mkdir(parents=True, exist_ok=True)
    speaker = voice("piper")
    rows = []
    for number, words in enumerate(itertools.islice(itertools.product(STARTS, MIDDLES, ENDS), count), 1):
        text = " ".join(words) + "."
        said, _ = speaker.say(Sentence(text, tuple(text[:-1].lower().split()), (0.5, 0.5, 0.5), 0), Manner(1.1))
        write_wav(folder / f"{number:04d}.wav", 0.9 * said / np.abs(said).max())
        filmed = {"outputs": ["bvh", "mp4"], "resolution": "320x180"} if number <= films else {"outputs": ["bvh"]}
        rows.append({"name": f"clip{number:04d}", "audio": f"{number:04d}.wav", "text": text, "seed": number, **filmed})
    manifest = folder / "clips.jsonl"
    manifest.write_text("".join(json.dumps(row) + "\n" for row in rows), "utf-8")
    return manifest


if __name__ == "__main__":
    print(make(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 0))
