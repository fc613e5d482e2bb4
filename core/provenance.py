"""The settings in a motion's provenance: what is written there when a take is made, and read to make it again."""

from collections.abc import Mapping
from typing import Any

from .declaration import NUMBERS, table
from .settings import Settings, names_with


def stated(settings: Settings) -> dict[str, Any]:
    """Return the settings that a motion's provenance states, as JSON has them."""
    values = {one: getattr(settings, name) for name, one in table(Settings).items()}
    return {one.name: _as_json(one.kind, value) for one, value in values.items()
            if one.meta == "always" or (one.meta == "set" and (value != one.default if one.default else value))}  # fmt: skip


def restored(meta: Mapping[str, Any], part: str) -> dict[str, Any]:
    """Return the settings that made ``part`` of a take (:attr:`Setting.restored`) from its provenance; in old takes recordings
    had no part in chance."""
    known = {name: meta[name] for name in names_with(restored=part) if meta.get(name) is not None}
    return {"chance": 0} | {name: _of_json(table(Settings)[name].kind, value) for name, value in known.items()}


def _as_json(kind: str, value: Any) -> Any:
    """Return the value of a setting of this kind as JSON has it."""
    if kind in NUMBERS:
        return float(value)
    if kind == "affects":
        return {name: float(share) for name, share in value.items()}
    return [list(row) for row in value] if kind == "list" else value


def _of_json(kind: str, value: Any) -> Any:
    """Return the value of a setting of this kind from provenance, where a sequence of styles is a list."""
    if kind != "style" or not isinstance(value, list):
        return value
    steps = (one if isinstance(one, str) else "+".join(f"{name}:{weight:g}" for name, weight in one.items()) for one in value)
    return ">".join(steps) if len(value) > 1 else value[0]
