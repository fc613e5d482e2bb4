"""External rows of a bench: trained checkpoints, folders of motions, and trainings of other benches."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import UsageError
from ...model import checkpoint, checkpoint_metadata
from ...model.config import ModelConfig
from ...motion.readers import motion_files
from ..datasets.resampling import resample
from ..systems.catalogue import ALL_SYSTEMS, BuildOptions
from ..systems.imported import Imported
from ..systems.lengths import Lengths
from ..systems.system import System
from ..train import state
from ..train.dataset import Corpus
from . import contextual
from .data import Data
from .evaluation import Bench
from .flow_networks import FlowPerformer
from .rows import IDS
from .setting import SETTING, read
from .training import BEST, STATE
from .weights import WEIGHTS

SHIPPED = "default"
_FOREIGN = (".tar", ".bin", ".pth", ".pt")
_BY_WINDOW = "each window by itself, from its own sound and words and the given poses"
_MAX_MISSING = 1.0
"""Seconds by which a motion may be shorter than its talk."""
_MAX_LISTED = 3


class ExternalRow(NamedTuple):
    """An external row: ``perform(draw, ids, heard)`` returns directions ``(n, T, 9, 3)`` of the bench's windows.

    ``made`` is a sentence on how they are generated, ``ids`` are the possible speaker modes (:data:`rows.IDS`). ``draws`` and
    ``answers`` say whether there are several performances, and whether other speech can be used.
    """

    perform: Callable[..., np.ndarray]
    made: str
    ids: tuple[str, ...]
    draws: bool = True
    answers: bool = True


def shipped_row(bench: Bench) -> ExternalRow:
    """Return the row of the shipped network."""
    drawer = FlowPerformer()
    how = f"the network that is shipped, not trained here, perhaps on talks like these; {_BY_WINDOW}"
    return ExternalRow(_perform_by(drawer, bench), how, IDS if drawer.knows(bench) else IDS[1:])


def check(path: str | PathLike) -> None:
    """Raise :class:`UsageError` if ``path`` cannot be a row, before anything else is done."""
    path = Path(path)
    if not path.exists():
        raise UsageError(f"There is no {path}.", "Name a checkpoint, a system's folder of a bench, or a folder of motions.")
    if path.suffix.lower() in _FOREIGN:
        remedy = f"Convert it: s2ag checkpoint import {path.name} -o {path.name.split('.')[0]}.safetensors"
        raise UsageError(f"{path} is another program's checkpoint.", remedy)


def external_row(path: str | PathLike, bench: Bench, device: str) -> ExternalRow:
    """Return the row of a checkpoint, of a system's folder of a bench, or of a folder of motions (:func:`motions_row`).

    Raises :class:`UsageError` and what reading those raises.
    """
    path, data = Path(path), bench.data
    if path.is_dir():
        if (path / WEIGHTS).is_file():
            return external_row(path / WEIGHTS, bench, device)
        if (path / STATE).is_file():
            return _system_row(_load_trained(path, data), bench, device, f"trained in {path}; {_BY_WINDOW}")
        return motions_row(path, bench)
    if ModelConfig.from_dict(checkpoint_metadata.read_metadata(path)["config"]).decoder == "flow":
        drawer = FlowPerformer(path)
        return ExternalRow(
            _perform_by(drawer, bench), f"{path.name}, not trained here; {_BY_WINDOW}", IDS if drawer.knows(bench) else IDS[1:]
        )
    loaded = checkpoint.load(path, device)
    system = Imported(loaded, data.corpus.meta["words"], [one["name"] for one in data.corpus.speakers], data.lengths)
    how = f"{path.name}, not trained here; {_BY_WINDOW}" + (
        "" if loaded.meta.get("vocabulary") else "; it was imported without words"
    )
    return _system_row(system, bench, device, how)


def motions_row(folder: Path, bench: Bench) -> ExternalRow:
    """Return the row of a folder of motions of whole test talks, generated elsewhere without seed poses.

    Files are named ``TALK SPEAKER.npz`` or ``TALK.npz``, or .bvh. Raises :class:`UsageError` where one is missing or short.
    """
    corpus, cut = bench.data.corpus, np.empty_like(bench.real)
    files = {talk: _file(folder, corpus, talk) for talk in np.unique(bench.windows[:, 0])}
    missing = [_names(corpus, talk)[-1] for talk, file in files.items() if file is None]
    if missing:
        named = ", ".join(missing[:_MAX_LISTED]) + (", ..." if len(missing) > _MAX_LISTED else "")
        raise UsageError(
            f"{folder} holds no motion for {len(missing)} of {len(files)} test talks: {named}.", "Name files as the talks."
        )
    for talk, file in files.items():
        assert file is not None  # otherwise it is missing
        motion = motion_files.load(file)
        directions = resample(motion.directions, motion.fps, bench.fps)
        length = int(corpus.starts[talk + 1] - corpus.starts[talk])
        if len(directions) < length - _MAX_MISSING * bench.fps:
            raise UsageError(f"{file} ends after {motion.duration:.1f} s, before its talk does.", "Perform the whole talk.")
        here = bench.windows[:, 0] == talk
        rows = bench.windows[here, 1][:, None] + np.arange(cut.shape[1])
        cut[here] = directions[np.minimum(rows, len(directions) - 1)]
    made = f"motions of {folder.name}, whole talks, no pose given"
    return ExternalRow(lambda draw, ids, heard=None: cut, made, IDS[:1], draws=False, answers=False)


def _names(corpus: Corpus, talk: int) -> list[str]:
    """Return the possible file names of a performance, without suffix."""
    number = int(corpus.recording[talk])
    name = contextual.recording_name(corpus.meta["recordings"][number], number)
    return [f"{name} {corpus.speakers[corpus.speaker[talk]]['name']}", name]


def _file(folder: Path, corpus: Corpus, talk: int) -> Path | None:
    paths = (folder / f"{name}{suffix}" for name in _names(corpus, talk) for suffix in motion_files.SUFFIXES)
    return next((path for path in paths if path.is_file()), None)


def _perform_by(drawer: FlowPerformer, bench: Bench) -> Callable[..., np.ndarray]:
    return lambda draw, ids, heard=None: drawer.perform(bench, draw, ids, heard)


def _system_row(system: System, bench: Bench, device: str, made: str) -> ExternalRow:
    system = system.to(device)
    known = getattr(system, "known", True)
    ids = (IDS if known else IDS[1:]) if system.knows_speakers else IDS[:1]
    return ExternalRow(lambda draw, ids, heard=None: bench.perform(system, draw, device, ids, heard), made, ids)


def _load_trained(folder: Path, data: Data) -> System:
    """Load a system of another bench, with this data set's words; raises :class:`UsageError` where its settings do not fit."""
    name = folder.name.rpartition("-")[0]
    if name not in ALL_SYSTEMS or not (folder.parent / SETTING).is_file():
        raise UsageError(f"{folder} is no system's folder of a bench.", "Name one such as bench/seq2seq-1.")
    setting, _, fps = read(folder.parent)
    reason = "learned the words of its own data set" if setting.trained_words else ""
    if setting.given != data.given:
        reason = "was given other poses"
    elif Lengths(setting.window, fps) != data.lengths:
        reason = f"learned from windows of {Lengths(setting.window, fps)}"
    elif ALL_SYSTEMS[name].contextual and not data.width:
        reason = "reads vectors of words in their context, which this bench lacks"
    if reason:
        raise UsageError(f"The system in {folder} {reason}.", "Train it with the settings of this bench.")
    system = ALL_SYSTEMS[name].build(
        BuildOptions(
            data.vectors,
            data.speakers,
            setting.share,
            False,
            faithful=setting.faithful,
            given=setting.given,
            lengths=data.lengths,
            contextual=data.width,
        )
    )
    state.load(folder / (BEST if (folder / BEST).is_file() else STATE), {"system": system})
    return system
