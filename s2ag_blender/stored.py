"""JSON that lies in properties of a .blend, which anybody may have written: it is what we store there, or it is nothing."""

from ..core import json_text

LARGEST = 16_000_000
"""Letters of one property; a pose and all settings take some ten thousand."""


def read(owner, name: str, kind: type = dict):
    """The dict or list (``kind``) that the custom property ``name`` states; an empty one where it states none."""
    text = owner.get(name)
    if not isinstance(text, str):
        return kind()
    try:
        value = json_text.parse(text, LARGEST)
    except json_text.NotJson:
        return kind()
    return value if isinstance(value, kind) else kind()


def fits(value, kinds: dict[str, type | tuple]) -> bool:
    """Whether everything that ``value`` holds of ``kinds`` is of its kind; a truth value is no number."""
    return all(isinstance(value[name], kind) and type(value[name]) is not bool for name, kind in kinds.items() if name in value)
