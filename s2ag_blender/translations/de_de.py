"""German."""

TABLE: dict[str, str] = {}
