"""The parser of options, of which every command's is one."""

import argparse

from ..errors import UsageError


class Parser(argparse.ArgumentParser):
    """argparse, whose complaints are one sentence like all others."""

    def error(self, message):
        raise UsageError(f"{message[:1].upper()}{message[1:]}.", f"See: {self.prog} --help")
