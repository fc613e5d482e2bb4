"""The command ``s2ag``: the only place that turns errors into a sentence and an exit status.

Imports the package only within :func:`main`, so that Ctrl-C is handled during imports, too."""

import sys

FAILED = 2
INTERRUPTED = 130


def main(argv: list[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, 2 after an error (printed to stderr), 130 after Ctrl-C."""
    try:
        if argv is None:
            set_up_process()
        return _run(argv)
    except KeyboardInterrupt:
        print("s2ag: interrupted.", file=sys.stderr)
        return INTERRUPTED


def set_up_process() -> None:
    """Set up signals, output encoding and warnings of this process."""
    import contextlib
    import os
    import signal
    import warnings

    # Handle these signals like Ctrl-C, so that a farm's kill also removes temporary files and child processes.
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) != signal.SIG_IGN:  # as nohup sets it
            signal.signal(getattr(signal, name), signal.default_int_handler)
    with contextlib.suppress(AttributeError):  # no console, or a replaced stream
        # for consoles of Windows; stderr does so by default
        sys.stdout.reconfigure(errors="backslashreplace")  # pyright: ignore[reportAttributeAccessIssue]
    if not (sys.warnoptions or os.environ.get("S2AG_DEBUG")):
        warnings.simplefilter("ignore")  # of Python and packages: they are for developers


def _run(argv: list[str] | None) -> int:
    """Parse the command line and run the command; every exception but Ctrl-C becomes one sentence on stderr."""
    import contextlib
    import os

    from ..errors import EngineMissing, S2agError
    from .progress import say

    try:
        from .parser import parser, require_available

        arguments = sys.argv[1:] if argv is None else argv
        require_available(arguments)
        options = parser().parse_args(arguments)
        return options.run(options)
    except SystemExit as exit_request:  # --help and --version
        return int(exit_request.code or 0)
    except S2agError as error:
        say(f"{error}" if error.kind != "Cancelled" else "cancelled.")
        return FAILED
    except ModuleNotFoundError as error:
        say(f"{EngineMissing.of(error)}")
        return FAILED
    except BrokenPipeError:
        # The reader of our output has closed the pipe; without this Python prints an error at its exit, too.
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return FAILED
    except OSError as error:
        say(f"{error.filename or 'A file'} failed: {error.strerror or error}. Check the path and the free space.")
        return FAILED
    except MemoryError:
        say("there is not enough memory for this. Use shorter recordings, or fewer takes at once.")
        return FAILED
    except Exception as error:
        if os.environ.get("S2AG_DEBUG"):
            raise
        from .. import crash_log

        say(f"this is a mistake in s2ag ({type(error).__name__}: {error}). {crash_log.write_log(error)}")
        return FAILED


if __name__ == "__main__":
    sys.exit(main())
