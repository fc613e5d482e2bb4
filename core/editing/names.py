"""Names and limits of edits that menus need, too; needs nothing."""

BEAT = "beat"
"""Kind of a gesture that follows the rhythm of speech and has no meaning of its own."""
REST = "rest"
"""Kind of an edit by which no gesture is there: hands go home for a moment."""
LEAST, LARGEST = 0.4, 2.0
"""Least and largest factor on a gesture's size."""
