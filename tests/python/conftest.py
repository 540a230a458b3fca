"""Small scenes, and a recording, that the tests share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import plica
from plica.commands.main import main
from plica.report import drawing
from plica.scene.tissue_presets import TISSUE_PRESETS
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.measures import error_model

TINY_LARYNX: dict[str, Any] = {"around": 8, "levels": [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], "body_rings": 1}

THESIS_TISSUE: dict[str, dict[str, Any]] = {
    layer: {
        name: getattr(tissue, name) for name in ("E", "nu", "E_fibre", "nu_fibre", "mu_fibre", "viscosity")
    }
    for layer, tissue in TISSUE_PRESETS["thesis_corrected"].items()
}

MOVIE = Synthetic(
    height=95, width=97, frames=66, frequency=0.0813, amplitude=(5, 5), opening=(2, 2), highlights=2
)


@pytest.fixture
def bar() -> plica.Scene:
    """A bar held at one end that was given a push: no airflow, no contact, 40 steps."""
    return plica.Scene(
        plica.Block(size=("10 mm", "2 mm", "2 mm"), divisions=(4, 1, 1)),
        {"body": plica.Tissue(E="20 kPa", nu=0.3, viscosity=0.1)},
        time=plica.Stepping(step="0.1 ms", duration="4 ms"),
        supports=plica.Supports(fixed=["x_min"]),
        initial=plica.Initial(velocity={"body": (0.0, 0.0, "0.1 m/s")}),
        output=plica.Output(every="0.5 ms", probes=[("10 mm", 0.0, 0.0)], checkpoint_every="1 ms"),
    )


@pytest.fixture
def colliding() -> plica.Scene:
    """Two bars that fly at each other and touch after ten steps."""
    size, divisions = (0.010, 0.002, 0.002), (6, 1, 1)
    return plica.Scene(
        plica.Blocks(
            blocks={
                "a": plica.Block(size=size, divisions=divisions),
                "b": plica.Block(corner=(0.0101, 0.0, 0.0), size=size, divisions=divisions),
            }
        ),
        {"a": plica.Tissue(E=20e3, nu=0.0), "b": plica.Tissue(E=20e3, nu=0.0)},
        time=plica.Stepping(step=5e-5, duration=2e-3),
        contact=plica.Contact(multipliers=plica.Multipliers(), first="a.x_max", second="b.x_min"),
        initial=plica.Initial(velocity={"a": (0.1, 0.0, 0.0), "b": (-0.1, 0.0, 0.0)}),
        output=plica.Output(every=2e-4, checkpoint_every=5e-4),
    )


@pytest.fixture(scope="session")
def phonating() -> plica.Scene:
    """A very coarse larynx with airflow, of few sections, and contact; it collides within its 40 steps."""
    return plica.Scene(
        plica.Larynx(larynx="thesis_coarse", options=plica.LarynxOptions(**TINY_LARYNX)),
        {layer: plica.Tissue(**fields) for layer, fields in THESIS_TISSUE.items()},
        time=plica.Stepping(step=5e-5, duration=2e-3),
        airflow=plica.Airflow(subglottal_pressure="0.8 kPa", area=plica.Cut(sections=40)),
        contact=plica.Multipliers(),
        initial=plica.Initial(opening_velocity=-1.2),
        output=plica.Output(every=2e-4, checkpoint_every=5e-4),
    )


@pytest.fixture(scope="session")
def movie(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a synthetic glottis, 66 frames of 95 x 97 px with highlights."""
    path = tmp_path_factory.mktemp("movie") / "glottis.npy"
    np.save(path, SyntheticGlottis(MOVIE).stack())
    return path


@pytest.fixture(scope="session")
def done(movie: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `plica video` makes of it; tests that change it take a copy."""
    where = tmp_path_factory.mktemp("done")
    arguments = ["video", str(movie), "--fps", "4000", "--mm-per-px", "0.05", "--preset", "fast", "--quiet"]
    assert main([*arguments, "-o", str(where)]) == 0
    return where


@pytest.fixture
def few_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Intervals of a recording are of four drawn voices, not of a hundred, which take as long as its
    analysis: for tests that look at none of them."""
    monkeypatch.setattr(error_model, "_DRAWS", 4)


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures of a page are painted, but neither laid out nor written: for tests that look at none."""
    monkeypatch.setattr(drawing, "_laid_out", lambda figure: None)
    monkeypatch.setattr(Figure, "savefig", lambda figure, file, **options: file.write("<svg></svg>"))
