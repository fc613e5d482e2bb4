"""Damage of every kind, always the same for the same random numbers."""

import io
import json
import random
import re

import numpy as np

LARGEST = 300_000
"""Bytes of an input: what breaks by size alone has tests of its own."""
JUNK = [
    *('"', "\\", "[", "]", "{", "}", ",", ":", "\n", "\n\n", "\t", "-->", "<00:00:01.000>", "<v ", "NaN", "1e999", "-1", "{}"),
    *("null", "true", "9" * 400, "\0", "\ud800", "\ufeff", "*", "{none}", "[pause]", "{point left}", "SPEAKER:", "$20 million"),
    *('""', "99:99:99,999", "é", "\U0001f600", "\ue0007", "%", "1990s", "3.5 %", ";;", "<exists>", '"IntervalTier"', "-0"),
    *("[" * 2000, "intervals [2]:", "\x1b[2J", "../../x", "http://a/b", "file:///etc/passwd", "=" * 999, "\r", "\u202e"),
    *("k" * 5000, "Infinity", "JOINT a {", "}" * 50, "End Site", "Frames: 999999999", "Frame Time: 0", "CHANNELS 999999999"),
    *("\u1369", "\u00b2", "\u0661\u0662", "\u2460", "\u00bd", "\u4e94", "\ufdfa", "CHANNELS 0", "{as calm}", "$\u1369"),
]  # fmt: skip
NUMBERS = (0, 1, -1, 2, 127, 255, 2**15, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
VALUES = (
    *(None, True, False, 0, -1, 1, 0.5, -0.5, 1e300, 1e-300, -1e9, 10**17, 2**63, "", "a", "\0", "x" * 3000, "NaN", [], {}),
    *([[]], [None], {"a": None}, float("nan"), float("inf"), [1e400], "{", "../x", [[1, 2], [3]], "0", "12:30", 3.7, "é"),
)


def of_bytes(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """One kind of damage to bytes; ``others`` are what pieces may come from."""
    place = chance.randrange(len(data) + 1)
    end = min(place + 1 + int(chance.random() ** 3 * 300), len(data))
    kind = chance.randrange(9)
    if kind == 0:
        return data[:place]
    if kind == 1:
        return data[:place] + data[end:]
    if kind == 2:
        return data[:end] + data[place:]
    if kind == 3:
        return data[:place] + chance.randbytes(end - place) + data[end:]
    if kind == 4:
        width = chance.choice((1, 2, 4, 8))
        number = (chance.choice(NUMBERS) % 256**width).to_bytes(width, chance.choice(("little", "big")))
        return data[:place] + number + data[place + width :]
    if kind == 5:
        other = chance.choice(others)
        return data[:place] + other[chance.randrange(len(other) + 1) :]
    if kind == 6:
        return data[:place] + data[place:end] * chance.randrange(2, 200) + data[end:]
    if kind == 7:
        flipped = bytearray(data)
        for _ in range(chance.randrange(1, 6) if data else 0):
            flipped[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        return bytes(flipped)
    return data[end:] + data[place:end] + data[:place]


def of_text(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """One kind of damage to text; what is no UTF-8 is damaged as bytes."""
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8")
    except UnicodeDecodeError:
        return of_bytes(data, chance, others)
    kind, junk = chance.randrange(5), chance.choice(JUNK)
    if kind == 0:
        return of_bytes(data, chance, others)
    place = chance.randrange(len(text) + 1)
    if kind == 1:
        numbers = list(re.finditer(r"-?\d+(\.\d+)?", text))
        if numbers:
            chosen = chance.choice(numbers)
            return _encoded(text[: chosen.start()] + junk + text[chosen.end() :])
    if kind == 2:
        lines = text.splitlines(keepends=True)
        chance.shuffle(lines)
        return _encoded("".join(lines[: chance.randrange(len(lines) + 1)] * chance.choice((1, 1, 2, 30))))
    if kind == 3:
        return _encoded(text[:place] + junk + text[place + chance.randrange(9) :])
    return _encoded(text[:place] + junk * chance.choice((1, 1, 1, 2, 50)) + text[place:])


def of_json(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """A value that is not what it was somewhere in JSON; what is no JSON is damaged as text."""
    try:
        value = json.loads(data)
    except (ValueError, RecursionError):
        return of_text(data, chance, others)
    if chance.randrange(4) == 0:
        return of_text(data, chance, others)
    for _ in range(chance.randrange(1, 4)):
        value = _changed(value, chance)
    return _encoded(json.dumps(value, ensure_ascii=chance.random() < 0.9))


def _changed(value, chance: random.Random):
    """``value`` with something odd in it: deeper down, or in its own place."""
    keys = list(value) if isinstance(value, dict) else list(range(len(value))) if isinstance(value, list) else []
    if not keys or chance.randrange(6) == 0:
        return chance.choice(VALUES)
    key, kind, made = chance.choice(keys), chance.randrange(8), value.copy()
    if kind == 0:
        del made[key]
    elif kind == 1 and isinstance(made, dict):
        made[chance.choice(JUNK)] = made.pop(key)
    elif kind == 2 and isinstance(made, list):
        made += made * chance.randrange(1, 9)
    else:
        made[key] = _changed(made[key], chance)
    return made


def of_lines(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """A line of JSON lines damaged, or all as text."""
    lines = data.split(b"\n")
    if chance.random() < 0.3:
        return of_text(data, chance, others)
    place = chance.randrange(len(lines))
    lines[place] = of_json(lines[place], chance, others)
    return b"\n".join(lines)


def of_arrays(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """An ``.npz`` with arrays of other kinds and shapes, or bytes of one damaged."""
    if chance.random() < 0.5:
        return of_bytes(data, chance, others)
    try:
        with np.load(io.BytesIO(data)) as held:
            arrays = {name: held[name] for name in held.files}
    except Exception:  # damaged before, in any of numpy's and zipfile's ways
        return of_bytes(data, chance, others)
    for _ in range(chance.randrange(1, 3)):
        if arrays:
            name = chance.choice(sorted(arrays))
            with np.errstate(all="ignore"):
                arrays[name] = _other(arrays[name], chance)
            if chance.randrange(8) == 0:
                del arrays[name]
    made = io.BytesIO()
    np.savez_compressed(made, **arrays)
    return made.getvalue()


def of_array(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """An ``.npy`` of another kind and shape, or bytes of it damaged."""
    if chance.random() < 0.4:
        return of_bytes(data, chance, others)
    try:
        array = np.load(io.BytesIO(data))
    except Exception:  # damaged before, in any of numpy's ways
        return of_bytes(data, chance, others)
    made = io.BytesIO()
    with np.errstate(all="ignore"):
        np.save(made, _other(array, chance))
    return made.getvalue()


def _other(array: np.ndarray, chance: random.Random) -> np.ndarray:
    """An array that differs in kind, shape or content."""
    kind = chance.randrange(9)
    if kind == 0:
        kinds = ("f2", "f8", "c16", "i1", "u8", "S3", "U5", "?")
        # text that was made of numbers' bytes may be no text any more
        return array.astype(chance.choice(kinds)) if array.dtype.kind in "fiu" else np.full(array.shape, "text")
    if kind == 1:
        return array[:0] if array.ndim else np.zeros(0)
    if kind == 2:
        return array.reshape(-1)
    if kind == 3:
        return array[None]
    if kind == 4:
        return np.array(chance.choice(("{}", "[]", "[[1,2,3]]", '[["a", "b", "c"]]', "[" * 3000, "null", '[["a", 1e999, -1]]')))
    if kind == 5:
        odd = (np.nan, np.inf, -1e30, 1e-30, 0) if array.dtype.kind == "f" else (0, 1, 100)
        return np.full_like(array, chance.choice(odd))
    if kind == 6:
        return np.concatenate([array, array]) if array.ndim else array.repeat(3)
    if kind == 7 and array.dtype.kind == "f" and array.size:
        made = array.copy()
        made.flat[chance.randrange(array.size)] = chance.choice((np.nan, np.inf, 1e38, -1))
        return made
    return np.swapaxes(array, 0, -1) if array.ndim else np.array(chance.choice((0.0, -1.0, np.nan, np.inf, 1e-9, 1e12)))


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")


def damaged(number: int, name: str, seeds: list[tuple[str, bytes]], damage) -> tuple[str, bytes]:
    """Suffix and content of input ``number`` of the door ``name``: one of its ``seeds``, damaged once to four times."""
    chance = random.Random(f"{name} {number}")
    suffix, data = chance.choice(seeds)
    others = [content for _, content in seeds]
    for _ in range(chance.choice((1, 1, 2, 4))):
        data = damage(data, chance, others)[:LARGEST]
    return suffix, data
