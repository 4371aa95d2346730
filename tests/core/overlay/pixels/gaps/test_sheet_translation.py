"""Whole texels by which sheets of cloth are moved."""

import numpy as np

from core.arrays import Floats, Ints
from core.overlay.pixels.gaps.sheet_translation import find_translations

STEP = 12.0
BASIS = np.diag([STEP, STEP])
Y, X = np.indices((60, 120)).astype(float)
UV = np.stack([X / STEP + 0.1 * np.sin(Y / 30), Y / STEP + 0.1 * np.sin(X / 40)], -1)
SLOPES = np.broadcast_to(np.array([[0.0, 1.0], [1.0, 0.0]]), (*X.shape, 2, 2))


def three() -> Ints:
    """Return three sheets, with gaps."""
    sheet = np.full(X.shape, -1)
    for number, start in enumerate((0, 45, 90)):
        sheet[:, start : start + 30] = number
    return sheet


def moved_back(by: list[tuple[float, float]]) -> Floats:
    sheet = three()
    uv = UV + np.where((sheet >= 0)[..., None], np.array(by)[sheet], 0.0)
    return find_translations(uv, sheet, SLOPES, BASIS, STEP)


def test_sheets_are_moved_by_the_whole_texels_that_they_are_off() -> None:
    np.testing.assert_array_equal(moved_back([(0, 0), (7, -3), (-2, 5)]), [(0, 0), (-7, 3), (2, -5)])
    np.testing.assert_array_equal(moved_back([(0, 0), (7.2, -3.1), (-2, 4.8)]), [(0, 0), (-7, 3), (2, -5)])


def test_of_two_contacts_the_nearer_one_counts() -> None:
    """The last sheet is beside the middle one by few places that are near and another part of it by many far ones."""
    sheet = np.full(X.shape, -1)
    sheet[:, :30] = 0
    sheet[:8, 30:70] = sheet[:20, 62:70] = 0
    sheet[24:, 48:70] = 1
    uv = UV + np.where(((sheet == 0) & (X >= 30))[..., None], [2.0, 0.0], 0.0)
    np.testing.assert_array_equal(find_translations(uv, sheet, SLOPES, BASIS, STEP), [(0, 0), (2, 0)])


def test_a_single_sheet_stays_and_one_far_from_others_counts_on_from_them() -> None:
    sheet = np.zeros(X.shape, np.int64)
    np.testing.assert_array_equal(find_translations(UV, sheet, SLOPES, BASIS, STEP), [(0, 0)])
    sheet[:, 20:90], sheet[:, 90:] = -1, 1
    far = UV + np.where((sheet > 0)[..., None], [70.0, -41.0], 0.0)
    np.testing.assert_array_equal(find_translations(far, sheet, SLOPES, BASIS, STEP), [(0, 0), (-70, 41)])
