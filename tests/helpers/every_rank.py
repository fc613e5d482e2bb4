"""Run by torchrun: train as the command line does; each process leaves its weights and first windows in the run's folder."""

import json
import os
import sys

from s2ag.core.learning.train import loop
from s2ag.core.learning.train.config import TrainConfig
from safetensors.torch import save_file


class Told(loop.TrainingRun):
    """A run whose every process tells what it holds in the end."""

    def save(self):
        super().save()
        trainer = self.trainer
        parts = {"generator": trainer.generator, "discriminator": trainer.discriminator, "average": trainer.average}
        tensors = {f"{name}.{key}": value for name, part in parts.items() for key, value in part.state_dict().items()}
        tensors["windows"] = trainer.corpus.finish(trainer._prepare(0)[0]).directions
        save_file(tensors, self.config.out_path / f"{os.environ['RANK']}.safetensors")


loop.TrainingRun = Told
loop.train(TrainConfig.from_dict(json.loads(sys.argv[1])))
