"""How busy the machine is, for promises about an idle one."""

import os
import time

_WORK = 0.1


def slowdown() -> float:
    """How many times longer than alone a process takes here and now, at least 1: by the machine's queue, and by a try."""
    queue = os.getloadavg()[0] / (os.cpu_count() or 1)
    began, spent = time.monotonic(), time.process_time()
    while time.process_time() - spent < _WORK:
        pass
    return max(1.0, queue, (time.monotonic() - began) / _WORK)
