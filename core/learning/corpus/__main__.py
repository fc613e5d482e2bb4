"""``python -m s2ag.core.learning.corpus --material PATH --out DIR``: build the directed corpus."""

import argparse
import json
import os
import sys
from pathlib import Path

from ...errors import S2agError
from . import rocketbox_clips


def main(arguments: list[str] | None = None) -> int:
    """Build and print statistics; exit status 2 with a sentence where material or output is missing."""
    parser = argparse.ArgumentParser(
        prog="python -m s2ag.core.learning.corpus", description="Build the directed performance corpus."
    )
    parser.add_argument("--material", type=Path, required=True, help="folder with smartbody/, rocketbox_clips/ and emobank/")
    parser.add_argument("--out", type=Path, required=True, help="folder of the packed corpus")
    parser.add_argument("--speech", type=Path, help="folder of the cached speech (default: beside OUT)")
    parser.add_argument("--hours", type=float, default=10.5, help="hours of distinct speech (default: 10.5)")
    parser.add_argument("--performers", type=int, default=4, help="performers of every talk (default: 4)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes (default: one a core)")
    options = parser.parse_args(arguments)
    for part in ("smartbody", rocketbox_clips.FOLDER, "emobank"):
        if not (options.material / part).is_dir():
            print(f"{options.material} holds no {part}. Name the folder with the public material.", file=sys.stderr)
            return 2
    try:
        from tqdm import tqdm

        from . import build, pack

        speech = options.speech or options.out.with_name("speech")
        task = build.Task(str(options.material), str(speech), options.seed, options.performers)
        options.out.parent.mkdir(parents=True, exist_ok=True)
        with tqdm(total=round(options.hours * 3600), unit="s", desc="corpus", unit_scale=True) as bar:
            talks = build.build(task, options.hours, options.workers, lambda seconds: bar.update(round(seconds)))
        figures = pack.save(talks, options.out, options.seed)
    except (S2agError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps(figures, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
