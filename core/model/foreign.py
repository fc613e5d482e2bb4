"""The authors' checkpoints of S2AG and GTC in our format (reference section D.4b). Nothing in them is run."""

import io
import pickletools
import zipfile
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import torch

from ..errors import CheckpointUnreadable
from . import checkpoint, pickles
from .config import ModelConfig
from .discriminator import Discriminator
from .generator import Generator

GENERATORS = ("gen_model_dict", "gen_dict", "trimodal_gen_dict")
DISCRIMINATORS = ("dis_model_dict", "dis_dict")
_RENAMED = {"speaker_logvar.": "speaker_log_var."}
_LEGACY_PICKLES = 4
"""Magic number, protocol, system, and the weights' structure stand one after the other in files of torch before 1.6."""
_SHOWN = 12
_REMEDY = "Give the generator's file of Speech2AffectiveGestures (.pth.tar) or of Trimodal Context (.bin)."


def import_checkpoint(
    path: str | PathLike,
    out: str | PathLike,
    vocabulary: str | PathLike | None = None,
    speakers: str | PathLike | None = None,
) -> dict:
    """Convert ``path`` into ``out`` (.safetensors and .json); returns the facts that were written.

    The network is told by its parameters' names, words and speakers by the shapes of their tables; everything else must
    have the published shape. ``vocabulary`` and ``speakers`` are the authors' pickled ``Vocab`` objects; GTC's files hold
    both. Without a vocabulary the network hears no words, without speakers they are numbered. Raises
    :class:`CheckpointUnreadable`, which names every tensor that does not fit.
    """
    stored = read(path)
    tensors = _state(stored, GENERATORS, path)
    config = recognise(tensors, path)
    generator = _filled(Generator(config), tensors, path)
    discriminator = _discriminator(stored, config, path)
    words = _vocabulary(stored.get("lang_model"), vocabulary, config.words, "words")
    names = _vocabulary(stored.get("speaker_model"), speakers, config.speakers, "speakers")
    meta = {
        "speakers": _speakers(names, config.speakers),
        "vocabulary": words,
        "training": {"source": Path(path).name, "kind": config.name, "settings": {"frames": config.frames, "seed_frames": 4}},
    }
    meta["weights_sha256"] = checkpoint.save(out, generator, discriminator, meta, half=False)
    return meta | {"config": config.to_dict(), "parameters": sum(p.numel() for p in generator.parameters())}


def read(path: str | PathLike) -> Mapping[str, Any]:
    """The top level of a ``torch.save`` file, tensors on the CPU and foreign objects as :class:`pickles.Record`."""
    path = Path(path)
    if not path.is_file():
        raise CheckpointUnreadable(f"There is no checkpoint {path}.", _REMEDY)
    try:
        with torch.serialization.safe_globals([pickles.stand_in(*name) for name in sorted(_foreign_names(path))]):
            stored = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch lets a dozen types through for damaged files
        reason = " ".join(str(error).split())[:160]
        raise CheckpointUnreadable(
            f"{path} cannot be read ({type(error).__name__}: {reason}).", "Get the file again."
        ) from error
    if not isinstance(stored, Mapping):
        raise CheckpointUnreadable(f"{path} holds no dictionary of weights.", _REMEDY)
    return stored


def _foreign_names(path: Path) -> set[tuple[str, str]]:
    """Module and name of everything in the file that is not torch's own; read as text, nothing is imported."""
    names: set[tuple[str, str]] = set()
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            if sum(member.file_size for member in archive.infolist()) > 2 * path.stat().st_size + 1_000_000:
                raise ValueError("it unpacks to more than torch would have written")
            files = [io.BytesIO(archive.read(name)) for name in archive.namelist() if name.endswith("/data.pkl")]
    else:
        files = [io.BytesIO(path.read_bytes())] * _LEGACY_PICKLES
    for file in files:
        for opcode, argument, _ in pickletools.genops(file):
            if opcode.name == "GLOBAL":
                module, _, name = argument.partition(" ")
                if module.split(".")[0] not in ("torch", "collections"):
                    names.add((module, name))
    return names


def recognise(tensors: Mapping[str, torch.Tensor], path: str | PathLike = "The file") -> ModelConfig:
    """Which published network these parameters are of, with its numbers of words and speakers."""
    affect, wave = "aff_encoder.conv3.weight" in tensors, "audio_encoder.feat_extractor.0.weight" in tensors
    mfcc = "audio_encoder.conv1.weight" in tensors
    try:
        words, speakers = (len(tensors[f"{name}.weight"]) for name in ("text_encoder.embedding", "speaker_embedding.0"))
    except KeyError as error:
        raise CheckpointUnreadable(f"{path} holds no gesture generator: {error.args[0]} is missing.", _REMEDY) from error
    if not (wave or mfcc):
        raise CheckpointUnreadable(f"{path} holds a generator that hears neither MFCCs nor raw audio.", _REMEDY)
    if affect:
        return (ModelConfig.without_mfcc if wave else ModelConfig.published)(words, speakers)
    # GTC's activations were meant to be leaky and are linear (LeakyReLU(True)); its weights need them so.
    return ModelConfig.trimodal(words, speakers, head_slope=1.0) if wave else ModelConfig.without_affect(words, speakers)


