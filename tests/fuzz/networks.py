"""The doors of networks: weights and facts in our form, and the files of others that are imported."""

import hashlib
import json
import random
import tempfile
from functools import cache, partial
from pathlib import Path

import doors
import folders
import mutations
import numpy as np
from door import Door, Seeds, put, written
from toy_corpus import META, toy_arrays


@cache
def _checkpoint() -> tuple[bytes, dict]:
    """Weights and facts of a small network that draws."""
    import torch
    from s2ag.core.model import checkpoint
    from s2ag.core.model.config import ModelConfig
    from s2ag.core.model.flow import FlowGenerator

    torch.manual_seed(0)
    torch.set_num_threads(1)
    config = ModelConfig.flow(speakers=2, meanings=4, flow_size=16, flow_condition=16)
    facts = {"speakers": [{"name": "a", "description": "b"}] * 2, "training": {"settings": {"frames": 64, "seed_frames": 10}}}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "small.safetensors"
        checkpoint.save(path, FlowGenerator(config), None, facts)
        return path.read_bytes(), json.loads(path.with_suffix(".json").read_text("utf-8"))


def _load(path: Path) -> None:
    """Both backends, with facts that know the weights or weights that the facts know."""
    from s2ag.core.model import loading

    weights, facts = path.with_name("net.safetensors"), path.with_name("net.json")
    if path.suffix == ".json":
        put(path, facts)
        weights.write_bytes(_checkpoint()[0])
    else:
        put(path, weights)
        known = hashlib.sha256(weights.read_bytes()).hexdigest() if weights.is_file() else ""
        facts.write_text(json.dumps(_checkpoint()[1] | {"weights_sha256": known}))
    outcomes = []
    for backend in ("numpy", "torch"):
        try:
            outcomes.append(loading.load(weights, backend))
        except loading.S2agError as error:
            outcomes.append(error)
    for outcome in outcomes:
        if isinstance(outcome, loading.S2agError):
            raise outcome


def _damage_weights(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """Bytes, or the JSON of the header with a length that fits."""
    length = int.from_bytes(data[:8], "little")
    if chance.random() < 0.4 or length > len(data):
        return mutations.of_bytes(data, chance, others)
    header = mutations.of_json(data[8 : 8 + length], chance, [b"{}"])
    return len(header).to_bytes(8, "little") + header + data[8 + length :]


def _foreign() -> Seeds:
    import torch

    state = {
        "text_encoder.embedding.weight": torch.zeros(4, 300), "speaker_embedding.0.weight": torch.zeros(3, 16),
        "audio_encoder.conv1.weight": torch.zeros(2, 3), "net.0.weight": torch.arange(6.0).reshape(2, 3),
    }  # fmt: skip
    content = {"gen_dict": state, "dis_dict": state, "epoch": 3, "args": {"a": [1, 2]}}

    def zipped(path):
        torch.save(content, path)

    def legacy(path):
        torch.save(content, path, _use_new_zipfile_serialization=False)

    return written((".pth", zipped), (".bin", legacy))


def _import(path: Path) -> None:
    from s2ag.core.model import checkpoint_import

    checkpoint_import.import_checkpoint(path, path.with_name("out.safetensors"))


def _corpus(folder: Path) -> None:
    for name, array in toy_arrays(talks=4, frames=80).items():
        np.save(folder / f"{name}.npy", array)
    (folder / "meta.json").write_text(json.dumps(META))


def _pack(path: Path) -> None:
    """A packed corpus whose windows are gathered as training does."""
    from s2ag.core.learning.train.dataset import TRAIN, Corpus, Windows

    corpus = Corpus.load(folders.beside(_corpus, path))
    talk, first = corpus.spread_windows(TRAIN, 4, 34)
    flips = np.arange(len(talk)) % 2 == 0
    corpus.batch(Windows(talk, first, flips, ~flips), 34, 4)
    corpus.speakers, corpus.meanings  # noqa: B018 (read from what came in)


def _settings() -> Seeds:
    some = {"data": "corpus", "out": "run", "batch": 8, "frames": 48, "steps": 3, "model": "flow", "mirror": 0.5}
    some |= {"model_settings": {"gru_size": 32, "mfcc_channels": [16, 16, 16]}, "kept": {"start": 0.3, "frames": 0.1}}
    return [(".json", json.dumps(some).encode())]


def _train(path: Path) -> None:
    from s2ag.core.learning.train import __main__ as command
    from s2ag.core.learning.train.config import TrainConfig

    TrainConfig.from_dict(command._read(path))


def _network():
    import torch

    torch.manual_seed(0)
    network = torch.nn.Linear(3, 2)
    adam = torch.optim.Adam(network.parameters())
    network(torch.ones(1, 3)).sum().backward()
    adam.step()
    return {"network": network, "adam": adam}


def _state() -> Seeds:
    from s2ag.core.learning.train import state

    return written((".safetensors", lambda path: state.save(path, _network(), {"step": 3, "random": [1, 2]})))


def _continue(path: Path) -> None:
    from s2ag.core.learning.train import state

    state.load(path, _network())


doors.DOORS |= {
    door.name: door
    for door in (
        Door("weights", lambda: [(".safetensors", _checkpoint()[0])], _load, _damage_weights),
        Door("facts", lambda: [(".json", json.dumps(_checkpoint()[1]).encode())], _load, mutations.of_json),
        Door("import", _foreign, _import),
        Door("corpus", partial(folders.files, _corpus), _pack, folders.damage_file),
        Door("settings", _settings, _train, mutations.of_json),
        Door("state", _state, _continue, _damage_weights),
    )
}
