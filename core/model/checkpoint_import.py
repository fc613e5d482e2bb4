"""Import of the authors' checkpoints of S2AG and GTC (reference section D.4b), without executing anything in them."""

import io
import pickletools
import zipfile
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import torch

from ..errors import CheckpointUnreadable
from . import checkpoint, paper_networks, safe_pickle
from .config import ModelConfig
from .discriminator import Discriminator
from .generator import Generator

GENERATORS = ("gen_model_dict", "gen_dict", "trimodal_gen_dict")
DISCRIMINATORS = ("dis_model_dict", "dis_dict")
_RENAMED = {"speaker_logvar.": "speaker_log_var."}
_LEGACY_PICKLES = 4
"""Consecutive pickles in files of torch before 1.6: magic number, protocol, system, structure of the weights."""
_MAX_LISTED = 12
_REMEDY = "Give the generator's file of Speech2AffectiveGestures (.pth.tar) or of Trimodal Context (.bin)."

Network = TypeVar("Network", bound=torch.nn.Module)


def import_checkpoint(
    path: str | PathLike,
    out: str | PathLike,
    vocabulary: str | PathLike | None = None,
    speakers: str | PathLike | None = None,
) -> dict:
    """Convert ``path`` into ``out`` (.safetensors and .json) and return the metadata that was written.

    Parameter names determine the kind of network, table shapes the numbers of words and speakers; everything else must
    have the published shape. ``vocabulary`` and ``speakers`` are the authors' pickled ``Vocab`` objects; GTC's files hold
    both. Without a vocabulary the network ignores words, without speakers they are numbered. Raises
    :class:`CheckpointUnreadable`, which names every tensor that does not fit.
    """
    stored = read(path)
    tensors = _state(stored, GENERATORS, path)
    config = recognise_config(tensors, path)
    generator = _load_weights(Generator(config), tensors, path)
    discriminator = _discriminator(stored, config, path)
    words = _vocabulary(stored.get("lang_model"), vocabulary, config.words, "words")
    names = _vocabulary(stored.get("speaker_model"), speakers, config.speakers, "speakers")
    meta: dict[str, Any] = {
        "speakers": _speakers(names, config.speakers),
        "vocabulary": words,
        "training": {"source": Path(path).name, "kind": config.name, "settings": {"frames": config.frames, "seed_frames": 4}},
    }
    meta["weights_sha256"] = checkpoint.save(out, generator, discriminator, meta, half=False)
    return meta | {"config": config.to_dict(), "parameters": sum(p.numel() for p in generator.parameters())}


def read(path: str | PathLike) -> Mapping[str, Any]:
    """Return the top level of a ``torch.save`` file, with tensors on the CPU and other objects as
    :class:`safe_pickle.Record`.
    """
    path = Path(path)
    if not path.is_file():
        raise CheckpointUnreadable(f"There is no checkpoint {path}.", _REMEDY)
    try:
        with torch.serialization.safe_globals([safe_pickle.placeholder_class(*name) for name in sorted(_foreign_names(path))]):
            stored = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises a dozen types for damaged files
        reason = " ".join(str(error).split())[:160]
        raise CheckpointUnreadable(
            f"{path} cannot be read ({type(error).__name__}: {reason}).", "Get the file again."
        ) from error
    if not isinstance(stored, Mapping):
        raise CheckpointUnreadable(f"{path} holds no dictionary of weights.", _REMEDY)
    return stored


def _foreign_names(path: Path) -> set[tuple[str, str]]:
    """Return module and name of every class in the file that is not torch's own; parses opcodes and imports nothing."""
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
                assert argument is not None
                module, _, name = argument.partition(" ")
                if module.split(".")[0] not in ("torch", "collections"):
                    names.add((module, name))
    return names


