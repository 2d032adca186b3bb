"""Kernels that are parts of a larger one in another file.

numba's cache on disk notices a change of the file of a kernel, not of what it calls. A part is
therefore never cached by itself, and the kernel that is made of parts is made within a function
that is told the ``fingerprint`` of their sources: numba keys its cache with what a kernel
closes over, too.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

import numba
import numpy as np

_F = TypeVar("_F", bound=Callable[..., Any])


def part(function: _F) -> _F:
    """Compile a kernel for use by other kernels; see ``raycast_kernel.compiled``."""
    jit: Any = numba
    if jit.config.DISABLE_JIT:
        return np.errstate(all="ignore")(function)
    kernel: _F = jit.njit(error_model="numpy")(function)
    return kernel


def whole(function: _F) -> _F:
    """Compile a kernel that is made of parts and closes over their fingerprint.

    It lets other threads run meanwhile.
    """
    jit: Any = numba
    if jit.config.DISABLE_JIT:
        return np.errstate(all="ignore")(function)
    kernel: _F = jit.njit(cache=True, error_model="numpy", nogil=True)(function)
    return kernel


def fingerprint(*modules: ModuleType) -> int:
    """A number that changes with the source of any of the modules."""
    digest = hashlib.sha256()
    for module in modules:
        assert module.__file__ is not None, "a kernel's module is a file"
        digest.update(Path(module.__file__).read_bytes())
    return int.from_bytes(digest.digest()[:6], "little")
