"""Who runs the trials of a sweep: processes of this machine, or a Ray cluster."""

from __future__ import annotations

import traceback
from collections.abc import Iterator, Sequence
from typing import Any

import joblib

from agents.sweep import Trial, broken_row, run_trial
from agents.trial_row import Row

RETRIES = 3
"""A trial whose worker died is run again so often; then the robot is held to have killed it [-]."""


def run_here(trials: Sequence[Trial], workers: int) -> Iterator[Row]:
    """Rows as they come, from processes of this machine."""
    jobs = (joblib.delayed(run_trial)(trial) for trial in trials)
    pool = joblib.Parallel(workers, return_as="generator_unordered", batch_size=1)
    yield from pool(jobs)


def run_on_ray(trials: Sequence[Trial], address: str, workers: int = 2) -> Iterator[Row]:
    """Rows as they come, from the workers of a Ray cluster.

    Args:
        trials: what to run; one whose worker died is run again elsewhere, three times at most.
        address: of the cluster, as in ``ray.init``; ``local`` starts one here.
        workers: of a cluster that is started here.

    Raises:
        ModuleNotFoundError: Ray, the extra ``cluster``, is not installed.
    """
    import ray

    where = {"num_cpus": workers} if address == "local" else {"address": address}
    ray.init(**where, include_dashboard=False, log_to_driver=False)
    try:
        remote = ray.remote(max_retries=RETRIES)(run_trial)
        cpus = ray.cluster_resources().get("CPU", 1)
        room = 2 * max(int(cpus), 1)
        waiting = list(trials)[::-1]
        running: dict[Any, Trial] = {}
        while waiting or running:
            while waiting and len(running) < room:
                trial = waiting.pop()
                running[remote.remote(trial)] = trial
            done, _ = ray.wait(list(running))
            yield from (_row(ray, task, running.pop(task)) for task in done)
    finally:
        ray.shutdown()


def _row(ray: Any, task: Any, trial: Trial) -> Row:
    """What a worker brought; a broken row where none lived to bring one."""
    try:
        row: Row = ray.get(task)
    except (ray.exceptions.WorkerCrashedError, ray.exceptions.OutOfMemoryError):
        return broken_row(trial, traceback.format_exc())
    return row
