"""``--from SHEET.json:5``: a cell of ``s2ag sample`` in place of a recording and its settings."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..declaration import Setting
from ..errors import UsageError
from ..settings import Settings, names_with, table
from ..settings import command_options as options_of

if TYPE_CHECKING:
    from ..synthesis.request import Request


def request_of_cell(
    options: argparse.Namespace, network: Path | None, value_of: Callable[[Setting], Any], has_words: bool
) -> "Request":
    """Return the request that reproduces a cell of a sample; sets ``options.audio`` to its recording by default.

    The cell must be of this ``network`` (None: the shipped one). ``value_of`` gives the value of a setting by the
    options; ``has_words`` says whether they tell where the words come from.
    """
    from ..sampling import sheet
    from ..synthesis.request import Request

    own = [one for one in options_of(Settings) if "own" in one.cell]
    if any(getattr(options, one.name) not in (one.usually, None, []) for one in own):
        flags = ", ".join(one.flag for one in own if not one.control)
        raise UsageError("A chosen cell has its own style, seed and settings.", f"Leave out {flags} and the controls.")
    named = "" if options.audio is None else str(options.audio.absolute())
    values = sheet.request_of_cell(options.chosen, network, named)
    is_other = named not in ("", values["audio"])
    options.audio = options.audio or Path(values["audio"])
    if is_other or has_words:
        words = {name: value_of(table(Settings)[name]) for name in names_with(words=True)}
        values |= {"audio": options.audio, **words}
    free = [one for one in options_of(Settings) if not (one.cell or one.alternatives or one.partner)]
    return Request(**values, **{one.name: value_of(one) for one in free})
