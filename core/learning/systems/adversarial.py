"""S2AG, its two ablations and GTC: one generator in four configurations, and its discriminator (reference sections A, C)."""

import torch

from ...model.config import ModelConfig
from ...model.discriminator import Discriminator
from ...model.generator import Generator
from ..train import losses
from ..train.networks import Judge, Performer
from .sample import Sample, WordTable, word_vectors
from .system import Made, System

HUBER, ADVERSARIAL, DIVERSITY, DIVERGENCE = 500.0, 5.0, 0.05, 0.1


class Adversarial(System):
    """Huber, adversarial, style-diversity and divergence terms with the published weights.

    ``warm_up`` is the share of the training in which the discriminator neither learns nor is heard, as in the public codes.
    ``diversity_share`` is the part of a batch that is also made in another style; all of it in the public code. With
    ``foreign_ids`` every sample gets the id of a speaker who is not in its batch, as the public code of S2AG does: its
    speaker table then learns nothing of anybody (reference A.11, 15); where all speakers are in the batch, that of any of
    them. ``judge`` is "" for the discriminator that goes with
    the generator, "graph" for S2AG's, "raw" for GTC's, "none" for no adversarial term at all.
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
    ):
        super().__init__()
        self.config, self.warm_up = config, warm_up
        self.diversity_share, self.foreign_ids = diversity_share, foreign_ids
        self.performer = Performer(Generator(config))
        if judge != "none":
            self.judge = Judge(Discriminator(config.replace(affect=judge or config.affect)), together=False)
        table = word_vectors(vectors, trained=bool(config.words))
        if config.words:
            self.generator.text_encoder.embedding.weight.data.copy_(table)
        self.table = None if config.words else WordTable(table, trained=False)

    @property
    def generator(self) -> Generator:
        """The network that performs."""
        return self.performer.generator

    def make(self, sample: Sample, progress: float) -> Made:
        """A performance in the speaker's style, part of it once more in another's."""
        ids = self._ids(sample)
        others = round(len(ids) * self.diversity_share)
        made = self.performer(*self._heard(sample), sample.seeds, None, ids, ids.new_empty(len(ids), 0), others)
        return Made(made.directions, made)

    def terms(self, sample: Sample, made: Made, progress: float) -> dict[str, torch.Tensor]:
        """The published terms (paper eq. 15 and 17)."""
        extra = made.extra
        terms = {
            "huber": HUBER * losses.huber(made.directions, sample.directions),
            "divergence": DIVERGENCE * losses.divergence(extra.mu, extra.logvar),
        }
        count = len(extra.other)
        if count:
            apart = losses.diversity(made.directions[:count], extra.other, extra.style[:count], extra.other_style)
            terms["diversity"] = DIVERSITY * apart
        if self.judging(progress):
            self.judge.requires_grad_(False)
            terms["adversarial"] = ADVERSARIAL * losses.adversarial(self.judge.discriminator(made.directions))
            self.judge.requires_grad_(True)
        return terms

    def judging(self, progress: float) -> bool:
        """Once it is warm."""
        return self.judge is not None and progress >= self.warm_up

    def judge_loss(self, sample: Sample, made: torch.Tensor) -> torch.Tensor:
        """Paper eq. 16."""
        return losses.discriminator(*self.judge(sample.directions, made))

    def perform(self, sample: Sample) -> torch.Tensor:
        """In a style drawn from the speaker's distribution, as the public code does also in use."""
        style = self.generator.sample_style(*self.generator.speaker(sample.speaker))
        return self.generator(*self._heard(sample), sample.seeds, style)

    def _heard(self, sample: Sample) -> tuple[torch.Tensor, torch.Tensor]:
        words = sample.words if self.table is None else self.table(sample.words)
        if self.config.audio == "wave":
            return sample.wave, words
        return sample.mfcc if self.config.mfcc_axis == "coefficient" else sample.mfcc.transpose(1, 2), words

    def _ids(self, sample: Sample) -> torch.Tensor:
        if not self.foreign_ids:
            return sample.speaker
        every = torch.arange(self.config.speakers, device=sample.speaker.device)
        strangers = every[~torch.isin(every, sample.speaker)]
        strangers = strangers if len(strangers) else every
        return strangers[torch.randint(len(strangers), sample.speaker.shape, device=every.device)]
