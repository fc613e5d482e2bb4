"""Who imports whom in the package, read from its source."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("core", "rigs", "s2ag_blender")


@cache
def tree(path):
    return ast.parse(path.read_text("utf-8"))


def modules(*packages, root=ROOT):
    """Dotted name below the root -> file, of every module in ``packages``."""
    found = {}
    for package in packages:
        for path in (root / package).rglob("*.py"):
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


ALL = modules(*PACKAGES)


def statements(name, nested=True, known=ALL):
    """What module ``name`` imports, with the line: modules of ours by dotted name, others by their first word.

    ``nested`` includes imports inside functions, which happen when they are called and not at import time.
    """
    nodes = _executed(tree(known[name]), nested)
    package = name.split(".") if known[name].name == "__init__.py" else name.split(".")[:-1]
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((alias.name.split(".")[0], node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.split(".")[0], node.lineno
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] + (node.module.split(".") if node.module else [])
            for alias in node.names:
                inner = ".".join([*base, alias.name])
                yield (inner if inner in known else ".".join(base)), node.lineno


def _executed(node, nested):
    """All statements below ``node`` but those for type checkers alone and, without ``nested``, those inside functions."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)) and not nested:
            continue
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        yield child
        yield from _executed(child, nested)


@cache
def imports(name, nested=True):
    """What module ``name`` imports; kept, because every way through the package passes most modules."""
    return frozenset(imported for imported, _ in statements(name, nested))


def reachable(name, nested=True):
    """Everything that importing (and with ``nested`` running) ``name`` can import, with the packages on the way."""
    seen, todo = set(), [name]
    while todo:
        here = todo.pop()
        if here not in seen:
            seen.add(here)
            if here in ALL:
                parents = here.split(".")
                todo += [parent for end in range(1, len(parents)) if (parent := ".".join(parents[:end])) in ALL]
                todo += imports(here, nested)
    return seen
