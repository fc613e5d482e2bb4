# SPDX-License-Identifier: GPL-3.0-or-later
"""S2AG: characters that talk with their bodies.

The root of this tree is both a Blender extension and the Python package ``s2ag``; nothing heavy is imported here.
"""

from .core.version import VERSION as __version__  # noqa: F401


def register():
    """Register the extension in Blender."""
    from .s2ag_blender import registration

    registration.register()


def unregister():
    """Undo :func:`register`."""
    from .s2ag_blender import registration

    registration.unregister()
