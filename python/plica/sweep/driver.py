"""The driver of a sweep: submits cases in a window, and is the only one that writes."""

from __future__ import annotations

import itertools
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from plica.errors import InvalidInput, StorageFailed
from plica.storage.files import only_writer, storage_errors
from plica.storage.stopping import StopRequest, stop_on_signal
from plica.sweep.case import CaseResult, Task, run_case
from plica.sweep.cluster import KILLS, cluster, prepare, require_main, threads
from plica.sweep.needed import needed
from plica.sweep.plan import Plan
from plica.sweep.results import Sweep
from plica.sweep.store import STATUSES, Store, holds_sweep

__all__ = ["run"]

_WINDOW = 3
"""Cases in the hands of the scheduler, a worker: none of them waits for the driver, and none is far ahead."""
_LOOK = 0.5
"""[s] Between two looks at a request to stop."""
_LIBRARIES = ("distributed", "zarr", "h5netcdf", "xarray", "dask.array")
"""Of the driver, the last for xarray's first data set: imported while the workers' server imports its own."""
_LOST = "Repeat the same command to continue"


def run(
    plan: Plan,
    directory: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    first: int | None = None,
    retry: bool = False,
    progress: bool = True,
) -> Sweep:
    """Compute the cases of a plan, or those that have not ended yet, and store them in `directory`.

    Parameters
    ----------
    plan : Plan
    directory : path
        Created if missing. One that holds a sweep of this plan is continued.
    workers : int, optional
        Processes on this machine, each with one thread; default: the available CPUs.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers compute instead.
    first : int, optional
        Only so many cases of the plan's beginning.
    retry : bool
        Compute again cases that have failed, as for want of memory.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    Sweep

    Raises
    ------
    InvalidInput
        The directory holds a sweep of another plan, or another process writes there.
    StorageFailed
        What is stored cannot be written, or the scheduler is gone.
    KeyboardInterrupt
        Stopped by Ctrl-C or SIGTERM; cases that have ended are stored.
    """
    directory = Path(directory)
    require_main()
    if workers is not None and workers < 1:
        raise InvalidInput(f"sweep: workers = {workers}; must be >= 1.")
    if workers is not None and scheduler is not None:
        raise InvalidInput(f"sweep: workers = {workers} with a scheduler; must be left out: it has its own.")
    if first is not None and not 1 <= first <= len(plan):
        raise InvalidInput(f"sweep: first = {first}; must be from 1 to the {len(plan)} cases of the plan.")
    _require_free(directory)
    if scheduler is None:
        prepare()
    for name in _LIBRARIES:
        needed(name)
    _ = plan.record  # whose files must be there, before anything is made
    if scheduler is not None and not holds_sweep(directory):
        with cluster(None, scheduler):  # it answers, before anything is made
            pass
    with storage_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
    with only_writer(directory):
        store = Store(directory, plan)
        if retry:
            store.retry()
        waiting = list(store.waiting(first))
        if waiting:
            with stop_on_signal() as stop, cluster(workers, scheduler) as client:
                _Driver(store, client, stop, shown=progress).run(iter(waiting))
            if stop.signal is not None:
                ended = int((store.statuses != 0).sum())
                raise KeyboardInterrupt(f"stopped after {ended} of {len(plan)} cases")
        found = Sweep.load(directory)
        found.write()
    return found


def _require_free(directory: Path) -> None:
    """Raise InvalidInput for a directory with something else in it."""
    if directory.exists() and not directory.is_dir():
        raise InvalidInput(f"{directory}: a file; must be a directory.")
    if not directory.exists() or holds_sweep(directory):
        return
    with storage_errors(directory, "read"):
        others = [path.name for path in directory.iterdir()]
    begun = {"scene.toml", "sources.csv", "plan.json"}
    known = {".lock", "pending", "results.zarr", *begun, *(f"{name}.part" for name in begun)}
    if foreign := sorted(set(others) - known):
        raise InvalidInput(
            f"{directory}: holds {foreign[0]}, and no sweep; must be new or empty. Use another directory."
        )


class _Driver:
    """One sweep being computed."""

    def __init__(self, store: Store, client: Any, stop: StopRequest, *, shown: bool) -> None:
        self.store, self.client, self.stop = store, client, stop
        self.distributed = needed("distributed")
        self.cases: dict[Any, int] = {}  # by future
        self.session = uuid.uuid4().hex  # a scheduler may still remember keys of another one
        self.bar = _Bar(store, shown=shown)

    def run(self, waiting: Iterator[int]) -> None:
        try:
            with self.client.as_current():
                while self.stop.signal is None:
                    window = _WINDOW * threads(self.client) - len(self.cases)
                    for case in itertools.islice(waiting, max(window, 0)):
                        self._submit(case)
                    if not self.cases:
                        return
                    for future in self._ended():
                        self.store.keep(self._result(future, self.cases.pop(future)))
                        future.release()
                        self.bar.update()
        finally:
            self.bar.close()
            self.client.cancel(list(self.cases), force=True)

    def _submit(self, case: int) -> None:
        plan = self.store.plan
        folder = None
        if plan.keep == "runs":
            folder = str((self.store.directory / "runs" / f"{case:06d}").resolve())
        task = Task(
            case=case,
            digest=plan.case_digest(case),
            subject=plan.subject,
            changes=plan.changes(case),
            waveforms=plan.waveforms,
            version=str(plan.record["plica_version"]),
            folder=folder,
        )
        future = self.client.submit(run_case, task, key=f"case-{case}-{self.session}", pure=False)
        self.cases[future] = case

    def _ended(self) -> list[Any]:
        """Those that have ended, within a moment."""
        if self.client.status not in ("running", "connecting"):
            raise StorageFailed(f"{self.store.directory}: the scheduler is gone. {_LOST}.")
        try:
            found = self.distributed.wait(list(self.cases), timeout=_LOOK, return_when="FIRST_COMPLETED")
        except (TimeoutError, self.distributed.TimeoutError):
            return []
        except self.distributed.CancelledError:
            raise StorageFailed(f"{self.store.directory}: the scheduler is gone. {_LOST}.") from None
        return sorted(found.done, key=self.cases.__getitem__)

    def _result(self, future: Any, case: int) -> CaseResult:
        digest = self.store.plan.case_digest(case)
        error = future.exception() if future.status == "error" else None
        if isinstance(error, self.distributed.KilledWorker):
            message = f"{KILLS} workers that had it were killed. Is there enough memory for a case a worker?"
            return CaseResult(case, digest, "failed", message)
        if error is not None:
            return CaseResult(case, digest, "failed", f"{type(error).__name__}: {error}")
        if future.status != "finished":
            raise StorageFailed(f"{self.store.directory}: the scheduler gave up case {case}. {_LOST}.")
        result: CaseResult = future.result()
        if result.fault:
            raise InvalidInput(f"sweep: {result.fault}")
        return result


class _Bar:
    """Cases that have ended, with those refused and failed."""

    def __init__(self, store: Store, *, shown: bool) -> None:
        self.store = store
        self.bar: Any = None
        if shown:
            from tqdm import tqdm

            self.bar = tqdm(
                total=len(store.plan),
                initial=int((store.statuses != 0).sum()),
                unit=" cases",
                mininterval=0.5 if sys.stderr.isatty() else 10.0,  # in a file, a line every ten seconds
                file=sys.stderr,
            )

    def update(self) -> None:
        if self.bar is not None:
            counts = {name: int((self.store.statuses == STATUSES.index(name)).sum()) for name in STATUSES[2:]}
            self.bar.set_postfix({name: count for name, count in counts.items() if count}, refresh=False)
            self.bar.update(1)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
