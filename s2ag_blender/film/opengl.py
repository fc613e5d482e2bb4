"""Whether Blender will get an OpenGL context without a window. Asking first matters: where it does not, Blender aborts."""

import ctypes
import sys

_DEFAULT, _SURFACELESS = None, 0x31DD
"""Platforms of EGL that a headless Blender can draw on: the default one and ``EGL_PLATFORM_SURFACELESS_MESA``."""


def is_available() -> bool:
    """False only where EGL is certain to refuse: on Linux without libEGL or without a driver behind it."""
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
