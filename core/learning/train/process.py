"""Device and processes of a training (a CPU, a GPU, or many under ``torchrun``), and handling of interruptions."""

import os
import signal
import threading
import warnings
from types import FrameType
from typing import TYPE_CHECKING, Any

import torch

from ...errors import EngineMissing, UsageError
from .config import TrainConfig

if TYPE_CHECKING:
    from lightning_fabric import Fabric


def launch(config: TrainConfig) -> "Fabric":
    """Launch Lightning Fabric for this process; under ``torchrun`` all processes train together (DDP).

    Raises :class:`UsageError` for an unavailable device and :class:`EngineMissing` without Fabric.
    """
    try:
        from lightning_fabric import Fabric
    except ModuleNotFoundError as error:
        raise EngineMissing(f"The Python package {error.name} is missing.", 'Install: pip install "s2ag[train]"') from error
    available = {"cpu": True, "cuda": torch.cuda.is_available(), "mps": torch.backends.mps.is_available()}
    if not available[config.device]:
        raise UsageError(f"There is no {config.device} device here.", "Set device to cpu.")
    processes, local_processes = (int(os.environ.get(name, 1)) for name in ("WORLD_SIZE", "LOCAL_WORLD_SIZE"))
    if "TORCHELASTIC_RUN_ID" not in os.environ:
        processes = local_processes = 1
    strategy = "ddp" if processes > 1 else "auto"
    precision: Any = config.precision
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fabric = Fabric(
            accelerator=config.device,
            strategy=strategy,
            devices=local_processes,
            num_nodes=processes // local_processes,
            precision=precision,
        )
        fabric.launch()
    if config.threads:
        torch.set_num_threads(config.threads)
    return fabric


def broadcast_decision(fabric: "Fabric", decision: bool) -> bool:
    """Return the first process's decision in every process."""
    if fabric.world_size == 1:
        return decision
    flag = torch.tensor(decision, dtype=torch.uint8, device=fabric.device)
    torch.distributed.broadcast(flag, 0)
    return bool(flag)


class Interruption:
    """A context in which Ctrl-C and SIGTERM only set :attr:`asked`, so that a step completes; a second Ctrl-C raises."""

    def __init__(self):
        self.asked = False
        self._previous_handlers: dict[int, Any] = {}

    def __enter__(self) -> "Interruption":
        if threading.current_thread() is threading.main_thread():
            numbers = (signal.SIGINT, signal.SIGTERM)
            self._previous_handlers = {number: signal.signal(number, self._handle) for number in numbers}
        return self

    def __exit__(self, *error: object) -> None:
        for number, handler in self._previous_handlers.items():
            signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.asked and number == signal.SIGINT:
            raise KeyboardInterrupt
        self.asked = True