def _state(stored: Mapping[str, Any], names: tuple[str, ...], path: str | PathLike) -> dict[str, torch.Tensor]:
    """The state dict under one of ``names``, or the file itself, with our names for its parameters."""
    found = next((stored[name] for name in names if name in stored), stored)
    if not isinstance(found, Mapping) or not any(isinstance(value, torch.Tensor) for value in found.values()):
        raise CheckpointUnreadable(f"{path} holds none of {', '.join(names)}.", _REMEDY)
    tensors = {}
    for name, value in found.items():
        if not isinstance(name, str) or not isinstance(value, torch.Tensor):
            continue
        name = name.removeprefix("module.")
        for old, new in _RENAMED.items():
            name = new + name.removeprefix(old) if name.startswith(old) else name
        tensors[name] = value
    return _without_doubles(tensors, path)


def _without_doubles(tensors: dict[str, torch.Tensor], path: str | PathLike) -> dict[str, torch.Tensor]:
    """The text encoder's convolutions are stored twice, the second time under ``net.0`` and ``net.4``."""
    doubles = {"net.0.": "conv1.", "net.4.": "conv2."}
    kept, mismatched = {}, []
    for name, value in tensors.items():
        place = next((place for place in doubles if name.startswith("text_encoder.tcn.network.") and f".{place}" in name), None)
        if place is None:
            kept[name] = value
            continue
        twin = tensors.get(name.replace(place, doubles[place]))
        if twin is None or not torch.equal(twin, value):
            mismatched.append(name)
    if mismatched:
        raise CheckpointUnreadable(f"{path} stores other values under {_listed(mismatched)} than under their twins.", _REMEDY)
    return kept


def _filled(module: torch.nn.Module, tensors: dict[str, torch.Tensor], path: str | PathLike) -> torch.nn.Module:
    expected = module.state_dict()
    counters = {name for name in expected if name.endswith("num_batches_tracked")}
    missing = sorted(expected.keys() - tensors.keys() - counters)
    unknown = sorted(tensors.keys() - expected.keys())
    shapes = [
        f"{name} is {tuple(tensors[name].shape)}, not {tuple(expected[name].shape)}"
        for name in sorted(expected.keys() & tensors.keys())
        if tensors[name].shape != expected[name].shape
    ]
    problems = [
        f"{word} {_listed(names)}"
        for word, names in (("missing:", missing), ("unknown:", unknown), ("of another shape:", shapes))
        if names
    ]
    if problems:
        message = f"{path} does not fit the published network ({'; '.join(problems)})."
        raise CheckpointUnreadable(message, _REMEDY)
    module.load_state_dict({name: tensors.get(name, value) for name, value in expected.items()})
    return module.eval()


def _discriminator(stored: Mapping[str, Any], config: ModelConfig, path: str | PathLike) -> Discriminator | None:
    if not any(name in stored for name in DISCRIMINATORS):
        return None
    return _filled(Discriminator(config), _state(stored, DISCRIMINATORS, path), path)


def _vocabulary(held: Any, file: str | PathLike | None, rows: int, what: str) -> list[str] | None:
    """Names in the order of a table's rows, from the authors' ``Vocab``; None where there is none."""
    found = held if file is None else pickles.read(file)
    if found is None:
        return None
    index = found.get("word2index") if isinstance(found, pickles.Record | Mapping) else None
    if not isinstance(index, Mapping):
        raise CheckpointUnreadable(
            f"The list of {what} is no Vocab object.", "Give the authors' vocab_cache.pkl or leave it out."
        )
    names = [""] * rows
    for name, row in index.items():
        if not isinstance(row, int) or not 0 <= row < rows:
            message = f"The list of {what} has {len(index)} entries up to row {row}, the network's table {rows}."
            raise CheckpointUnreadable(message, "Give the list that the network was trained with.")
        names[row] = str(name)
    return names


def _speakers(names: list[str] | None, count: int) -> list[dict]:
    """Row 0 is never trained in the authors' tables (reference section B.6), so the first performer is row 1."""
    rows = names or [""] * count
    speakers = [{"name": name or f"speaker {row}", "description": ""} for row, name in enumerate(rows)]
    if count > 1:
        speakers[0] = {"name": "untrained", "description": "The table's first row, which training never used."}
        speakers[1]["default"] = True
    return speakers


def _listed(names: list[str]) -> str:
    more = len(names) - _SHOWN
    return ", ".join(names[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
