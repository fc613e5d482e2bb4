"""Means of a step's figures between two log lines, and a watch over the balance of the two networks."""

import torch

PATIENCE = 200
"""Steps that a state of the discriminator must last before it is reported."""
WINS = 0.95
DEAD = 0.01


class Means:
    """Running means of scalar tensors, left on their device until they are read."""

    def __init__(self):
        self._sums: dict[str, torch.Tensor] = {}
        self.count = 0

    def add(self, values: dict[str, torch.Tensor]) -> None:
        """One step's figures."""
        for name, value in values.items():
            self._sums[name] = self._sums[name] + value if name in self._sums else value.clone()
        self.count += 1

    def take(self) -> dict[str, float]:
        """Means of all that was added since the last call."""
        means = {name: round(float(value) / self.count, 4) for name, value in self._sums.items()}
        self._sums, self.count = {}, 0
        return means


class Watch:
    """Warns once when the discriminator has won for a while, and once when it no longer tells real from generated."""

    def __init__(self):
        self._lasted = {"wins": 0, "dead": 0}

    def look(self, means: dict[str, float], steps: int) -> list[str]:
        """Sentences to report after ``steps`` more steps with these ``means`` of :meth:`Trainer.step`."""
        now = {
            "wins": (means["right_real"] + means["right_made"]) / 2 > WINS,
            "dead": abs(means["judged_real"] - means["judged_made"]) < DEAD,
        }
        news = []
        for name, holds in now.items():
            before = self._lasted[name]
            if before < PATIENCE:
                self._lasted[name] = before + steps if holds else 0
                if self._lasted[name] >= PATIENCE:
                    news.append(_NEWS[name])
        return news


_NEWS = {
    "wins": f"The discriminator is right in over {WINS:.0%} of all cases: its term no longer teaches the generator. "
    "Lower discriminator_rate or real_label.",
    "dead": "The discriminator no longer tells real from generated. Raise discriminator_rate.",
}
