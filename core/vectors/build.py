"""Pack word vectors into product-quantised codes small enough to ship.

    python -m s2ag.core.vectors.build words-int8.npz -o core/assets/words.npz

The source contains ``words`` (newline-separated text), ``q`` int8 ``(n, 300)`` with row scales ``s``, the same for FastText
n-gram buckets in ``zq`` and ``zs``, and ``minn`` and ``maxn``. Each row is divided by its norm and split into 100 sub-vectors
of three coordinates, each stored as the number of the nearest of 256 centroids (product quantisation, Jegou et al. 2011).
Coordinates are distributed so that all sub-spaces have about the same variance. The output is deterministic; the program
prints the loss of accuracy.
"""

import argparse

import numpy as np

from ..files import atomic_file

SUBSPACES = 100
CENTROIDS = 256
ROUNDS = 25


def quantise(rows: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Quantise rows ``(n, 300)``.

    Returns ``codes`` ``(n, 100)`` uint8, ``centroids`` ``(100, 256, 3)`` float16, ``norms`` ``(n,)`` float16 and the
    ``order`` of axes ``(300,)`` int16.
    """
    norms = np.linalg.norm(rows, axis=1)
    rows = rows / np.maximum(norms, 1e-9)[:, None]
    order = balanced_order(rows.var(0))
    codes = np.empty((len(rows), SUBSPACES), np.uint8)
    centroids = np.empty((SUBSPACES, CENTROIDS, rows.shape[1] // SUBSPACES), np.float16)
    for space, axes in enumerate(order.reshape(SUBSPACES, -1)):
        centroids[space], codes[:, space] = _cluster(rows[:, axes], rng)
    return {"codes": codes, "centroids": centroids, "norms": norms.astype(np.float16), "order": order.astype(np.int16)}


def balanced_order(variance: np.ndarray) -> np.ndarray:
    """Return an order of the axes in which consecutive groups have nearly equal products of variances."""
    ranked = np.argsort(-variance, kind="stable").reshape(-1, SUBSPACES)
    groups = ranked[0][:, None]
    for ranks in ranked[1:]:
        poorest = np.argsort(np.log(np.maximum(variance[groups], 1e-12)).sum(1), kind="stable")
        groups = np.concatenate([groups[poorest], ranks[:, None]], axis=1)
    return groups.ravel()


def _cluster(points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Cluster by Lloyd's k-means; an empty centroid moves to the point that is farthest from its centroid.

    Returns the centroids in float16 and the label of every point.
    """
    from scipy.spatial import cKDTree  # pyright: ignore[reportAttributeAccessIssue]

    centroids = points[rng.choice(len(points), CENTROIDS, replace=len(points) < CENTROIDS)].astype(float)
    for _ in range(ROUNDS):
        distance, label = cKDTree(centroids).query(points)
        count = np.bincount(label, minlength=CENTROIDS)
        for axis in range(points.shape[1]):
            centroids[:, axis] = np.bincount(label, points[:, axis], CENTROIDS) / np.maximum(count, 1)
        empty = np.flatnonzero(count == 0)
        centroids[empty] = points[np.argsort(-distance, kind="stable")[: len(empty)]]
    centroids = centroids.astype(np.float16)
    return centroids, cKDTree(centroids.astype(float)).query(points)[1]


def _cosines(rows: np.ndarray, packed: dict[str, np.ndarray]) -> np.ndarray:
    """Return the cosine of every row, except zero rows, to its packed version."""
    from .table import decode

    restored = decode(packed, np.arange(len(rows)))
    norms = np.linalg.norm(rows, axis=1) * np.linalg.norm(restored, axis=1)
    return np.einsum("ij,ij->i", rows, restored)[norms > 0] / norms[norms > 0]


def main() -> None:
    """Read the source, pack words and n-grams with separate codebooks, print the loss and write the result."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("source", help="int8 vectors (.npz)")
    parser.add_argument("-o", "--output", required=True, help="packed vectors (.npz)")
    options = parser.parse_args()
    with np.load(options.source) as source:
        text = str(source["words"])
        tables = {
            "word": source["q"] * source["s"].astype(np.float32)[:, None],
            "ngram": source["zq"] * source["zs"].astype(np.float32)[:, None],
        }
        bounds = np.array([source["minn"], source["maxn"]], np.int16)
    rng = np.random.default_rng(0)
    arrays = {"words": np.frombuffer(text.encode(), np.uint8), "ngram_bounds": bounds}
    for name, rows in tables.items():
        packed = quantise(rows, rng)
        cosine = _cosines(rows, packed)
        worst = np.percentile(cosine, 1)
        print(f"{name}: {len(rows)} rows, cosine to the source: mean {cosine.mean():.4f}, 1st percentile {worst:.4f}")
        arrays.update({f"{name}_{key}": value for key, value in packed.items()})
    with atomic_file(options.output) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, **arrays)


if __name__ == "__main__":
    main()
