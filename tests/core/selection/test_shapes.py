import numpy as np

from core.selection.shapes import ellipse_outline, fill_polygon, rectangle_outline


def test_a_rectangle_is_filled_to_the_pixel() -> None:
    mask = fill_polygon((40, 30), rectangle_outline(np.array([5.0, 4.0]), np.array([20.0, 12.0])))
    assert mask.shape == (30, 40)
    rows, columns = np.nonzero(mask > 127)
    assert (columns.min(), rows.min(), columns.max(), rows.max()) == (5, 4, 20, 12)


def test_an_ellipse_has_its_area() -> None:
    mask = fill_polygon((200, 100), ellipse_outline(np.array([180.0, 90.0]), np.array([20.0, 10.0])))
    # Pixels that the outline runs through are in.
    assert np.pi * 80 * 40 <= (mask > 127).sum() <= np.pi * 81 * 41
    assert mask[50, 100] == 255
    assert mask[12, 22] == 0


def test_what_lies_outside_the_picture_is_cut_off_and_a_line_encloses_nothing() -> None:
    far = np.array([[-1e9, -1e9], [1e9, -1e9], [1e9, 1e9], [-1e9, 1e9]])
    assert fill_polygon((8, 6), far).min() == 255
    assert not fill_polygon((8, 6), far[:2]).any()
