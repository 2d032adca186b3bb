"""What each repair of the thesis's text is worth: parameter sets between literal and default.

The groups of ``Params`` that differ between ``Params.literal()`` and ``Params()`` are switched
to default one after another, and each switched back alone. A group not named in ``ORDER``
becomes a rung of its own at the end, so that none is forgotten.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, replace

from agents.cogmap.params import Params

ORDER = (
    ("lines",),
    ("gaps", "exits"),
    ("exploration",),
    ("passages",),
    ("landmarks", "frame"),
    ("transfer",),
    ("boundary",),
    ("association",),
    ("journeys",),
)
"""The groups, in the order in which they are added: first what it takes to see and to get
round at all, without which nothing else can show."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A parameter set of the ablation."""

    name: str
    """What it is, in words."""
    params: Params

    @property
    def key(self) -> str:
        """The same for the same parameters alone."""
        return hashlib.sha256(repr(self.params).encode()).hexdigest()[:12]


def changed_groups() -> tuple[tuple[str, ...], ...]:
    """The groups in which literal and default differ, in the order of the rungs."""
    literal, default = Params.literal(), Params()
    names = [field.name for field in fields(Params)]
    differ = {name for name in names if getattr(literal, name) != getattr(default, name)}
    named = {name for rung in ORDER for name in rung}
    rungs = [tuple(name for name in rung if name in differ) for rung in ORDER]
    rungs += [(name,) for name in names if name in differ - named]
    return tuple(rung for rung in rungs if rung)


def ladder() -> tuple[Variant, ...]:
    """From the text as written to the default, a rung at a time."""
    params, default = Params.literal(), Params()
    out = [Variant("the text as written", params)]
    for rung in changed_groups():
        params = replace(params, **{name: getattr(default, name) for name in rung})
        out.append(Variant(f"+ {' and '.join(rung)}", params))
    assert params == default, "the last rung is the default"
    return (*out[:-1], Variant(f"{out[-1].name} = default", params))


def left_out() -> tuple[Variant, ...]:
    """The default, and the default with the groups of one rung as written."""
    literal, default = Params.literal(), Params()
    return (
        Variant("default", default),
        *(
            Variant(
                f"without {' and '.join(rung)}",
                replace(default, **{name: getattr(literal, name) for name in rung}),
            )
            for rung in changed_groups()
        ),
    )
