"""Training losses: those of the paper (eq. 15 to 17, reference section C), and this project's on motion."""

import torch
from torch.nn import functional

from ...motion.skeleton import ARM_EDGES, EDGES, LENGTHS

HUBER_BETA = 0.1
DIVERSITY_BETA = 0.05
DISPLACEMENT_WEIGHT = 10.0
"""Weight of displacements relative to positions in :func:`arm_position_loss`, equal to velocity / huber of the default
settings.
"""
_EPSILON = 1e-8


def huber(generated: torch.Tensor, real: torch.Tensor, arm_weight: float = 1.0) -> torch.Tensor:
    """Return the mean smooth-L1 loss, quadratic below 0.1; an ``arm_weight`` other than 1 needs ``(..., 9, 3)``."""
    if arm_weight == 1:
        return functional.smooth_l1_loss(generated, real, beta=HUBER_BETA)
    weight = generated.new_ones(len(EDGES), 1)
    weight[list(ARM_EDGES)] = arm_weight
    return (functional.smooth_l1_loss(generated, real, beta=HUBER_BETA, reduction="none") * weight).mean()


def difference_loss(generated: torch.Tensor, real: torch.Tensor, order: int, arm_weight: float = 1.0) -> torch.Tensor:
    """Return :func:`huber` of the ``order``-th differences between frames (axis 1): 1 velocity, 2 acceleration."""
    return huber(generated.diff(order, dim=1), real.diff(order, dim=1), arm_weight)


def arm_positions(directions: torch.Tensor) -> torch.Tensor:
    """Return positions of left elbow and wrist, right elbow and wrist ``(..., 4, 3)`` in metres from the spine's root."""
    chains = directions.new_zeros(4, len(EDGES))
    for row, chain in enumerate(((0, 3, 4), (0, 3, 4, 5), (0, 6, 7), (0, 6, 7, 8))):
        chains[row, list(chain)] = torch.from_numpy(LENGTHS[list(chain)]).to(chains)
    return chains @ functional.normalize(directions, dim=-1)


def arm_position_loss(generated: torch.Tensor, real: torch.Tensor) -> torch.Tensor:
    """Return :func:`huber` of elbow and wrist positions of directions ``(B, T, 9, 3)`` and of their displacements."""
    ours, theirs = arm_positions(generated), arm_positions(real)
    return huber(ours, theirs) + DISPLACEMENT_WEIGHT * difference_loss(ours, theirs, 1)


def adversarial(judged: torch.Tensor) -> torch.Tensor:
    """Return the generator's non-saturating loss for the discriminator's probabilities of its output (paper eq. 17)."""
    return -torch.log(judged + _EPSILON).mean()


def discriminator(real: torch.Tensor, generated: torch.Tensor, real_label: float = 1.0) -> torch.Tensor:
    """Return the discriminator's loss (paper eq. 16); ``real_label`` below 1 is one-sided label smoothing."""
    loss = real_label * torch.log(real + _EPSILON) + torch.log(1 - generated + _EPSILON)
    if real_label < 1:
        loss = loss + (1 - real_label) * torch.log(1 - real + _EPSILON)
    return -loss.mean()


def diversity(generated: torch.Tensor, other: torch.Tensor, style: torch.Tensor, other_style: torch.Tensor) -> torch.Tensor:
    """Return minus the distance of two motions ``(B, T, ...)`` of the same speech over that of their styles ``(B, size)``.

    Only ``generated`` gets a gradient. Each sample's value is at least -1000.
    """
    distance = functional.smooth_l1_loss(generated, other.detach(), beta=DIVERSITY_BETA, reduction="none").flatten(1).sum(1)
    style_distance = (style - other_style).detach().abs().flatten(1).mean(1) + 1e-5
    return (-distance / style_distance).clamp(min=-1000).mean()


def divergence(mu: torch.Tensor, logvar: torch.Tensor) -> torch.Tensor:
    """Return the Kullback-Leibler divergence of styles from a standard normal, mean over samples and dimensions."""
    return -0.5 * (1 + logvar - mu**2 - logvar.exp()).mean()
