"""Evaluation of existing checkpoints on any data set: the authors' S2AG and GTC, and those written by a bench."""

from collections.abc import Sequence
from typing import cast

import torch

from ...errors import UsageError
from ...model.checkpoint import Checkpoint
from ...model.encoders import Encoders
from ...model.table_features import word_row
from ...model.wave_encoder import FRAMES
from .lengths import PUBLISHED, Lengths
from .sample import SPECIAL, Sample
from .system import System


class Imported(System):
    """The generator of a checkpoint with a word table and windows of 34 frames; it cannot be trained.

    ``words`` and ``speakers`` are the data set's, in the order of its ids. Words that the checkpoint lacks become its
    unknown word; without a vocabulary all words are ignored. ``known``: whether the checkpoint has all the speakers.
    Raises :class:`UsageError` for networks of another kind and windows of other ``lengths``.
    """

    knows_speakers = True
    rows: torch.Tensor
    own: torch.Tensor

    def __init__(
        self, checkpoint: Checkpoint, words: Sequence[str], speakers: Sequence[str], lengths: Lengths = PUBLISHED
    ):
        super().__init__()
        if not lengths.published:
            message = f"A network that was trained elsewhere performs windows of {PUBLISHED}: these have {lengths}."
            raise UsageError(message, "Judge it with the windows of the public codes.")
        config = checkpoint.config
        if not config.words or config.frames != FRAMES:
            message = f"A network of the kind {config.name!r} does not perform windows of {FRAMES} frames."
            raise UsageError(message, "Perform the talks with s2ag synth, and judge the folder of motions.")
        self.performer, self.config, self.speakers = checkpoint.generator, config, config.speakers
        vocabulary = checkpoint.meta.get("vocabulary")
        rows: dict[str, int] = {word: number for number, word in enumerate(vocabulary or ()) if word}
        word_rows = [word_row(word, rows) if rows else 0 for word in words]
        special = list(range(SPECIAL)) if rows else [0] * SPECIAL
        self.register_buffer("rows", torch.tensor(special + word_rows), persistent=False)
        names = [speaker["name"] for speaker in checkpoint.speakers]
        self.known = set(speakers) <= set(names)
        own = [names.index(name) if name in names else 0 for name in speakers]
        self.register_buffer("own", torch.tensor(own), persistent=False)

    def ids(self, speaker: torch.Tensor) -> torch.Tensor:
        """Convert the data set's speaker ids to the checkpoint's."""
        return self.own[speaker]

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate in a style sampled from the speaker's distribution."""
        generator = cast(Encoders, self.performer)
        style = generator.sample_style(*generator.speaker(sample.speaker))
        audio = sample.wave if self.config.audio == "wave" else sample.mfcc
        return generator(audio, self.rows[sample.words], sample.seeds, style)
