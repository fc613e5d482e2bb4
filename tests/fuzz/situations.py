"""Situations that nobody plans: what a job works on changes, vanishes or closes meanwhile, and others are at work.

``python tests/fuzz/situations.py LOG COUNT`` tries the next ``COUNT`` numbers after those that ``LOG`` tells of, without
``COUNT`` for good; a third argument names the first number and leaves the log alone. Each number is always the same situation:
a job, a moment (just before its n-th operation on files), and what happens then. A job must end in its result or in two
sentences, leave nothing open and nothing behind, and make the bytes of a calm run as soon as all is well again. Linux alone:
limits and namespaces are its own.
"""

import collections
import contextlib
import faulthandler
import json
import os
import random
import sys
import tempfile
import threading
import time
import traceback
from pathlib import Path

import others
import pairs
import trouble
from jobs import JOBS, Place

STUCK = 600
"""Seconds after which a situation is held to hang, on a machine that others use, too."""
KINDS = ("pair",) * 5 + ("vanished",) * 5 + ("changed",) * 5 + ("limits",) * 2 + ("others",) * 3
OFTEN = ("worker",) * 4 + ("batch",) * 3 + ("command",)
SOUNDS = ("silence", "noise", "click", "speech")
FOLDERS = ("temporary", "cache", "out", "home", "in")


def situation(number: int) -> dict:
    """What is tried under ``number``."""
    chance = random.Random(f"situation {number}")
    kind = chance.choice(KINDS)
    found = {"kind": kind, "job": chance.choice(OFTEN), "sound": chance.choice(SOUNDS), "count": chance.choice((80, 3200))}
    found |= {"words": chance.choice(("none", "times", "none", "times", "text"))}
    found |= {"moment": chance.random(), "before": chance.random() < 0.15}
    if kind == "vanished":
        found |= {"what": chance.choice(FOLDERS), "act": chance.choice(trouble.OF_FOLDERS)}
    elif kind == "changed":
        found |= {"what": chance.choice(("sound", "words", "document", "result")), "act": chance.choice(trouble.OF_FILES)}
    elif kind == "limits":
        found |= {"what": chance.choice(("size", "handles")), "act": chance.choice((0, 1, 2, 3, 5, 100, 3000))}
    elif kind == "others":
        found |= {"what": chance.choice(others.PLACES), "act": chance.choice(others.ENDS), "later": chance.random()}
    return found


