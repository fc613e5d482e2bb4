"""Reads untrusted pickles without executing anything in them.

A pickle is a program that may call any function by name, so Python's own reader is never used. This one interprets the
opcodes and builds numbers, strings, containers and numpy arrays; every instance of a class and every call becomes an inert
:class:`Record` of its arguments.
"""

import pickletools
from collections.abc import Iterable
from os import PathLike
from typing import Any

import numpy as np

from ..errors import S2agError
from ..files import read_bytes


class PickleUnreadable(S2agError):
    """A pickle is damaged or of an unknown kind."""


class Record:
    """Placeholder for an instance of a class, or for a call, that was not executed: its ``arguments`` and ``state``."""

    state: Any = None
    arguments: tuple = ()

    def __init__(self, *arguments: Any, **named: Any):
        self.arguments = arguments

    def __setstate__(self, state: Any) -> None:
        self.state = state

    def get(self, name: str, default: Any = None) -> Any:
        """Return a value of the state by name."""
        return self.state.get(name, default) if isinstance(self.state, dict) else default


def placeholder_class(module: str, name: str) -> type[Record]:
    """Create the placeholder class for ``module.name``."""
    return type(name, (Record,), {"__module__": module, "__qualname__": name})


def read(source: bytes | str | PathLike) -> Any:
    """Return the content of a pickle in memory or in a file; raises :class:`PickleUnreadable`."""
    name = "The pickle" if isinstance(source, bytes) else str(source)
    try:
        data = source if isinstance(source, bytes) else read_bytes(source)
        return _Reader().read(data)
    except Exception as error:  # a damaged pickle can raise anything
        reason = " ".join(str(error).split())[:120]
        raise PickleUnreadable(f"{name} cannot be read ({type(error).__name__}: {reason}).", "Get the file again.") from error


_MARK = object()
_LITERALS = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False, "EMPTY_TUPLE": ()}
_FRESH = {"EMPTY_LIST": list, "EMPTY_DICT": dict, "EMPTY_SET": set}
_TUPLES = {"TUPLE1": 1, "TUPLE2": 2, "TUPLE3": 3}
_IGNORED = ("PROTO", "FRAME")
_STORING = ("PUT", "BINPUT", "LONG_BINPUT")
_FETCHING = ("GET", "BINGET", "LONG_BINGET")
_COPY_ALLOWANCE = 1_000_000
"""Values that any pickle may copy, beside eight for each of its bytes."""
_SIZED = (str, bytes, bytearray, list, tuple, dict, set, frozenset)
_CONTAINERS = {kind.__name__: kind for kind in (set, frozenset, bytearray, list, tuple, dict)}


