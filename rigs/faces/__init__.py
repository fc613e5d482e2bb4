"""From a face's channels to the shape keys and bones of any face: families as data in ``families``, maps that can be edited."""
