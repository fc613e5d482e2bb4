"""``s2ag doctor``: checks whether this machine has what is needed, and prints remedies."""

import argparse
import dataclasses
import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .machine_checks import Check

SUMMARY = "check that everything needed is installed and works"
EXAMPLE = """examples:
  s2ag doctor
  s2ag doctor --json
  s2ag doctor --clear-cache"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("--json", action="store_true", help="machine-readable")
    parser.add_argument("--clear-cache", action="store_true", help="forget all kept word times, and check nothing")


def run(options: argparse.Namespace) -> int:
    """Print every check with its remedy; return 0 if all required ones pass, else 2."""
    if options.clear_cache:
        from ..words.cache import Cache, default_folder

        cache = Cache(default_folder())
        print(f"{cache.clear()} files removed from {cache.folder or 'nowhere: no cache is kept'}")
        return 0
    from .machine_checks import all_checks

    checks = []
    for check in all_checks():
        checks.append(check)
        if not options.json:
            _print(check)
    works = all(check.ok for check in checks if check.required)
    if options.json:
        print(json.dumps({"ok": works, "checks": [dataclasses.asdict(check) for check in checks]}, indent=2))
    return 0 if works else 2


def _print(check: "Check") -> None:
    mark = "ok" if check.ok else "MISSING" if check.required else "without"
    print(f"{mark:<8} {check.name:<14} {check.detail}", flush=True)
    if not check.ok:
        print(f"{'':<23} {check.remedy}", flush=True)
