"""The figures of an identification's report."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from plica.identify.estimator.posterior import Posterior, standard_deviations
from plica.identify.estimator.wording import CLOSE_TO_PRIOR, weakest
from plica.identify.results import Identification, Picture
from plica.report.drawing import Drawing, blue, draw, green, grey, ink, label_ends, over_time, purple, red

__all__ = ["sections"]

_PLOTTED_POINTS = 3  # points whose motion is plotted


def sections(found: Identification) -> list[tuple[str, list[Drawing]]]:
    """The figures of each section, by heading."""
    posterior, picture = found.posterior, found.picture
    return [
        ("Prior and posterior", [prior_and_posterior(posterior), correlation(posterior)]),
        ("Identifiability", [identifiability(posterior)]),
        ("Motion", [motion(picture), pressures(picture)]),
        ("Residuals over the tissue", [residual_map(picture)]),
    ]


def prior_and_posterior(posterior: Posterior) -> Drawing:
    """Both 95 % intervals of each parameter, over the median of its prior."""
    shown = np.flatnonzero(_logarithmic(posterior))
    spread = standard_deviations()

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for row, j in enumerate(shown):
            centre = posterior.mean[j] - posterior.prior_mean[j]
            bars = [(0.0, posterior.prior_sd[j], grey, 7.0)]
            if posterior.answered:
                bars.append((centre, posterior.sd[j], _colour(posterior, int(j)), 3.0))
            for middle, sd, colour, width in bars:
                ends = np.exp([middle - spread * sd, middle + spread * sd])
                axes.plot(ends, [row, row], color=colour, lw=width, solid_capstyle="butt")
            axes.plot(np.exp(centre), row, "o", color=_colour(posterior, int(j)), ms=6)
        axes.set_xscale("log")
        axes.set_yticks(range(len(shown)), [posterior.names[j] for j in shown])
        axes.set_xlabel("value over the prior's median")
        axes.set_ylim(len(shown) - 0.4, -0.6)
        kinds = (
            ("prior", grey),
            ("posterior", blue),
            ("posterior close to the prior", red),
            ("limited by the mesh", purple),
        )
        label_ends(axes, kinds)

    return draw(
        "Prior against posterior",
        "95 % intervals, including the shift between meshes. Where both are alike, the recording adds no "
        "information."
        if posterior.answered
        else "The prior's 95 % intervals; points: the estimate, whose interval is refused.",
        "Intervals of prior and posterior of each parameter.",
        (9.2, 1.1 + 0.34 * len(shown)),
        paint,
    )


def correlation(posterior: Posterior) -> Drawing:
    """The posterior's correlation matrix."""
    names = list(posterior.names)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        image = axes.imshow(posterior.correlation, cmap="RdBu_r", vmin=-1, vmax=1)
        axes.set_xticks(range(len(names)), names, rotation=40, ha="right")
        axes.set_yticks(range(len(names)), names)
        for (i, j), value in np.ndenumerate(posterior.correlation):
            if i != j and abs(value) >= 0.05:
                dark = "white" if abs(value) > 0.6 else "black"
                axes.text(j, i, f"{value:+.1f}", ha="center", va="center", color=dark, fontsize=8)
        figure.colorbar(image, ax=axes, shrink=0.8)

    return draw(
        "Correlation",
        "Near 1 or -1: only a combination of the two parameters is known.",
        "Matrix of the correlations between parameters.",
        (2.6 + 0.5 * len(names), 1.8 + 0.42 * len(names)),
        paint,
    )


def identifiability(posterior: Posterior) -> Drawing:
    """Eigenvalues of the information in units of the prior."""
    values = posterior.information_eigenvalues

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        colours = [red if value < 1 else blue for value in values]
        axes.bar(range(1, len(values) + 1), np.maximum(values, 1e-3), color=colours, width=0.6)
        axes.set_yscale("log")
        axes.axhline(1, color=grey, lw=1)
        axes.set_xticks(range(1, len(values) + 1))
        axes.set_xlabel("combination of parameters, weakest first")
        axes.set_ylabel("information, recording / prior")

    return draw(
        "Identifiability",
        "Information of the recording over that of the prior, for each independent combination. Below 1 "
        "(red) the prior is more informative than the recording. Weakest: " + weakest(posterior) + ".",
        "Bars: information of the recording on each combination of parameters.",
        (9.2, 2.8),
        paint,
    )


def close_to_prior(posterior: Posterior) -> NDArray[np.bool_]:
    """(p) Whether the sd on one mesh is close to that of the prior."""
    sd = np.sqrt(np.diag(posterior.statistical_covariance))
    return np.asarray(sd > CLOSE_TO_PRIOR * posterior.prior_sd)


