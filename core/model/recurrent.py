"""A faster GRU for training on a CPU: the arithmetic of ``torch.nn.GRU`` with a hand-written gradient.

On a CPU, PyTorch unrolls a GRU into some thirty small operations per frame, and its backward pass multiplies matrices in
every frame for every weight. Here a frame takes a dozen operations, forward and backward, and each weight's gradient is one
large product over all frames. Under autocast only those large products have low precision, the state never does.
"""

from typing import Any

import torch
from torch import nn
from torch.nn import functional

from .dropout import dropout

_WEIGHTS = ("weight_ih", "weight_hh", "bias_ih", "bias_hh")
_ALIGNED = 16
"""Inputs are padded to a multiple of this, as odd sizes halve the speed of matrix products."""


def bidirectional(gru: nn.GRU, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return forward and backward outputs ``(B, T, size)`` of a batch-first ``gru`` over ``x`` ``(B, T, inputs)``."""
    weight = gru.weight_ih_l0
    assert isinstance(weight, torch.Tensor)
    low = torch.get_autocast_dtype("cpu") if torch.is_autocast_enabled("cpu") else weight.dtype
    padding = -x.shape[-1] % _ALIGNED
    x = functional.pad(x.transpose(0, 1), (0, padding))
    outputs: list[torch.Tensor] = []
    for layer in range(gru.num_layers):
        if layer:
            x = torch.cat(outputs, dim=-1)
            x = dropout(x, gru.dropout) if gru.training and gru.dropout else x
        x = x.to(low)
        outputs = []
        for end in ("", "_reverse"):
            weight_ih, weight_hh, bias_ih, bias_hh = (getattr(gru, f"{name}_l{layer}{end}") for name in _WEIGHTS)
            weight_ih = functional.pad(weight_ih, (0, 0 if layer else padding))
            outputs.append(_Scan.apply(x, weight_ih, weight_hh, bias_ih, bias_hh, bool(end)))
    ahead, back = outputs
    return ahead.transpose(0, 1), back.transpose(0, 1)


class _Scan(torch.autograd.Function):
    """One layer in one direction, time first: ``(T, B, inputs)`` to ``(T, B, size)``. Gates are ordered r, z, n.

    Large products have the input's type; everything else has the weights'.
    """

    @staticmethod
    def forward(
        ctx: Any,
        x: torch.Tensor,
        weight_ih: torch.Tensor,
        weight_hh: torch.Tensor,
        bias_ih: torch.Tensor,
        bias_hh: torch.Tensor,
        reverse: bool,
    ) -> torch.Tensor:
        with torch.autocast("cpu", enabled=False):
            size, (frames, batch, _) = weight_hh.shape[1], x.shape
            bias = torch.cat([bias_ih[: 2 * size] + bias_hh[: 2 * size], bias_ih[2 * size :]])
            rz, n = (_input(x, *part) for part in zip(*(w.split([2 * size, size]) for w in (weight_ih, bias)), strict=True))
            from_state = torch.empty_like(n)  # the state's contribution to n, before r gates it
            states = n.new_zeros(frames + 1, batch, size)
            before, after = (states[1:], states[:-1]) if reverse else (states[:-1], states[1:])
            weight_rz, weight_n = (part.t().contiguous() for part in weight_hh.split([2 * size, size]))
            steps = _frames(rz, rz[..., :size], rz[..., size:], n, from_state, before, after)
            for gates, r, z, new, inner, old, state in reversed(steps) if reverse else steps:
                gates.addmm_(old, weight_rz).sigmoid_()
                torch.addmm(bias_hh[2 * size :], old, weight_n, out=inner)
                new.addcmul_(r, inner).mul_(2).sigmoid_().mul_(2).sub_(1)  # tanh, in half the time of torch.tanh
                torch.lerp(new, old, z, out=state)
        ctx.save_for_backward(x, weight_ih, weight_hh, rz, n, from_state, states)
        ctx.reverse = reverse
        return after

    @staticmethod
    def backward(ctx: Any, *grad_outputs: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        (grad,), (x, weight_ih, weight_hh, rz, n, from_state, states) = grad_outputs, ctx.saved_tensors
        frames, batch, size = n.shape
        before = states[1:] if ctx.reverse else states[:-1]
        r, z = rz.split(size, dim=-1)
        # Derivatives of the state by each gate's pre-activation, all frames at once.
        slope_n = (1 - n * n).mul_(1 - z)
        slope_r = (1 - r).mul_(r).mul_(from_state).mul_(slope_n)
        slope_z = (1 - z).mul_(z).mul_(before - n)
        grads, gates = grad.clone(memory_format=torch.contiguous_format), torch.empty(frames, batch, 3 * size, dtype=n.dtype)
        parts = gates.split(size, dim=-1)
        steps = _frames(grads, z, gates, *parts, slope_r, slope_z, slope_n * r)
        following = None
        for step in steps if ctx.reverse else reversed(steps):
            if following is not None:
                step[0].addcmul_(following[0], following[1]).addmm_(following[2], weight_hh)
            for part, slope in zip(step[3:6], step[6:], strict=True):
                torch.mul(step[0], slope, out=part)
            following = step
        flat = gates.flatten(0, 1)
        low = flat.to(x.dtype)
        grad_weight_hh, grad_bias_hh = (low.t() @ before.flatten(0, 1).to(x.dtype)).to(n.dtype), flat.sum(0)
        torch.mul(grads, slope_n, out=parts[2])
        low[:, 2 * size :] = flat[:, 2 * size :]
        grad_weight_ih, grad_bias_ih = (low.t() @ x.flatten(0, 1)).to(n.dtype), flat.sum(0)
        grad_x = (low @ weight_ih.to(x.dtype)).view_as(x) if ctx.needs_input_grad[0] else None
        return grad_x, grad_weight_ih, grad_weight_hh, grad_bias_ih, grad_bias_hh, None


def _input(x: torch.Tensor, weight: torch.Tensor, bias: torch.Tensor) -> torch.Tensor:
    """Return the input's contribution to some gates in all frames, ``(T, B, gates)``."""
    return torch.addmm(bias.to(x.dtype), x.flatten(0, 1), weight.to(x.dtype).t()).to(weight.dtype).unflatten(0, x.shape[:2])


def _frames(*parts: torch.Tensor) -> list[tuple[torch.Tensor, ...]]:
    return list(zip(*(part.unbind(0) for part in parts), strict=True))
