"""``s2ag doctor``: says whether this machine has what gestures need, and what to do where it has not."""

import argparse
import dataclasses
import json

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
    """Print every check with its remedy; 0 if a recording can become a character, else 2."""
    if options.clear_cache:
        from ..words.cache import Cache, default_folder

        cache = Cache(default_folder())
        print(f"{cache.clear()} files removed from {cache.folder or 'nowhere: no cache is kept'}")
        return 0
    from .checks import all_checks

    found = []
    for check in all_checks():
        found.append(check)
        if not options.json:
            _tell(check)
    works = all(check.ok for check in found if check.required)
    if options.json:
        print(json.dumps({"ok": works, "checks": [dataclasses.asdict(check) for check in found]}, indent=2))
    return 0 if works else 2


def _tell(check) -> None:
    mark = "ok" if check.ok else "MISSING" if check.required else "without"
    print(f"{mark:<8} {check.name:<14} {check.detail}", flush=True)
    if not check.ok:
        print(f"{'':<23} {check.remedy}", flush=True)
