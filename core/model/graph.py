"""Adjacency matrices of skeleton edges and of body parts for the affective encoder."""

from collections.abc import Sequence

import numpy as np

from ..motion.skeleton import EDGES

PARTS = ((0, 1, 2), (3, 4, 5), (6, 7, 8))
"""Edges of the trunk, the left arm and the right arm (paper section 3.1.4)."""
PART_LINKS = ((0, 1), (0, 2))


def edge_links(graph: str) -> tuple[tuple[int, int], ...]:
    """Return pairs of neighbouring edges: "chain" links an edge to its parent edge, "line" all edges that share a joint."""
    pairs = [(a, b) for a in range(len(EDGES)) for b in range(a + 1, len(EDGES))]
    if graph == "chain":
        return tuple((a, b) for a, b in pairs if EDGES[a][1] == EDGES[b][0])
    return tuple((a, b) for a, b in pairs if set(EDGES[a]) & set(EDGES[b]))


def hop_distance(nodes: int, links: Sequence[tuple[int, int]]) -> np.ndarray:
    """Return hop counts between all nodes, ``(nodes, nodes)`` float; infinite where there is no path."""
    distance = np.where(np.eye(nodes, dtype=bool), 0.0, np.inf)
    for a, b in links:
        distance[a, b] = distance[b, a] = 1.0
    for middle in range(nodes):
        distance = np.minimum(distance, distance[:, middle, None] + distance[None, middle])
    return distance


def adjacency(nodes: int, links: Sequence[tuple[int, int]], hops: int, partition: str) -> np.ndarray:
    """Return matrices ``(groups, nodes, nodes)`` float32; entry ``[k, v, w]`` weights node v in the sum for node w.

    "unweighted" is one 0/1 matrix of all nodes within ``hops`` (paper section 3.1.4). "spatial" divides each column by
    its number of neighbours and splits it into the node itself and, for each hop, the neighbours at least as far from
    the centre (node 0) as w, and those nearer to it (reference section A.6)."""
    distance = hop_distance(nodes, links)
    near = distance <= hops
    if partition == "unweighted":
        return near[None].astype(np.float32)
    weight = near / near.sum(0)
    outward = distance[0][:, None] >= distance[0][None, :]
    groups = [np.where(distance == 0, weight, 0)]
    for hop in range(1, hops + 1):
        at_hop = np.where(distance == hop, weight, 0)
        groups += [at_hop * outward, at_hop * ~outward]
    return np.stack(groups).astype(np.float32)
