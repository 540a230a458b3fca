"""Sweeps of a small bar on a worker in this process, which is started once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import distributed
import pytest

import plica
from plica.sweep import Plan, driver, store
from sweeps import NU, E


@pytest.fixture(scope="session")
def client() -> Iterator[Any]:
    """Of a worker that is a thread."""
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0"
        ) as local,
        distributed.Client(local, set_as_default=False) as found,
    ):
        yield found


@pytest.fixture
def unsynced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody waits until all that the machine has is on disk."""
    monkeypatch.setattr(os, "sync", lambda: None)


@pytest.fixture
def here(client: Any, unsynced: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps are computed by that worker, and stored in chunks of 4 cases."""

    @contextmanager
    def cluster(workers: int | None, scheduler: str | None) -> Iterator[Any]:
        yield client

    monkeypatch.setattr(driver, "cluster", cluster)
    monkeypatch.setattr(driver, "prepare", lambda: None)
    monkeypatch.setattr(store, "CHUNK", 4)


@pytest.fixture
def plan(bar: plica.Scene) -> Plan:
    """Ten cases, of which the last two are no tissue; with a waveform."""
    return Plan.make(bar, {NU: "0.1:0.5:5", E: "10, 20 kPa"}, waveforms=["kinetic_energy"])