class _Reader:
    """The pickle machine's stack, marks and memo; no opcode calls anything that a pickle names."""

    def __init__(self):
        self.stack: list[Any] = []
        self.memo: dict[int, Any] = {}
        self.memo_keys: dict[int, list[int]] = {}  # of records, by their id
        self.copies_left = 0

    def read(self, data: bytes) -> Any:
        self.copies_left = _COPY_ALLOWANCE + 8 * len(data)
        for opcode, argument, _ in pickletools.genops(data):
            if opcode.name == "STOP":
                return self.stack.pop()
            self.step(opcode.name, argument)
        raise ValueError("it has no end")

    def step(self, name: str, argument: Any) -> None:
        if name in _LITERALS:
            self.stack.append(_LITERALS[name])
        elif name in _FRESH:
            self.stack.append(_FRESH[name]())
        elif name in _TUPLES:
            self.stack[-_TUPLES[name] :] = [tuple(self.stack[-_TUPLES[name] :])]
        elif name in _STORING:
            self.store(int(argument))
        elif name in _FETCHING:
            self.stack.append(self.memo[int(argument)])
        elif hasattr(self, f"do_{name.lower()}"):
            getattr(self, f"do_{name.lower()}")(argument)
        elif name not in _IGNORED:
            if argument is None or "PERSID" in name or "EXT" in name:
                raise ValueError(f"it uses {name}")
            self.stack.append(argument)  # numbers, strings and bytes are literals

    def store(self, place: int) -> None:
        self.memo[place] = self.stack[-1]
        if isinstance(self.stack[-1], Record):
            self.memo_keys.setdefault(id(self.stack[-1]), []).append(place)

    def spend(self, value: Any) -> None:
        """Count copied values: a few bytes of a pickle could request the same copy again and again."""
        if isinstance(value, _SIZED):
            self.copies_left -= len(value)
        if self.copies_left < 0:
            raise ValueError("it copies more than it holds")

    def since_mark(self) -> list[Any]:
        mark = len(self.stack) - 1 - next(i for i, value in enumerate(reversed(self.stack)) if value is _MARK)
        values = self.stack[mark + 1 :]
        del self.stack[mark:]
        return values

    def do_mark(self, _) -> None:
        self.stack.append(_MARK)

    def do_pop(self, _) -> None:
        self.stack.pop()

    def do_pop_mark(self, _) -> None:
        self.since_mark()

    def do_dup(self, _) -> None:
        self.stack.append(self.stack[-1])

    def do_memoize(self, _) -> None:
        self.store(len(self.memo))

    def do_tuple(self, _) -> None:
        self.stack.append(tuple(self.since_mark()))

    def do_list(self, _) -> None:
        self.stack.append(self.since_mark())

    def do_dict(self, _) -> None:
        values = self.since_mark()
        self.stack.append(dict(zip(_keys(values[::2]), values[1::2], strict=True)))

    def do_frozenset(self, _) -> None:
        self.stack.append(frozenset(self.since_mark()))

    def do_append(self, _) -> None:
        self.extend([self.stack.pop()])

    def do_appends(self, _) -> None:
        self.extend(self.since_mark())

    do_additems = do_appends

    def extend(self, values: list[Any]) -> None:
        owner = self.stack[-1]
        if isinstance(owner, set):
            owner.update(_keys(values))
        elif isinstance(owner, list):
            owner.extend(values)

    def do_setitem(self, _) -> None:
        value, key = self.stack.pop(), self.stack.pop()
        self.fill([key, value])

    def do_setitems(self, _) -> None:
        self.fill(self.since_mark())

    def fill(self, values: list[Any]) -> None:
        if isinstance(self.stack[-1], dict):
            self.stack[-1].update(zip(_keys(values[::2]), values[1::2], strict=True))

    def do_global(self, argument: str) -> None:
        module, _, name = argument.partition(" ")
        self.stack.append(placeholder_class(module, name))

    def do_stack_global(self, _) -> None:
        name, module = self.stack.pop(), self.stack.pop()
        self.stack.append(placeholder_class(str(module), str(name)))

    def do_reduce(self, _) -> None:
        arguments, kind = self.stack.pop(), self.stack.pop()
        for argument in arguments if isinstance(arguments, tuple) else ():
            self.spend(argument)
        self.stack.append(_construct(kind, arguments))

    do_newobj = do_reduce

    def do_newobj_ex(self, _) -> None:
        self.stack.pop()
        self.do_reduce(None)

    def do_inst(self, argument: str) -> None:
        module, _, name = argument.partition(" ")
        self.stack.append(_construct(placeholder_class(module, name), tuple(self.since_mark())))

    def do_obj(self, _) -> None:
        kind, *arguments = self.since_mark()
        self.stack.append(_construct(kind, tuple(arguments)))

    def do_build(self, _) -> None:
        state, owner = self.stack.pop(), self.stack[-1]
        if not isinstance(owner, Record):
            return
        owner.state = state
        if _qualified_name(type(owner)) in _ARRAYS:
            self.spend(state[-1])
            array = _array(state)
            for place in self.memo_keys.pop(id(owner), ()):
                self.memo[place] = array
            self.stack[-1] = array


def _keys(values: list[Any]) -> list[Any]:
    """Return the values if all are simple keys; hashing deeply nested tuples could take for ever."""
    simple = (str, int, float, bytes, type(None))
    for value in values:
        if not (isinstance(value, simple) or (type(value) is tuple and all(isinstance(item, simple) for item in value))):
            raise ValueError("it has keys that are no texts and no numbers")
    return values


_ARRAYS = ("numpy.core.multiarray._reconstruct", "numpy._core.multiarray._reconstruct")
_SCALARS = ("numpy.core.multiarray.scalar", "numpy._core.multiarray.scalar")


def _qualified_name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _construct(kind: Any, arguments: tuple) -> Any:
    """Return the result of calling ``kind`` for containers and numbers, and a :class:`Record` for everything else."""
    if not (isinstance(kind, type) and issubclass(kind, Record) and isinstance(arguments, tuple)):
        raise ValueError("it calls something that is no name")
    name = _qualified_name(kind)
    module, _, last = name.rpartition(".")
    if name == "collections.OrderedDict":
        return _container(dict, *arguments[:1])
    if (
        module in ("builtins", "__builtin__")
        and last in _CONTAINERS
        and all(isinstance(a, list | tuple | bytes) for a in arguments)
    ):
        return _container(_CONTAINERS[last], *arguments[:1])
    if name == "_codecs.encode" and isinstance(arguments[0], str):
        return arguments[0].encode("latin1")
    if name in _SCALARS:
        return np.frombuffer(_bytes(arguments[1]), _dtype(arguments[0]), 1)[0].item()
    return kind(*arguments)


def _container(kind: type, content: Iterable[Any] = ()) -> Any:
    if kind in (set, frozenset):
        _keys(list(content))
    elif kind is dict and not isinstance(content, dict):
        _keys([key for key, _ in content])
    return kind(content)


def _array(state: tuple) -> np.ndarray:
    _, shape, dtype, fortran, data = state
    flat = np.frombuffer(_bytes(data), _dtype(dtype)).copy()
    return flat.reshape(shape, order="F" if fortran else "C")


def _dtype(record: Record) -> np.dtype:
    order = record.state[1] if isinstance(record.state, tuple) and record.state[1] in "<>" else ""
    kind = np.dtype(order + str(record.arguments[0]))
    if kind.hasobject:
        raise ValueError("it holds an array of objects")
    return kind


def _bytes(data: Any) -> bytes:
    if not isinstance(data, str | bytes | bytearray):
        raise ValueError("an array has no bytes")
    return data.encode("latin1") if isinstance(data, str) else bytes(data)