def recognise_config(tensors: Mapping[str, torch.Tensor], path: str | PathLike = "The file") -> ModelConfig:
    """Return the configuration of the published network that has these parameters."""
    affect, wave = "aff_encoder.conv3.weight" in tensors, "audio_encoder.feat_extractor.0.weight" in tensors
    mfcc = "audio_encoder.conv1.weight" in tensors
    try:
        words, speakers = (len(tensors[f"{name}.weight"]) for name in ("text_encoder.embedding", "speaker_embedding.0"))
    except KeyError as error:
        raise CheckpointUnreadable(f"{path} holds no gesture generator: {error.args[0]} is missing.", _REMEDY) from error
    if not (wave or mfcc):
        raise CheckpointUnreadable(f"{path} holds a generator that hears neither MFCCs nor raw audio.", _REMEDY)
    if affect:
        return (paper_networks.without_mfcc if wave else paper_networks.published)(words, speakers)
    # GTC's code writes LeakyReLU(True), which has slope 1; its weights were trained with that linear activation.
    return paper_networks.trimodal(words, speakers, head_slope=1.0) if wave else paper_networks.without_affect(words, speakers)


def _state(stored: Mapping[str, Any], names: tuple[str, ...], path: str | PathLike) -> dict[str, torch.Tensor]:
    """Return the state dict under one of ``names``, or the file itself, with this project's parameter names."""
    state = next((stored[name] for name in names if name in stored), stored)
    if not isinstance(state, Mapping) or not any(isinstance(value, torch.Tensor) for value in state.values()):
        raise CheckpointUnreadable(f"{path} holds none of {', '.join(names)}.", _REMEDY)
    tensors = {}
    for name, value in state.items():
        if not isinstance(name, str) or not isinstance(value, torch.Tensor):
            continue
        name = name.removeprefix("module.")
        for old, new in _RENAMED.items():
            name = new + name.removeprefix(old) if name.startswith(old) else name
        tensors[name] = value
    return _drop_duplicates(tensors, path)


def _drop_duplicates(tensors: dict[str, torch.Tensor], path: str | PathLike) -> dict[str, torch.Tensor]:
    """Drop the second copies of the text encoder's convolutions, which are stored under ``net.0`` and ``net.4``, too."""
    duplicates = {"net.0.": "conv1.", "net.4.": "conv2."}
    unique, mismatched = {}, []
    for name, value in tensors.items():
        in_text = name.startswith("text_encoder.tcn.network.")
        place = next((place for place in duplicates if in_text and f".{place}" in name), None)
        if place is None:
            unique[name] = value
            continue
        original = tensors.get(name.replace(place, duplicates[place]))
        if original is None or not torch.equal(original, value):
            mismatched.append(name)
    if mismatched:
        raise CheckpointUnreadable(f"{path} stores other values under {_listed(mismatched)} than under their twins.", _REMEDY)
    return unique


def _load_weights(module: Network, tensors: dict[str, torch.Tensor], path: str | PathLike) -> Network:
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
    return _load_weights(Discriminator(config), _state(stored, DISCRIMINATORS, path), path)


def _vocabulary(stored: Any, file: str | PathLike | None, rows: int, what: str) -> list[str] | None:
    """Return names in the order of a table's rows, from the authors' ``Vocab`` in ``file`` or else ``stored``, or None."""
    vocabulary = stored if file is None else safe_pickle.read(file)
    if vocabulary is None:
        return None
    index = vocabulary.get("word2index") if isinstance(vocabulary, safe_pickle.Record | Mapping) else None
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
    """Return the speaker entries. The authors never train row 0 (reference section B.6), so row 1 is the default."""
    rows = names or [""] * count
    speakers: list[dict[str, Any]] = [{"name": name or f"speaker {row}", "description": ""} for row, name in enumerate(rows)]
    if count > 1:
        speakers[0] = {"name": "untrained", "description": "The table's first row, which training never used."}
        speakers[1]["default"] = True
    return speakers


def _listed(names: list[str]) -> str:
    more = len(names) - _MAX_LISTED
    return ", ".join(names[:_MAX_LISTED]) + (f" and {more} more" if more > 0 else "")
