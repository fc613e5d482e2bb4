"""Checks whether Blender can get an OpenGL context without a window; without one, Blender aborts."""

import ctypes
import sys

_DEFAULT, _SURFACELESS = None, 0x31DD
"""EGL platforms that headless Blender can use: the default one and ``EGL_PLATFORM_SURFACELESS_MESA``."""


def is_available() -> bool:
    """Return False only where EGL certainly fails: on Linux without libEGL or without a driver for it."""
    if not sys.platform.startswith("linux"):
        return True
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        get_default, get_platform, initialize = egl.eglGetDisplay, egl.eglGetPlatformDisplay, egl.eglInitialize
    except (OSError, AttributeError):
        return False
    pointer = ctypes.c_void_p
    get_default.argtypes, get_default.restype = [pointer], pointer
    get_platform.argtypes, get_platform.restype = [ctypes.c_uint, pointer, pointer], pointer
    initialize.argtypes, initialize.restype = [pointer] * 3, ctypes.c_uint
    for platform in (_SURFACELESS, _DEFAULT):
        display = get_platform(platform, None, None) if platform else get_default(None)
        if display and initialize(display, None, None):
            return True
    return False
