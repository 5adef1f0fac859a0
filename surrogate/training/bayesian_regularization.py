"""MacKay's evidence parameters of F(w) = beta e'e + alpha w'w (Foresee and Hagan, ICNN 1997; the paper's section II-D).

With n errors e and P parameters w, and sums where the paper's eq. 15 has means,

    gamma = P - alpha tr[(beta J'J + alpha I)^-1],      alpha = gamma / (2 w'w),      beta = (n - gamma) / (2 e'e).

Up to a constant, exp(-F) is the posterior density of w. So the noise has the variance 1 / (2 beta), and w the posterior
covariance [2 beta J'J + 2 alpha I]^-1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from surrogate.scaling import Array

if TYPE_CHECKING:
    from torch import Tensor

ROUNDING = 1e-14
"""Share of a matrix's trace that rounding in its Cholesky factor may reach."""

FEW_PARAMETERS = 1e-6
"""A gamma below this is a difference of numbers too nearly equal."""


def shifted(JtJ: Tensor, beta: Tensor, shift: Tensor) -> Tensor:
    """Beta J'J + shift I (B, P, P)."""
    H = beta[:, None, None] * JtJ
    H.diagonal(dim1=1, dim2=2).add_(shift[:, None])
    return H


def effective_parameters(JtJ: Tensor, alpha: Tensor, beta: Tensor) -> Tensor:
    """Gamma = P - alpha tr[(beta J'J + alpha I)^-1] (B,).

    The difference is lost in rounding where alpha is far below or far above beta J'J. There the eigenvalues of J'J give
    the same number as sum beta lambda / (beta lambda + alpha), at a higher price.
    """
    import torch

    P = JtJ.shape[1]
    H = shifted(JtJ, beta, alpha)
    L, breakdown = torch.linalg.cholesky_ex(H)
    # With H = L L', tr(H^-1) is the sum of the squares of L^-1.
    identity = torch.eye(P, dtype=L.dtype, device=L.device)
    L_inverse = torch.linalg.solve_triangular(L, identity.expand_as(L), upper=False)
    gamma = P - alpha * (L_inverse * L_inverse).sum((1, 2))
    trace = H.diagonal(dim1=1, dim2=2).sum(1)
    lost = (breakdown != 0) | (alpha < ROUNDING * trace) | (gamma < FEW_PARAMETERS)
    if lost.any():
        eigenvalues = torch.linalg.eigvalsh(JtJ[lost])
        numerical_zero = eigenvalues < P * torch.finfo(L.dtype).eps * eigenvalues[:, -1:]
        determined = beta[lost, None] * eigenvalues.masked_fill(numerical_zero, 0.0)
        gamma[lost] = (determined / (determined + alpha[lost, None])).sum(1)
    return gamma


def evidence_parameters(gamma: Tensor, sse: Tensor, ssw: Tensor, n_errors: Tensor | float) -> tuple[Tensor, Tensor]:
    """Alpha and beta (B,) for gamma effective parameters (B,); a beta that is not positive and finite becomes 1."""
    import torch

    beta = (n_errors - gamma) / (2 * sse)
    return gamma / (2 * ssw), torch.where((beta > 0) & beta.isfinite(), beta, torch.ones_like(beta))


def log_evidence(JtJ: Array, alpha: float, beta: float, F: float, n_errors: float) -> float:
    """ln p(targets | alpha, beta) = -F - ln det(beta J'J + alpha I) / 2 + P ln(alpha) / 2 + n ln(beta / pi) / 2.

    Exact for a linear model at its least F; else in Laplace's approximation.
    """
    determined = beta * np.linalg.eigvalsh(JtJ).clip(min=0.0)
    # det(H) / alpha^P = prod(1 + beta lambda / alpha), which stays finite where alpha vanishes in H.
    occam = 0.5 * float(np.sum(np.log1p(determined / alpha)))
    return -F - occam + 0.5 * n_errors * float(np.log(beta / np.pi))


def posterior_factor(JtJ: Array, alpha: float, beta: float) -> Array:
    """Upper triangular K (P, P) with K'K = [2 beta J'J + 2 alpha I]^-1.

    By eigenvalues, which stay exact where alpha is lost in the rounding of beta J'J.
    """
    eigenvalues, V = np.linalg.eigh(JtJ)
    variances = 1.0 / (2.0 * beta * eigenvalues.clip(min=0.0) + 2.0 * alpha)
    return np.asarray(np.linalg.qr(np.sqrt(variances)[:, None] * V.T, mode="r"))