class Harness:
    """Jobs that are warm, a folder for them, and what calm runs have made."""

    def __init__(self, root: Path):
        self.place = Place(root)
        self.jobs = {name: job(self.place) for name, job in JOBS.items()}
        self.calm: dict[tuple, tuple[dict[str, str], int]] = {}
        for name, job in self.jobs.items():
            self.place.set_up({"job": name, "sound": "speech", "count": 800, "words": "text"})
            job.run()
            job.close()

    def attempt(self, number: int) -> str:
        """What is wrong with how a situation ended, "" for nothing."""
        found = situation(number)
        if found["kind"] == "pair":
            return pairs.attempt(self.jobs["worker"].session, self.place.root, pairs.drawn(100_000 + number))
        job = self.jobs[found["job"]]
        calm, moments = self.calm_run(job, found)
        moment = 0 if found["before"] else 1 + int(found["moment"] * moments)
        self.place.set_up(found)
        opened, threads = trouble.handles(), threading.active_count()
        wrong = []
        if found["kind"] == "others":
            wrong += others.meet(job, self.place, found, moment, 1 + int(found["later"] * moments), calm)
        else:
            act = trouble.act(self.place, found)
            wrong += self.disturbed(job, moment, act, calm, found)
            act.undo()
        self.place.set_up(found, anew=False)
        wrong += self.ended(job, calm)
        if found["job"] != "worker" or found["words"] != "text":  # whose aligner waits for the next words
            wrong += [f"{trouble.handles() - opened} files are open"] if trouble.handles() > opened + 1 else []
            wrong += ["a thread goes on"] if trouble.threads(threads) > threads else []
        return "\n".join(filter(None, wrong))

    def calm_run(self, job, found: dict) -> tuple[dict[str, str], int]:
        """What a job makes where nothing happens, and in how many operations on files."""
        key = tuple(found[name] for name in ("job", "sound", "count", "words"))
        if key not in self.calm:
            self.place.set_up(found)
            with trouble.at_moment(self.place.root, -1, lambda: None) as count:
                told = job.run()
            assert not told, told
            self.calm[key] = self.place.made(), count()
            job.close()
        return self.calm[key]

    def disturbed(self, job, moment: int, act, calm: dict[str, str], found: dict) -> list[str]:
        """Run a job, and let the trouble come at its moment; moment 0 is before it begins."""
        began = time.process_time()
        if not moment:
            act.do()
        with trouble.at_moment(self.place.root, moment, act.do):
            told = trouble.outcome(job.run)
        spent = time.process_time() - began
        wrong = [told.wrong] + ([f"it took {spent:.1f} s"] if spent > pairs.SECONDS else [])
        if told.done and not act.changes and self.place.made() != calm and self.place.folder("out").is_dir():
            wrong.append(f"the result is said to be there, but {sorted(self.place.made())} differ")
        return wrong

    def ended(self, job, calm: dict[str, str]) -> list[str]:
        """Run a job where all is well again, and look at what is left."""
        told = trouble.outcome(job.run)
        wrong = [told.wrong and f"afterwards: {told.wrong}"]
        if not told.done:
            wrong.append(f"afterwards it said {told.sentences}")
        elif self.place.made() != calm:
            wrong.append(f"afterwards it made {sorted(self.place.made().items() ^ calm.items())}")
        job.close()
        return wrong + self.place.left()


def known(log: Path) -> tuple[int, int, collections.Counter]:
    """The next number, how many fell, and how many of each kind were tried, as the log says."""
    tried, fell, number = collections.Counter(), 0, 0
    for line in log.read_text("utf-8").splitlines() if log.exists() else ():
        if line.startswith("{"):
            told = json.loads(line)
            number, fell, tried = told["next"], told["fell"], collections.Counter(told["tried"])
        elif line.startswith("trying "):
            number = int(line.split()[1]) + 1  # in which it ended
    return number, fell, tried


def main() -> None:
    """Go on where the log ends."""
    os.environ["OMP_NUM_THREADS"] = "1"  # forks have no other threads
    log, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1 << 60
    number, fell, tried = known(log)
    if sys.argv[3:]:
        number, log = int(sys.argv[3]), Path(os.devnull)
        print(situation(number))
    trouble.give_up_powers()
    with log.open("a", encoding="utf-8") as told, tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        os.environ |= {"HOME": f"{folder}/home", "S2AG_CACHE": f"{folder}/cache"}
        harness = Harness(Path(folder))
        for tried_now in range(1, count + 1):
            told.write(f"trying {number}\n") if tried_now % 50 == 1 else None
            told.flush()
            faulthandler.dump_traceback_later(STUCK, exit=True, file=told)
            try:
                wrong = harness.attempt(number)
            except Exception:  # a situation that the harness cannot end is looked at, too
                wrong = traceback.format_exc(limit=-8)
            kind = situation(number)["kind"]
            tried[kind] += 1
            fell += bool(wrong)
            number += 1
            if wrong:
                text = f"FELL {number - 1} {situation(number - 1)}\n{wrong}\n"
                told.write(text)
                told.flush()
                print(text, flush=True)
            if tried_now % 50 == 0 or tried_now == count:
                told.write(json.dumps({"next": number, "fell": fell, "tried": tried}) + "\n")
        faulthandler.cancel_dump_traceback_later()
    print(json.dumps({"next": number, "fell": fell, "tried": tried}))
    sys.stdout.flush()
    os._exit(bool(fell))


if __name__ == "__main__":
    main()
