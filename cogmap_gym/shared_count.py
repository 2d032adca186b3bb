"""Rows that threads share out among themselves while they work, and wait for one another."""

from __future__ import annotations

import threading
from typing import Any, Final

import numba
import numpy as np

from cogmap_gym.kernel_parts import part, whole
from cogmap_gym.raycast_kernel import Ints

TAKEN: Final = 0
"""Where a count says how many rows were taken."""
FINISHED: Final = 8
"""Where a count says how many rows are finished: on a cache line of its own."""
_SPINS: Final = 20_000
"""How often it is looked whether the others have finished [-]: some 40 us."""
_LOCK = threading.Lock()


def new_count() -> Ints:
    """A count of rows, none of which is taken."""
    return np.zeros(FINISHED + 1, dtype=np.int64)


def _locked_add(numbers: Ints, where: int, more: int) -> int:
    """The twin of ``_atomic_add`` without compilation."""
    with _LOCK:
        numbers[where] += more
        return int(numbers[where]) - more


def _atomic_add(_: Any, numbers: Any, where: Any, more: Any) -> Any:  # noqa: ARG001 - numba's
    """Add to one of the numbers, as numba's ``intrinsic`` wants it; what it was before."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, values[0])
        place = builder.gep(array.data, [values[1]])
        return builder.atomic_rmw("add", place, values[2], "seq_cst")

    integer = numbers.dtype
    return integer(numbers, integer, integer), generate


_jit: Any = numba
_add: Any = _locked_add if _jit.config.DISABLE_JIT else _jit.extending.intrinsic(_atomic_add)


@part
def take(count: Ints) -> int:
    """The next row that no thread has taken."""
    return _add(count, TAKEN, 1)  # type: ignore[no-any-return]


@part
def finish(count: Ints, rows: int) -> None:
    """So many rows more are finished."""
    _add(count, FINISHED, rows)


@whole
def all_finished(count: Ints, rows: int) -> bool:
    """Whether all rows are finished; waits a little for it."""
    spins = 0
    while spins < _SPINS and _add(count, FINISHED, 0) < rows:
        spins += 1
    return spins < _SPINS
