# SPDX-License-Identifier: GPL-3.0-or-later
"""S2AG: speech to upper-body gesture.

The root of this tree is both a Blender extension and the Python package ``s2ag``. Scripts use :class:`Session`,
:class:`Request` and :class:`Motion`, which load on first use: importing the package loads nothing heavy, not even numpy.
"""

from typing import TYPE_CHECKING

from .core.version import VERSION as __version__  # noqa: F401

if TYPE_CHECKING:
    from .core.motion.motion import Motion
    from .core.synthesis.request import Request
    from .core.synthesis.session import Session

__all__ = ["Motion", "Request", "Session"]


def __getattr__(name: str) -> type:
    """Import the front door's classes on first use."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .core.motion.motion import Motion
    from .core.synthesis.request import Request
    from .core.synthesis.session import Session

    globals().update(Motion=Motion, Request=Request, Session=Session)
    return globals()[name]


def register() -> None:
    """Register the extension in Blender."""
    from .s2ag_blender import registration

    registration.register()


def unregister() -> None:
    """Undo :func:`register`."""
    from .s2ag_blender import registration

    registration.unregister()
