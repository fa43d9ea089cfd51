"""Pixels of a part: what is nearest is seen, and where it ought to be."""

import numpy as np
import pytest

from ros_pose_stats.plots.rendering import PART, View, rendered

DOWN = View(np.zeros(3), 2.0, (100, 100), elevation=90.0, azimuth=-90.0)
"""Straight from above, x to the right and y up the picture; 50 pixels a metre."""


def slab(x0, x1, y0, y1, z):
    """A rectangle that faces up, as two triangles."""
    a, b, c, d = ([x, y, z] for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)))
    return np.array([[a, b, c], [a, c, d]], dtype=float)


def blue(picture):
    """Which pixels show the part: all others are grey."""
    return np.ptp(picture.astype(int), axis=2) > 20


def test_a_rectangle_covers_its_pixels_and_no_others():
    shown = blue(rendered(slab(-0.5, 0.3, -0.2, 0.6, 0.1), DOWN))
    rows, columns = np.nonzero(shown)
    assert (columns.min(), columns.max() + 1) == pytest.approx((25, 65), abs=1)
    assert (rows.min(), rows.max() + 1) == pytest.approx((20, 60), abs=1)
    assert shown.sum() == pytest.approx(40 * 40, rel=0.06)


def test_the_nearer_of_two_hides_the_farther_whatever_their_order():
    near, far = slab(-0.5, 0.0, -0.5, 0.5, 0.4), slab(-0.8, 0.8, -0.8, 0.8, 0.1)
    one, two = (rendered(np.concatenate(pair), DOWN) for pair in ((near, far), (far, near)))
    assert (one == two).all()
    # The step between the two has an outline, the middle of each has none.
    assert one[50, 50].max() < 200
    assert (one[50, 20] == one[50, 80]).all()


def test_what_faces_away_is_not_drawn():
    assert not blue(rendered(slab(-0.5, 0.5, -0.5, 0.5, 0.1)[:, ::-1], DOWN)).any()


def test_a_seam_between_triangles_has_no_gap_and_no_line():
    inside = rendered(slab(-0.5, 0.5, -0.5, 0.5, 0.1), DOWN)[30:70, 30:70]
    assert (inside == inside[0, 0]).all()


def test_a_part_throws_its_shadow_straight_down_on_the_plate():
    view = View(np.zeros(3), 2.0, (100, 100), elevation=45.0, azimuth=-90.0, plate=0.7)
    picture = rendered(slab(-0.2, 0.2, -0.2, 0.2, 0.5), view)
    greys = picture[50, 50]
    assert np.ptp(greys) == 0
    assert greys[0] < picture[50, 20, 0] < 255
    assert blue(picture)[50 - round(25 * np.sqrt(0.5)), 50]


def test_nothing_within_the_picture_leaves_it_white():
    assert (rendered(slab(5.0, 6.0, 5.0, 6.0, 0.1), DOWN) == 255).all()
    assert (rendered(np.zeros((0, 3, 3)), DOWN) == 255).all()
    assert (rendered(np.zeros((3, 3, 3)), DOWN) == 255).all()


def test_a_brighter_color_gives_a_brighter_picture():
    dim, light = (rendered(slab(-0.5, 0.5, -0.5, 0.5, 0.1), DOWN, color)[50, 50].astype(int)
                  for color in (0.5 * PART, PART))
    assert (light > 1.8 * dim).all()
