"""What processes on this machine hold."""

import os


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
