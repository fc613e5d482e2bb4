"""Maps face channels to the shape keys and bones of any face, by naming families (JSON in ``families``) and editable maps."""