def motion(picture: Picture) -> Drawing:
    """Observed and predicted motion of the points that move most."""
    size = np.nanmean(np.nansum(picture.observed**2, axis=2), axis=0)
    chosen = np.argsort(size)[::-1][:_PLOTTED_POINTS]
    time = 1e3 * picture.time

    def paint(figure: Figure) -> None:
        panels = np.atleast_1d(figure.subplots(len(chosen), 1, sharex=True))
        for axes, point in zip(panels, chosen, strict=True):
            for c, colour in ((0, blue), (1, green)):
                axes.plot(time, picture.observed[:, point, c], ".", color=colour, ms=4)
                axes.plot(time, picture.predicted[:, point, c], color=colour, lw=1)
            _shade(axes, time, picture.closed)
        label_ends(panels[0], [("to the right", blue), ("downwards", green)])
        column, row = picture.start[chosen].T
        over_time(*((axes, f"{column[k]:.0f}, {row[k]:.0f} (px)") for k, axes in enumerate(panels)))

    return draw(
        "Predicted against observed motion",
        "Motion from frame to frame (px) of the points that move most, by their place in the first "
        f"frame. Dots: observed; lines: the model with the expected unknown pressures, which explains "
        f"{100 * picture.explained:.1f} % of the variance of all points. Shaded: closed.",
        "Motion of points over time, observed and predicted.",
        (9.2, 1.0 + 1.5 * len(chosen)),
        paint,
    )


def pressures(picture: Picture) -> Drawing:
    """Expected values of the unknown pressures."""
    time, count = 1e3 * picture.time, len(picture.heights)
    colours = [blue, red, green, grey]

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for k in range(count):
            axes.plot(time, picture.pressures[:, k], color=colours[k % 4], lw=1)
        _shade(axes, time, picture.closed)
        names = [(f"z = {1e3 * z:.3g} mm", colours[k % 4]) for k, z in enumerate(picture.heights)]
        label_ends(axes, names)
        over_time((axes, "pressure (Pa)"))

    drive = "in addition to the known drive" if picture.known_drive else "no pressure is known"
    return draw(
        "Unknown pressures",
        f"Expected values at each height of the glottis; {drive}. Before 0 ms they set the model in motion.",
        "Unknown pressures over time.",
        (9.2, 2.6),
        paint,
    )


def residual_map(picture: Picture) -> Drawing:
    """Size and mean of the whitened residuals at each point."""
    scores = picture.whitened
    known = np.isfinite(scores).any(axis=(0, 2))
    size = np.sqrt(np.nanmean(scores[:, known] ** 2, axis=(0, 2)))
    mean = np.nanmean(scores[:, known], axis=0)
    x, y = picture.start[known].T

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        image = left.scatter(x, y, c=size, cmap="viridis", s=28, vmin=0)
        figure.colorbar(image, ax=left, shrink=0.8, label="root mean square")
        longest = float(np.max(np.hypot(*mean.T), initial=1e-9))
        right.quiver(x, y, mean[:, 0], mean[:, 1], color=ink, angles="xy", width=0.004)
        for axes, name in ((left, "size"), (right, f"mean, longest {longest:.2g}")):
            axes.set_title(name)
            axes.set_aspect("equal")
            axes.set_xlabel("column (px)")
        left.set_ylabel("row (px)")
        left.invert_yaxis()

    return draw(
        "Whitened residuals",
        "Each has size 1 and mean 0 if the model holds. A region of larger size, or arrows in one "
        "direction, show where the model does not follow the tissue.",
        "Size and mean of the residuals at each point of the tissue.",
        (9.2, 4.0),
        paint,
    )


def _logarithmic(posterior: Posterior) -> NDArray[np.bool_]:
    if posterior.logarithmic is None:
        return np.ones(len(posterior.names), dtype=bool)
    return np.asarray(posterior.logarithmic)


def _colour(posterior: Posterior, j: int) -> str:
    if not posterior.answered:
        return ink
    if close_to_prior(posterior)[j]:
        return red
    return purple if posterior.sd[j] > CLOSE_TO_PRIOR * posterior.prior_sd[j] else blue


def _shade(axes: Axes, time: NDArray[np.float64], closed: NDArray[np.bool_]) -> None:
    low, high = axes.get_ylim()
    axes.fill_between(time, low, high, where=closed.tolist(), step="mid", color=grey, alpha=0.18, lw=0)
    axes.set_ylim(low, high)
