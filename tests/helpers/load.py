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


def resident_of_children():
    """The largest child's resident megabytes."""
    found = 0.0
    for entry in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{entry}/status") as file:
                status = dict(line.split(":", 1) for line in file if ":" in line)
        except OSError:
            continue
        if int(status["PPid"]) == os.getpid() and "VmRSS" in status:
            found = max(found, int(status["VmRSS"].split()[0]) / 1024)
    return found
