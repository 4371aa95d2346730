"""Correlation of many patches with a template as products of matrices.

A patch v and a template t, of N places and C channels, are compared under weights w, one or zero, after their mean per
channel under the weights, a and b, is taken out and their norm divided by. With W = Σ w, and f a linear form,

    Σ w f (v - a) = Σ w f v - Σ_c a_c Σ w f_c,    |v - a|² = Σ w v² - W Σ_c a_c²,

and the same for t, so that no patch is ever centred.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.arrays import Floats, Singles

LEAST_CONTRAST = 1e-6
"""Share of a patch's squares about its mean under which it is even: what is less may be rounding."""
LEAST_SHARE = 0.5
"""Share of a patch that has to be known; others score -1."""


@dataclass(frozen=True)
class Forms:
    """Linear forms (P, N, C) of patches; the first is the template, of mean zero per channel and norm one."""

    values: Singles

    @cached_property
    def _of_values(self) -> Singles:
        """(N C, P + C): the forms, and the sum of each channel."""
        count, places, channels = self.values.shape
        sums = np.tile(np.eye(channels, dtype=np.float32), (places, 1))
        return np.concatenate([self.values.reshape(count, -1).T, sums], 1)

    @cached_property
    def _of_weights(self) -> Singles:
        """(N, C P + P): the forms by channel, and what they make of the template."""
        by_channel = self.values.transpose(1, 2, 0)
        own = np.einsum("ncp,nc->np", by_channel, self.values[0])
        return np.concatenate([by_channel.reshape(len(own), -1), own], 1)

    @cached_property
    def _of_all(self) -> Singles:
        """(1, C P + P): the same under weights of one."""
        return np.asarray(self._of_weights.sum(0, keepdims=True))

    def compared(self, patches: Singles, weights: Singles | None) -> tuple[Floats, Floats]:
        """Return the correlation (K,) of patches (K, N, C), and the other forms (K, P - 1) of what differs.

        The `weights` (K, N) are one or zero, all one if they are not given.
        """
        count, (number, places, channels) = len(self.values), patches.shape
        flat = mask_patches(patches, weights).reshape(number, -1)
        total = np.full((1, 1), places, np.float32) if weights is None else weights.sum(1, keepdims=True)
        of_weights = self._of_all if weights is None else weights @ self._of_weights
        across, own = np.split(of_weights, [channels * count], axis=1)
        across = across.reshape(-1, channels, count)
        products = flat @ self._of_values
        means, own_means = products[:, count:] / np.maximum(total, 1), across[..., 0] / np.maximum(total, 1)
        found = products[:, :count] - np.einsum("kc,kcp->kp", means, across)
        own = own - np.einsum("kc,kcp->kp", own_means, across)
        squares = np.einsum("kn,kn->k", flat, flat)[:, None]
        found = found / root(squares - total * (means**2).sum(1, keepdims=True), squares)
        own_norm = root(own[:, :1], own[:, :1])
        scores = np.where(total > LEAST_SHARE * places, found[:, :1] / own_norm, -1)
        return scores[:, 0].astype(np.float64), (found[:, 1:] - own[:, 1:] / own_norm).astype(np.float64)


@dataclass(frozen=True)
class Windows:
    """A template (n, n, C), of mean zero per channel and norm one, at S places of a wider raster."""

    template: Singles
    shifts: int
    """Steps of the raster by which it is moved to each side of the middle, in both directions."""

    @property
    def side(self) -> int:
        """Places along a side of the wider raster."""
        return len(self.template) + 2 * self.shifts

    @cached_property
    def _moved(self) -> Singles:
        """(N, C, S): the template at each place, zero around."""
        n, (height, width, channels) = 2 * self.shifts + 1, self.template.shape
        moved = np.zeros((self.side, self.side, channels, n, n), np.float32)
        for i in range(n):
            for j in range(n):
                moved[i : i + height, j : j + width, :, i, j] = self.template
        return moved.reshape(self.side**2, channels, n * n)

    @cached_property
    def _windows(self) -> Singles:
        """(N, S): one where the template lies."""
        ones = Windows(np.ones((*self.template.shape[:2], 1), np.float32), self.shifts)
        return ones._moved[:, 0]

    @cached_property
    def _squares(self) -> Singles:
        """(N, S): the template's squares, all channels together."""
        return np.asarray((self._moved**2).sum(1))

    def scores(self, patches: Singles, weights: Singles | None) -> Floats:
        """Return the correlation (K, S) of patches (K, N, C) at each place; `weights` as for `Forms`."""
        number, places, channels = patches.shape
        known = mask_patches(patches, weights)
        sums = np.ascontiguousarray(np.swapaxes(known, 1, 2)).reshape(-1, places) @ self._windows
        sums = sums.reshape(number, channels, -1)
        found = known.reshape(number, -1) @ self._moved.reshape(places * channels, -1)
        squares = np.einsum("knc,knc->kn", known, known) @ self._windows
        size = float(self.template.shape[0] * self.template.shape[1])
        if weights is None:
            norms = root(squares - (sums**2).sum(1) / size, squares)
            return np.asarray(found / norms, np.float64)
        total = weights @ self._windows
        across = (weights @ self._moved.reshape(places, -1)).reshape(number, channels, -1)
        whole = np.maximum(total, 1)
        found = found - (sums * across).sum(1) / whole
        own = weights @ self._squares - (across**2).sum(1) / whole
        norms = root(squares - (sums**2).sum(1) / whole, squares) * root(own, own)
        return np.where(total > LEAST_SHARE * size, found / norms, -1).astype(np.float64)


def mask_patches(patches: Singles, weights: Singles | None) -> Singles:
    """Return patches (K, N, C), zero where the weights (K, N) are."""
    return patches if weights is None else np.asarray(patches * weights[..., None], np.float32)


def root(squares: Singles, of: Singles) -> Singles:
    """Return the norm of patches from their squares about the mean and their own, never zero.

    Where next to nothing of a patch is known, rounding may make both negative.
    """
    return np.asarray(np.sqrt(np.maximum(squares, LEAST_CONTRAST * np.maximum(of, 0) + 1e-12)), np.float32)
