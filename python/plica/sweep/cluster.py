"""Dask's client of a sweep: of workers on this machine, or of a scheduler that is there."""

from __future__ import annotations

import logging
import multiprocessing
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import forkserver
from typing import Any

from plica.errors import InvalidInput, StorageFailed
from plica.sweep.needed import needed

__all__ = ["KILLS", "cluster", "prepare", "require_main", "threads"]

KILLS = 20
"""Workers that may be killed while a case is in their hands: a case waits behind others of its worker, and is
blamed with them, so that few would condemn innocent ones."""
_MAIN = 'In a script put the sweep below: if __name__ == "__main__":'
_CONNECTING = "30 s"
_ENVIRONMENT = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    "MALLOC_MMAP_THRESHOLD_": f"{1 << 31}",
    "MALLOC_TRIM_THRESHOLD_": f"{1 << 32}",
    "MALLOC_TOP_PAD_": f"{1 << 27}",
}
"""Of workers. They keep the memory (bytes) of a case for the next one, which is as long: to get it anew, page
by page, takes a tenth of the time of a reduced voice."""
_IMPORTED = ["distributed.nanny", "plica.sweep.case", "scipy.ndimage", "scipy.special"]
"""What every worker needs, imported once. None of these starts a thread, which a fork would lose."""

_RARELY = {
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "1s",
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing-interval": "1s",
    "distributed.worker.memory.monitor-interval": "10s",
    "distributed.worker.profile.enabled": False,
}
"""What Dask looks after many times a second otherwise, for 6 % of a processor with two workers that wait."""


@contextmanager
def cluster(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """A client: of `workers` processes here, default one a CPU, or of the scheduler at an address."""
    distributed, config = needed("distributed"), needed("dask.config")
    if scheduler is not None:
        with _connected(distributed, scheduler) as client:
            yield client
        return
    count = len(os.sched_getaffinity(0)) if workers is None else workers
    settings: dict[str, Any] = {
        **_RARELY,
        "distributed.nanny.pre-spawn-environ": {},  # `_ENVIRONMENT`
        "distributed.scheduler.allowed-failures": KILLS,
        "distributed.worker.multiprocessing-method": "forkserver",
        "distributed.worker.memory.terminate": False,  # the system knows better what there is
        "distributed.worker.memory.pause": False,
        "distributed.worker.memory.spill": False,
        "distributed.worker.memory.target": False,
    }
    with (
        tempfile.TemporaryDirectory(prefix="plica-sweep-") as folder,
        config.set(settings),
        _started(distributed, n_workers=count, local_directory=folder) as local,
        distributed.Client(local, set_as_default=False) as client,
    ):
        client.wait_for_workers(1)
        yield client


def prepare() -> None:
    """Start the process whose forks the workers of `cluster` are: it imports while the caller goes on."""
    forkserver.set_forkserver_preload(_IMPORTED)
    own = {name: os.environ[name] for name in _ENVIRONMENT if name in os.environ}
    os.environ.update(_ENVIRONMENT)
    try:
        forkserver.ensure_running()
    finally:
        os.environ.update(own)
        for name in _ENVIRONMENT.keys() - own.keys():
            del os.environ[name]


def require_main() -> None:
    """Raise InvalidInput in a worker that imports a script whose sweep has just started it."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # what multiprocessing asks, too
        raise InvalidInput(f"Sweep: it is begun in one of its own workers; must be in the script. {_MAIN}")


def _started(distributed: Any, **options: Any) -> Any:
    """A cluster of processes on this machine, with one thread each."""
    try:
        return distributed.LocalCluster(
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",  # any free port: two sweeps at a time are no error
            memory_limit=0,
            env=dict(os.environ),  # forks have that of the first sweep of this process
            silence_logs=logging.CRITICAL,
            **options,
        )
    except RuntimeError as error:
        raise InvalidInput(f"Sweep: no worker starts ({error}); must be able to. {_MAIN}") from None


@contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    try:
        client = distributed.Client(address, timeout=_CONNECTING, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StorageFailed(
            f"{address}: no scheduler answers ({' '.join(str(error).split())}). Start one: dask scheduler"
        ) from None
    with client:
        for name, count in client.nthreads().items():
            if count != 1:
                raise InvalidInput(
                    f"{address}: worker {name} has {count} threads; must have 1. Start workers with: dask "
                    f"worker {address} --nthreads 1 --nworkers N"
                )
        yield client


def threads(client: Any) -> int:
    """Cases that are computed at a time: workers may come and go."""
    counts: dict[str, int] = client.nthreads()
    return max(sum(counts.values()), 1)
