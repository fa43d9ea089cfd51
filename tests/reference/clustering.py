"""The cluster rule, read word for word from the contract, on a splitting graph.

Two regions merge where the saddle between them is less than the tolerance above the lowest
members of both, bottom-up along the tree; a region that did not become one pose is not
merged with anything.
"""

from __future__ import annotations


def merged_regions(root, heights, tolerance):
    """Poses as sets of stable faces, with the level of the saddle out of each.

    Parameters
    ----------
    root : SplittingNode
        Of the part at cluster tolerance 0, so that its poses are the stable faces.
    heights : sequence of float
        Of each stable face, metres.
    tolerance : float
        Metres.

    Returns
    -------
    dict
        frozenset of stable faces -> level in metres; infinite for a single pose.
    """
    regions = {}

    def gather(node, way_out):
        """Whether everything below a node is one pose; if not, its poses are noted."""
        if not node.parts:
            return True
        below = [gather(part, node.level) for part in node.parts]
        if all(below) and all(node.level - min(heights[i] for i in part.poses) < tolerance
                         for part in node.parts):
            for part in node.parts:
                regions.pop(frozenset(part.poses), None)
            regions[frozenset(node.poses)] = way_out
            return True
        for part in node.parts:
            if not part.parts:
                regions[frozenset(part.poses)] = node.level
        return False

    if gather(root, float("inf")):
        regions.setdefault(frozenset(root.poses), float("inf"))
    return regions
