"""Gaussian noise on ranges, drawn in compiled code.

Handing a NumPy generator to compiled code costs more than a whole scan does, so a scan's
noise is a SplitMix64 stream of its own, keyed by one draw from the generator, shaped by the
ziggurat of Marsaglia and Tsang (2000) with 256 layers.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array
from cogmap_gym.raycast_kernel import compiled

LAYERS: Final = 256
"""Layers of the ziggurat. Marsaglia and Tsang 2000."""
TAIL: Final = 3.6541528853610088
"""Where the lowest layer's tail begins, for 256 layers. Marsaglia and Tsang 2000."""
LAYER_AREA: Final = 0.00492867323399
"""Area of each layer under exp(-x^2 / 2). Marsaglia and Tsang 2000."""
UNIT: Final = 2.0**-53
"""From 53 random bits to [0, 1)."""

# SplitMix64 (Steele, Lea and Flood 2014): the step of its counter, and its two multipliers.
_STEP: Final = np.uint64(0x9E3779B97F4A7C15)
_MIX_1: Final = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2: Final = np.uint64(0x94D049BB133111EB)
_SHIFT_1, _SHIFT_2, _SHIFT_3 = np.uint64(30), np.uint64(27), np.uint64(31)
_LAYER_MASK, _SIGN_BIT, _MANTISSA_SHIFT = np.uint64(255), np.uint64(256), np.uint64(11)
_ONE = np.uint64(1)


def _ziggurat() -> tuple[Array, Array]:
    """Right edges of the layers, widest first, and the curve's height at each."""
    edges = np.zeros(LAYERS + 1)
    edges[0], edges[1] = LAYER_AREA / math.exp(-0.5 * TAIL**2), TAIL
    for i in range(1, LAYERS - 1):
        height = LAYER_AREA / edges[i] + math.exp(-0.5 * edges[i] ** 2)
        edges[i + 1] = math.sqrt(-2.0 * math.log(height))
    return edges, np.exp(-0.5 * edges**2)


_EDGES, _HEIGHTS = _ziggurat()


@compiled
def _mix(counter: np.uint64) -> np.uint64:
    """Random bits of a place in the stream."""
    z = (counter ^ (counter >> _SHIFT_1)) * _MIX_1
    z = (z ^ (z >> _SHIFT_2)) * _MIX_2
    return z ^ (z >> _SHIFT_3)


@compiled
def _unit(counter: np.uint64) -> float:
    """A random number in [0, 1)."""
    return float(_mix(counter) >> _MANTISSA_SHIFT) * UNIT


@compiled
def _tail(counter: np.uint64) -> float:
    """A draw beyond ``TAIL``."""
    while True:
        x = -math.log1p(-_unit(counter + _STEP)) / TAIL
        y = -math.log1p(-_unit(counter + _STEP + _STEP))
        if y + y > x * x:
            return TAIL + x
        counter = counter + _STEP + _STEP


@compiled
def _finish(bits: np.uint64) -> float:
    """The draw that begins with ``bits``, which need not lie in the core of their layer."""
    counter = bits
    while True:
        layer = bits & _LAYER_MASK
        x: float = float(bits >> _MANTISSA_SHIFT) * UNIT * _EDGES[layer]
        if x < _EDGES[layer + _ONE]:
            break
        if layer == np.uint64(0):
            x = _tail(counter)
            break
        low, high = _HEIGHTS[layer], _HEIGHTS[layer + _ONE]
        if low + _unit(counter + _STEP) * (high - low) < math.exp(-0.5 * x * x):
            break
        counter = counter + _STEP + _STEP
        bits = _mix(counter)
    return -x if bits & _SIGN_BIT else x


@compiled
def add_noise(
    ranges: Array,
    range_max: float,
    sd: float,
    key: int,
    draws: Array,
    missed: NDArray[np.bool_],
    out: NDArray[np.float32],
) -> None:
    """``noisy_ranges`` into ``out``, with scratch arrays (beams,) that the caller keeps."""
    beams = np.uint64(len(ranges))
    for i in range(beams):  # Without branches, so that it is vectorised.
        bits = _mix(np.uint64(key) + (np.uint64(i) + _ONE) * _STEP)
        layer = bits & _LAYER_MASK
        x = float(bits >> _MANTISSA_SHIFT) * UNIT * _EDGES[layer]
        missed[i] = x >= _EDGES[layer + _ONE]
        draws[i] = -x if bits & _SIGN_BIT else x
    for i in range(beams):
        if missed[i]:
            draws[i] = _finish(_mix(np.uint64(key) + (np.uint64(i) + _ONE) * _STEP))
    for i in range(beams):
        noisy = min(max(ranges[i] + sd * draws[i], 0.0), range_max)
        out[i] = noisy if ranges[i] < range_max else range_max


@compiled
def key_at(key: np.uint64, place: int) -> np.uint64:
    """The key of a place in the stream of another key."""
    return _mix(key + np.uint64(place) * _STEP)


@compiled
def normal(key: np.uint64) -> float:
    """One standard normal draw; the same key gives the same."""
    return _finish(_mix(key + _STEP))


@compiled
def noisy_ranges(ranges: Array, range_max: float, sd: float, key: int) -> NDArray[np.float32]:
    """Add Gaussian noise to the ranges that are returns.

    Args:
        ranges: (beams,), metres; ``range_max`` or more is no return and stays.
        range_max: upper bound of the result [m].
        sd: standard deviation [m].
        key: in [0, 2**63); the same key gives the same noise.

    Returns:
        (beams,) float32 within [0, range_max].
    """
    draws, missed = np.empty(len(ranges)), np.empty(len(ranges), dtype=np.bool_)
    out = np.empty(len(ranges), dtype=np.float32)
    add_noise(ranges, range_max, sd, key, draws, missed, out)
    return out
