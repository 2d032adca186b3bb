"""Rows that threads share out among themselves."""

from __future__ import annotations

import threading

import numba
import numpy as np
from numpy.typing import NDArray

from cogmap_gym.kernel_parts import whole
from cogmap_gym.shared_count import all_finished, finish, new_count, take


@whole
def add_one_to_each(count: NDArray[np.int64], values: NDArray[np.int64]) -> None:
    """What the threads do here."""
    taken = 0
    for taken in range(len(values) + 1):  # noqa: B007
        row = take(count)
        if row >= len(values):
            break
        values[row] += 1
    finish(count, taken)


def test_every_row_is_taken_once_by_any_number_of_threads() -> None:
    rows = 1000 if numba.config.DISABLE_JIT else 200_000
    for threads in (1, 2, 5):
        count, values = new_count(), np.zeros(rows, dtype=np.int64)
        workers = [
            threading.Thread(target=add_one_to_each, args=(count, values)) for _ in range(threads)
        ]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        assert (values == 1).all()
        assert all_finished(count, rows)


def test_rows_that_were_only_taken_are_not_finished() -> None:
    count = new_count()
    assert not all_finished(count, 1)
    assert [take(count), take(count)] == [0, 1]
    finish(count, 1)
    assert all_finished(count, 1)
    assert not all_finished(count, 2)
