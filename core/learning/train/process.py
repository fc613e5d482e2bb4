"""The processes and the device of a training: one core, one GPU, or many under ``torchrun``; what they agree on."""

import os
import signal
import threading
import warnings

import torch

from ...errors import EngineMissing, UsageError
from .config import TrainConfig


def start(config: TrainConfig):
    """A launched Lightning Fabric for this process; under ``torchrun`` all processes train together (DDP).

    Raises :class:`UsageError` for a device that is absent and :class:`EngineMissing` without Fabric.
    """
    try:
        from lightning_fabric import Fabric
    except ModuleNotFoundError as error:
        raise EngineMissing(f"The Python package {error.name} is missing.", 'Install: pip install "s2ag[train]"') from error
    present = {"cpu": True, "cuda": torch.cuda.is_available(), "mps": torch.backends.mps.is_available()}
    if not present[config.device]:
        raise UsageError(f"There is no {config.device} device here.", "Set device to cpu.")
    processes, here = (int(os.environ.get(name, 1)) for name in ("WORLD_SIZE", "LOCAL_WORLD_SIZE"))
    if "TORCHELASTIC_RUN_ID" not in os.environ:
        processes = here = 1
    strategy = "ddp" if processes > 1 else "auto"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fabric = Fabric(
            accelerator=config.device,
            strategy=strategy,
            devices=here,
            num_nodes=processes // here,
            precision=config.precision,
        )
        fabric.launch()
    if config.threads:
        torch.set_num_threads(config.threads)
    return fabric


def agreed(fabric, decision: bool) -> bool:
    """The first process's decision, in every process."""
    if fabric.world_size == 1:
        return decision
    flag = torch.tensor(decision, dtype=torch.uint8, device=fabric.device)
    torch.distributed.broadcast(flag, 0)
    return bool(flag)


class Interruption:
    """While entered, Ctrl-C and SIGTERM only set :attr:`asked`, so that a step is always finished; the second Ctrl-C ends."""

    def __init__(self):
        self.asked = False
        self._former: dict = {}

    def __enter__(self) -> "Interruption":
        if threading.current_thread() is threading.main_thread():
            self._former = {number: signal.signal(number, self._note) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *error) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)

    def _note(self, number: int, frame) -> None:
        if self.asked and number == signal.SIGINT:
            raise KeyboardInterrupt
        self.asked = True
