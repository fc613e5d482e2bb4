"""The version of the package, of the extension and in the provenance on actions."""

VERSION = "0.1.0"
