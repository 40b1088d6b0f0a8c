"""Regularised solutions of ill-posed linear equations matrix @ unknown = right.

The unknown is white noise before the measurement (Tikhonov regularisation), or small singular
values are left out (truncated). The strength of the regularisation is chosen by generalised
cross-validation (Golub, Heath and Wahba 1979, doi:10.1080/00401706.1979.10489751), by the corner of
the L-curve (Hansen 1992, doi:10.1137/1034115; found by the method of Satopaa and
others 2011, doi:10.1109/ICDCSW.2011.20), or such that the residual is the noise.
"""
import numpy as np

from trackbed_post import read

STRENGTHS = np.logspace(-6, 0, 61)  # over the largest singular value
CRITERIA = ("gcv", "l_curve", "residual")
METHODS = ("tikhonov", "truncated")


class Solution:
    """`unknown`; `strength` and root mean square `residual`; standard deviation of the `noise`;
    `curves`: strengths, residuals, norms of the unknown, values of the cross-validation."""

    def __init__(self, decomposition, right, method="tikhonov", criterion="gcv", noise=0.0):
        """`decomposition`: of the matrix by numpy.linalg.svd; `noise`: of the right side, needed by
        the criterion "residual" alone."""
        left, self.values, self.vectors = decomposition
        self.projected = left.T @ right
        self.outside = max(float(right @ right - self.projected @ self.projected), 0.0)
        self.count, self.method = len(right), method
        self.curves = (STRENGTHS, *np.transpose([self.measures(one) for one in STRENGTHS]))
        self.strength = float(STRENGTHS[chosen(criterion, self.curves, noise)])
        self.kept = self.filtered(self.strength)
        self.unknown = self.vectors.T @ (self.kept * self.projected / self.values)
        self.residual = float(self.measures(self.strength)[0])
        free = max(self.count - self.kept.sum(), 1.0)
        self.noise = self.residual * np.sqrt(self.count / free)

    def filtered(self, strength):
        """Factor of each singular value."""
        limit = strength * self.values[0]
        if self.method == "truncated":
            return (self.values >= limit).astype(float)
        return self.values**2 / (self.values**2 + limit**2)

    def measures(self, strength):
        """(root mean square residual, norm of the unknown, generalised cross-validation)."""
        kept = self.filtered(strength)
        square = self.outside + np.sum(((1 - kept) * self.projected)**2)
        norm = np.linalg.norm(kept * self.projected / self.values)
        free = 1 - kept.sum() / self.count
        return np.sqrt(square / self.count), norm, square / max(free, 1e-12)**2

    def evidence(self):
        """-2 log likelihood of the right side, but for a constant, if unknown and noise are white
        and have their most likely strengths (MacKay 1992, doi:10.1162/neco.1992.4.3.415)."""
        limits = (STRENGTHS * self.values[0])[:, None]**2
        total = self.values**2 + limits
        square = np.sum(self.projected**2 / total, axis=1) + self.outside / limits[:, 0]
        rest = (self.count - len(self.values)) * np.log(limits[:, 0])
        return float(np.min(self.count * np.log(square) + np.sum(np.log(total), axis=1) + rest))

    def before(self):
        """Standard deviation of the unknown before the measurement; 0 of what was truncated."""
        if self.method == "truncated":
            return 0.0
        return self.noise / (self.strength * self.values[0])

    def variance(self, rows, sum_of_squares):
        """Variances of linear functions of the unknown. `rows`: these functions of each singular
        vector, [vector, function]; sum_of_squares: of the coefficients of a function."""
        if self.method == "truncated":
            return (self.kept * (self.noise / self.values)**2) @ rows**2
        return self.before()**2 * np.maximum(sum_of_squares - self.kept @ rows**2, 0)

    def draw(self, random):
        """An unknown from its distribution after the measurement."""
        if self.method == "truncated":
            size = self.kept * self.noise / self.values
            return self.unknown + self.vectors.T @ (size * random.standard_normal(len(size)))
        white = self.before() * random.standard_normal(self.vectors.shape[1])
        return self.unknown + white - \
            self.vectors.T @ ((1 - np.sqrt(1 - self.kept)) * (self.vectors @ white))


def chosen(criterion, curves, noise):
    """Number of the strength."""
    _, residuals, norms, validation = curves
    if criterion == "gcv":
        return int(np.argmin(validation))
    if criterion == "residual":
        if not noise > 0:
            raise read.Unreadable('the criterion "residual" needs the noise of a sample')
        if noise < residuals[0]:
            raise read.Unreadable(
                f'the criterion "residual" has no solution: the noise is {noise:.3g}, the least '
                f'residual of any strength {residuals[0]:.3g}, in the unit of the record: the '
                "noise is larger than stated, or speed, train or Green's functions are others; "
                'choose the criterion "gcv"')
        return int(np.flatnonzero(residuals <= noise)[-1])
    # The point of the L-curve that is farthest from the line between its ends.
    logs = [np.log(np.maximum(one, 1e-300)) for one in (residuals, norms)]
    return int(np.argmin(sum((one - one.min()) / max(np.ptp(one), 1e-300) for one in logs)))
