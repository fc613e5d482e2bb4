"""Means of training metrics between log lines, and warnings about the balance of generator and discriminator."""

import torch

PATIENCE_STEPS = 200
"""Steps that a problem must last before it is reported."""
WINS = 0.95
DEAD = 0.01


class Means:
    """Running means of scalar tensors, which stay on their device until they are read."""

    def __init__(self):
        self._sums: dict[str, torch.Tensor] = {}
        self.count = 0

    def add(self, values: dict[str, torch.Tensor]) -> None:
        """Add the metrics of a step."""
        for name, value in values.items():
            self._sums[name] = self._sums[name] + value if name in self._sums else value.clone()
        self.count += 1

    def take(self) -> dict[str, float]:
        """Return the means of all metrics added since the last call."""
        means = {name: round(float(value) / self.count, 4) for name, value in self._sums.items()}
        self._sums, self.count = {}, 0
        return means


class BalanceWatch:
    """Warns once if the discriminator wins for long, and once if it cannot distinguish real from generated motion."""

    def __init__(self):
        self._durations = {"wins": 0, "dead": 0}

    def look(self, means: dict[str, float], steps: int) -> list[str]:
        """Return warnings after ``steps`` more steps with these ``means`` of :meth:`Trainer.step`."""
        problems = {
            "wins": (means["right_real"] + means["right_made"]) / 2 > WINS,
            "dead": abs(means["judged_real"] - means["judged_made"]) < DEAD,
        }
        warnings = []
        for name, present in problems.items():
            before = self._durations[name]
            if before < PATIENCE_STEPS:
                self._durations[name] = before + steps if present else 0
                if self._durations[name] >= PATIENCE_STEPS:
                    warnings.append(_WARNINGS[name])
        return warnings


_WARNINGS = {
    "wins": f"The discriminator is right in over {WINS:.0%} of all cases: its term no longer teaches the generator. "
    "Lower discriminator_rate or real_label.",
    "dead": "The discriminator no longer tells real from generated. Raise discriminator_rate.",
}
