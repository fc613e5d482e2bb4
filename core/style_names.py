"""What a style expression can be, for menus; needs nothing."""

RANDOM = "random"


def split_sequence(expression: str | dict) -> list[str | dict]:
    """Split a style sequence ``A > B > C``, evenly spaced from the recording's start to its end, into its styles."""
    return [part.strip() for part in expression.split(">")] if isinstance(expression, str) else [expression]
