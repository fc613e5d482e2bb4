"""S2AG, its two ablations and GTC: one generator in four configurations, and its discriminator (reference sections A, C)."""

from typing import cast

import torch

from ...model.config import ModelConfig
from ...model.discriminator import Discriminator
from ...model.generator import Generator
from ..train import losses
from ..train.step_modules import DiscriminatorStep, GeneratorStep
from .sample import Sample, WordTable, word_vectors
from .system import Generated, System

HUBER, ADVERSARIAL, DIVERSITY, DIVERGENCE = 500.0, 5.0, 0.05, 0.1


class Adversarial(System):
    """Trained with Huber, adversarial, style-diversity and divergence terms with the published weights.

    ``warm_up`` is the initial share of the training without discriminator, as in the public code. ``diversity_share`` is
    the part of a batch that is also generated in another style; all of it in the public code. With ``foreign_ids`` every
    sample gets the id of a speaker who is not in its batch (of any speaker if all are in it), as in the public code of
    S2AG, whose speaker table thus learns nothing about its speakers (reference A.11, 15). ``judge`` selects the
    discriminator: "" the generator's own kind, "graph" S2AG's, "raw" GTC's, "none" no adversarial term; ``judge_sizes`` has
    its widths, those of the generator's ``config`` if None.
    """

    knows_speakers = True

    def __init__(
        self,
        config: ModelConfig,
        vectors: torch.Tensor,
        warm_up: float = 0.0,
        diversity_share: float = 1.0,
        foreign_ids: bool = False,
        judge: str = "",
        judge_sizes: ModelConfig | None = None,
    ):
        super().__init__()
        self.config, self.warm_up = config, warm_up
        self.diversity_share, self.foreign_ids = diversity_share, foreign_ids
        self.performer = GeneratorStep(Generator(config))
        if judge != "none":
            judged = (judge_sizes or config).replace(affect=judge or config.affect)
            self.judge = DiscriminatorStep(Discriminator(judged), together=False)
        table = word_vectors(vectors, trained=bool(config.words))
        if config.words:
            self.generator.text_encoder.embedding.weight.data.copy_(table)
        self.table = None if config.words else WordTable(table, trained=False)

    @property
    def generator(self) -> Generator:
        """The gesture generator."""
        return cast(GeneratorStep, self.performer).generator

    def make(self, sample: Sample, progress: float) -> Generated:
        """Generate in the speaker's style, and a part of the batch also in another style."""
        ids = self._ids(sample)
        others = round(len(ids) * self.diversity_share)
        result = self.performer(*self._inputs(sample), sample.seeds, None, ids, ids.new_empty(len(ids), 0), others)
        return Generated(result.directions, result)

    def terms(self, sample: Sample, made: Generated, progress: float) -> dict[str, torch.Tensor]:
        """Return the published terms (paper eq. 15 and 17)."""
        extra = made.extra
        terms = {
            "huber": HUBER * losses.huber(made.directions, sample.directions),
            "divergence": DIVERGENCE * losses.divergence(extra.mu, extra.logvar),
        }
        count = len(extra.other)
        if count:
            diversity = losses.diversity(made.directions[:count], extra.other, extra.style[:count], extra.other_style)
            terms["diversity"] = DIVERSITY * diversity
        if self.judge_active(progress):
            judge = cast(DiscriminatorStep, self.judge)
            judge.requires_grad_(False)
            terms["adversarial"] = ADVERSARIAL * losses.adversarial(judge.discriminator(made.directions))
            judge.requires_grad_(True)
        return terms

    def judge_active(self, progress: float) -> bool:
        """Whether the discriminator is in use: after the warm-up."""
        return self.judge is not None and progress >= self.warm_up

    def judge_loss(self, sample: Sample, made: torch.Tensor) -> torch.Tensor:
        """Return the discriminator's loss (paper eq. 16)."""
        assert self.judge is not None
        return losses.discriminator(*self.judge(sample.directions, made))

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate in a style sampled from the speaker's distribution, as the public code does in evaluation, too."""
        style = self.generator.sample_style(*self.generator.speaker(sample.speaker))
        return self.generator(*self._inputs(sample), sample.seeds, style)

    def _inputs(self, sample: Sample) -> tuple[torch.Tensor, torch.Tensor]:
        words = sample.words if self.table is None else self.table(sample.words)
        if self.config.audio == "wave":
            return sample.wave, words
        return sample.mfcc if self.config.mfcc_axis == "coefficient" else sample.mfcc.transpose(1, 2), words

    def _ids(self, sample: Sample) -> torch.Tensor:
        if not self.foreign_ids:
            return sample.speaker
        speakers = torch.arange(self.config.speakers, device=sample.speaker.device)
        absent = speakers[~torch.isin(speakers, sample.speaker)]
        absent = absent if len(absent) else speakers
        return absent[torch.randint(len(absent), sample.speaker.shape, device=speakers.device)]
