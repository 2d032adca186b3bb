"""The robot's belief as plain numbers, for people and pictures."""

from __future__ import annotations

from typing import Any

from agents.cogmap.memory import Memory
from agents.cogmap.mfis import FORGOTTEN
from agents.cogmap.places import links


def draw_sketch(memory: Memory) -> dict[str, Any]:
    """The sketch of the agent protocol: JSON-able, in MFIS coordinates."""
    mfis, pose = memory.mapping.mfis, memory.pose
    exits = [e for e in memory.book if e.sightings > 0 and e.left != e.right]
    return {
        "surfaces": [
            {"id": int(i), "p": s[0].tolist(), "q": s[1].tolist()}
            for i, s, a in zip(mfis.ids, mfis.surfaces, mfis.asr, strict=True)
            if a != FORGOTTEN
        ],
        "exits": [{"id": e.id, "p": e.line[0].tolist(), "q": e.line[1].tolist()} for e in exits],
        "asrs": [
            {
                "id": a.id,
                "boundary": a.boundary.tolist(),
                "exits": [e.id for e in exits if a.id in (e.left, e.right)],
            }
            for a in memory.network.asrs
        ],
        "links": [list(link) for link in links(memory.book)],
        "here": memory.stay.place,
        "pose": [pose.x, pose.y, pose.theta],
        "home": next((m.point.tolist() for m in memory.marks if m.id == 1), None),
        "marks": [{"id": m.id, "asr": m.place, "point": m.point.tolist()} for m in memory.marks],
        "route": None if memory.route is None else list(memory.route),
        "status": memory.status,
    }
