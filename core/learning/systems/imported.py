"""Weights that were trained elsewhere: the authors' S2AG and GTC, and those that a bench writes, on any data set's windows."""

from collections.abc import Sequence

import torch

from ...errors import UsageError
from ...model.checkpoint import Checkpoint
from ...model.table_words import row
from ...model.wave_encoder import FRAMES
from .lengths import PUBLISHED, Lengths
from .sample import SPECIAL, Sample
from .system import System


class Imported(System):
    """The generator of a checkpoint with a word table and windows of 34 frames; it cannot be trained.

    ``words`` and ``speakers`` are the data set's, in the order of its ids. Words that the checkpoint lacks are its unknown
    one; of a checkpoint without vocabulary no word is heard. ``known``: whether all the speakers are the checkpoint's, too.
    Raises :class:`UsageError` for networks of another kind and windows of other ``lengths``.
    """

    knows_speakers = True

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
        rows = {word: number for number, word in enumerate(vocabulary or ()) if word}
        known = [row(word, rows) if rows else 0 for word in words]
        special = list(range(SPECIAL)) if rows else [0] * SPECIAL
        self.register_buffer("rows", torch.tensor(special + known), persistent=False)
        names = [one["name"] for one in checkpoint.speakers]
        self.known = set(speakers) <= set(names)
        own = [names.index(name) if name in names else 0 for name in speakers]
        self.register_buffer("own", torch.tensor(own), persistent=False)

    def ids(self, speaker: torch.Tensor) -> torch.Tensor:
        """The checkpoint's rows of the data set's speakers."""
        return self.own[speaker]

    def perform(self, sample: Sample) -> torch.Tensor:
        """In a style drawn from the speaker's distribution."""
        generator = self.performer
        style = generator.sample_style(*generator.speaker(sample.speaker))
        heard = sample.wave if self.config.audio == "wave" else sample.mfcc
        return generator(heard, self.rows[sample.words], sample.seeds, style)
