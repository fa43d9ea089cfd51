"""Folders of parts that the tests of the catalogue share."""

from ros_pose_stats import shapes
from ros_pose_stats.catalogue.rows import describe_part
from tests.bodies import write_stl

SIZES = [(10.0, 20.0, 30.0 + k) for k in range(6)]


def boxes(folder, sizes=SIZES):
    """Boxes as STL files in millimetres."""
    folder.mkdir(parents=True, exist_ok=True)
    for k, size in enumerate(sizes):
        write_stl(folder / f"box_{k}.stl", shapes.box(*size))
    return folder


def here(made=None, backwards=False):
    """A maker in this process, which notes what it is asked for."""
    def make(request, pieces, should_stop):
        for piece in reversed(pieces) if backwards else pieces:
            if should_stop():
                return
            if made is not None:
                made.append((piece[0].name.rpartition("/")[2], piece[1]))
            yield piece, describe_part(piece[0].name, None, request, piece[1])

    return make
