"""Varies what :mod:`lifting_training` learns from: other limbs, cameras turned a little, hands that are not seen.

Films show few bodies and few poses, but much of what else could have been seen follows from them: what is known of the arms'
directions turns with the camera, and stays where bones are longer. Needs PyTorch."""

import torch

from . import lifting

_TURN = 0.07, 0.09, 0.09
"""Deviations in radians of turns about the axes across, upwards and ahead."""
_ASTRAY = 0.06, 0.12, 0.03
"""Deviations in radians by which the camera's place is not known."""
_BONE, _EACH = 0.12, 0.05
"""Deviations of the logarithm of lengths: of a body's parts, and of an arm's bones beside the other's."""
_DEPTH, _PLACE = 0.08, 0.02
"""Deviations of the logarithm of depth, and in metres of where points lie in depth; half as much across."""
_UNSEEN = 0.1
"""Share of hands that are taken for unseen."""
_TRUNK = 0, 12
"""First points of shoulders and hips; elbows, wrists and three points of the hand lie between, left and right in turn."""
_ARM = 2, 4
_BONES = (1, 3), (3, 5)
"""Ends of the right upper arm and forearm."""
_TIPS = 6, 8, 10
_POINTS = 14

Given = tuple[torch.Tensor, torch.Tensor, torch.Tensor]


def varied(rows: torch.Tensor, start: torch.Tensor, wanted: torch.Tensor, exact: bool = False) -> Given:
    """Return pieces ``rows`` ``(b, n, d)``, with ``start`` and ``wanted`` ``(b, n, 4, 3)``, each varied by chance; ``exact``:
    without errors of points and of the camera's place."""
    bones, deep, shown, sure, own, other, lengths, stands = rows.split(list(lifting.PARTS.values()), -1)
    count, frames = rows.shape[:2]
    turn, scales = _turns(count), _Scales(count)
    flat = shown.reshape(count, frames, _POINTS, 2)
    placed = scales.applied(deep.reshape(count, frames, _POINTS, 3))
    turned = torch.einsum("bij,bnkj->bnki", turn, placed)
    after = scales.applied(flat) + (turned - placed)[..., :2]
    stood = torch.einsum("bij,bnkj->bnki", turn, stands.unflatten(-1, (-1, 3)))
    if not exact:
        stood = torch.einsum("bij,bnkj->bnki", _turns(count, _ASTRAY), stood)
        turned = turned * torch.cat([torch.ones(count, 2), _scale(count, _DEPTH)], 1)[:, None, None]
        turned = turned + torch.randn(count, 1, _POINTS, 3) * torch.tensor([0.5, 0.5, 1.0]) * _PLACE
    arm = torch.stack([turned[:, :, at] - turned[:, :, before] for before, at in _BONES], 2)
    arm = arm / arm.norm(dim=-1, keepdim=True).clamp_min(1e-6)
    kept = [(torch.rand(count, 1, 1) > _UNSEEN).float() for _ in range(2)]
    hands = [
        _hand(hand, turn, scales, (after - flat)[:, :, wrist]) * there
        for hand, wrist, there in zip((own, other), (5, 4), kept, strict=True)
    ]
    held = torch.einsum("bij,bnkj->bnki", turn, start[:, :, 2:]) * kept[0][..., None]
    made = arm.flatten(2), turned.flatten(2), after.flatten(2), sure, *hands, _lengths(flat, after, lengths), stood.flatten(2)
    return torch.cat(made, -1), torch.cat([arm, held], 2), torch.einsum("bij,bnkj->bnki", turn, wanted)


class _Scales:
    """Factors of the lengths of bodies' parts."""

    def __init__(self, count: int):
        self.wide, self.trunk, self.hand, upper, fore = (_scale(count, _BONE) for _ in range(5))
        self.arms = [(upper * _scale(count, _EACH), fore * _scale(count, _EACH)) for _ in range(2)]

    def applied(self, points: torch.Tensor) -> torch.Tensor:
        """Return points ``(b, n, 14, k)`` about the middle of the shoulders of bodies of other lengths."""
        made = points.clone()
        for side, (upper, fore) in enumerate(self.arms):
            shoulder, hip = (at + side for at in _TRUNK)
            elbow, wrist = (at + side for at in _ARM)
            made[:, :, shoulder] = points[:, :, shoulder] * self.wide[:, None]
            made[:, :, hip] = points[:, :, hip] * self.trunk[:, None]
            for before, at, scale in ((shoulder, elbow, upper), (elbow, wrist, fore)):
                made[:, :, at] = made[:, :, before] + (points[:, :, at] - points[:, :, before]) * scale[:, None]
            for tip in (at + side for at in _TIPS):
                made[:, :, tip] = made[:, :, wrist] + (points[:, :, tip] - points[:, :, wrist]) * self.hand[:, None]
        return made


def _scale(count: int, spread: float) -> torch.Tensor:
    return torch.exp(torch.randn(count, 1) * spread)


def _turns(count: int, spreads: tuple[float, ...] = _TURN) -> torch.Tensor:
    """Return rotations ``(count, 3, 3)`` by small angles."""
    result = torch.eye(3).repeat(count, 1, 1)
    for spread, (row, column) in zip(spreads, ((1, 2), (2, 0), (0, 1)), strict=True):
        angle, turn = torch.randn(count) * spread, torch.eye(3).repeat(count, 1, 1)
        turn[:, row, row] = turn[:, column, column] = angle.cos()
        turn[:, row, column], turn[:, column, row] = -angle.sin(), angle.sin()
        result = turn @ result
    return result


def _hand(hand: torch.Tensor, turn: torch.Tensor, scales: _Scales, moved: torch.Tensor) -> torch.Tensor:
    """Return what is known of a hand ``(b, n, d)`` whose wrist is ``moved`` ``(b, n, 2)`` in the picture."""
    there, wrist, points = hand[..., :1], hand[..., 1:3], hand[..., 3:].unflatten(-1, (-1, 3))
    size = torch.ones(len(hand), points.shape[2])
    size[:, :-2] = scales.hand  # the last two are directions
    points = torch.einsum("bij,bnkj->bnki", turn, points) * size[:, None, :, None]
    return torch.cat([there, (wrist + moved) * there, points.flatten(2)], -1)


def _lengths(flat: torch.Tensor, after: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
    """Return the longest bones ``(b, n, 4)`` and shares of them, in which arms ``(b, n, 14, 2)`` have become longer."""
    old, new = (
        torch.stack([(points[:, :, at] - points[:, :, before]).norm(dim=-1) for before, at in _BONES], -1)
        for points in (flat, after)
    )
    grown = (old * new).sum(1, keepdim=True) / old.square().sum(1, keepdim=True).clamp_min(1e-6)
    longest = lengths[..., :2] * grown
    return torch.cat([longest, new / longest.clamp_min(1e-3)], -1)
