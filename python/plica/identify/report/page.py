"""The report of an identification: one self-contained HTML page, warnings first."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import jinja2
import numpy as np

from plica._engine import build_info
from plica.identify.estimator import wording
from plica.identify.estimator.posterior import Posterior
from plica.identify.report.figures import close_to_prior, sections
from plica.identify.results import Identification
from plica.report.wording import number
from plica.storage.files import write_text

__all__ = ["write_report"]


@dataclass(frozen=True)
class Row:
    """A line of the posterior's table."""

    name: str
    unit: str
    median: str
    sd: str
    interval: str
    prior: str
    verdict: str


def write_report(found: Identification) -> Path:
    """Write report.html beside the results; returns its path."""
    path = found.directory / "report.html"
    template = files("plica.identify.report").joinpath("page.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    text = environment.from_string(template).render(
        title=f"Tissue from {found.picture.name}",
        remark=remark(found),
        warnings=found.warnings,
        rows=rows(found),
        identifiable=_identifiable(found.posterior),
        residuals=_residuals(found.posterior),
        sections=sections(found),
        scene=found.scene_text.strip(),
        version=build_info()["version"],
    )
    return write_text(text, path)


def remark(found: Identification) -> str:
    """A one-line summary of the data and the estimate."""
    picture, posterior = found.picture, found.posterior
    used = len(picture.observed) - picture.lead
    missing = np.isnan(picture.observed[picture.lead :]).mean()
    parts = [
        picture.kind,
        f"{used} frames from {picture.first} at {picture.frame_rate:g} a second",
        f"{len(picture.start)} points, {picture.spacing:.3g} px apart",
    ]
    if picture.correlation is not None:
        parts.append(f"the flow's error is correlated over {picture.correlation:.3g} px")
    parts += [
        f"{100 * missing:.0f} % missing",
        f"{int(picture.closed.sum())} frames closed",
        f"flow error {posterior.noise.flow:.2g} times as stated ({np.median(picture.sd):.2g} px)",
        *([f"sd of the points' gains {posterior.noise.gain:.2g}"] if posterior.noise.gain else []),
        f"sd of the unknown pressures {posterior.noise.pressure:.3g} Pa",
        f"{posterior.iterations} iterations",
        *([wording.started(posterior)] if posterior.starts > 1 else []),
    ]
    return "; ".join(parts) + "."


def rows(found: Identification) -> list[Row]:
    """One line per parameter; an sd that is smaller than the mesh shift is refused."""
    posterior = found.posterior
    interval, priors = posterior.interval(), posterior.prior_interval()
    made = []
    for j, name in enumerate(posterior.names):
        relative = posterior.logarithmic is None or bool(posterior.logarithmic[j])
        sd = f"{100 * posterior.sd[j]:.1f} %" if relative else number(float(posterior.sd[j]), 2)
        if not found.picture.carried:
            verdict = "not supported by the data: the model does not follow the motion"
        elif posterior.fed_back:
            verdict = "of unknown error: the motion generates its own pressures"
        elif close_to_prior(posterior)[j]:
            verdict = "hardly informed by the data: close to the prior"
        elif posterior.belied[j]:
            verdict = "the shift between meshes exceeds its sd"
        elif posterior.outside_prior[j]:
            verdict = "outside the prior interval"
        else:
            informed = "informed by the data"
            verdict = informed if posterior.residuals.passed else f"{informed}, but the residual test failed"
        made.append(
            Row(
                name,
                posterior.units[j],
                number(float(posterior.median[j]), 3),
                "refused" if posterior.refused[j] else sd,
                " – ".join(number(float(v), 3) for v in interval[j]) if posterior.answered else "refused",
                " – ".join(number(float(v), 3) for v in priors[j]),
                verdict,
            )
        )
    return made


def _identifiable(posterior: Posterior) -> str:
    values = posterior.information_eigenvalues
    weak = int((values < 1).sum())
    count = "every combination" if not weak else f"{len(values) - weak} of {len(values)} combinations"
    return (
        f"The recording is more informative than the prior on {count} of the parameters. It is least "
        f"informative on {wording.weakest(posterior)}: {number(float(values[0]), 2)} times the prior's "
        "information."
    )


def _residuals(posterior: Posterior) -> str:
    test = posterior.residuals
    scores = {"in time": test.in_time, "in space": test.in_space, "tails": test.tails, "level": test.level}
    shown = ", ".join(f"{name} {score:+.1f}" for name, score in scores.items())
    verdict = "passed" if test.passed else "failed"
    return (
        f"Residual test {verdict}: scores {shown} of {test.count} residuals; each is within 3.3 if the model "
        f"and the stated errors hold.{_widened(posterior)}"
    )


def _widened(posterior: Posterior) -> str:
    return "" if posterior.inflation is None else f" Intervals are {wording.widened(posterior)}."
