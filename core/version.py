"""The one version of the package, the extension and the provenance on actions."""

VERSION = "0.1.0"
