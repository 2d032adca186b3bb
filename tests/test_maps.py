"""The packaged maps: the thesis's office has the topology, size and clearances it needs."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
import shapely
from shapely import affinity
from shapely.geometry import LineString, MultiLineString, MultiPoint, Point, Polygon

from cogmap_gym import plan_file
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import lengths, midpoints

TOPOLOGY = {
    "ASR1": {"E6", "E1"},
    "ASR2": {"E1", "E2", "E9"},
    "ASR3": {"E2", "E3", "E8"},
    "ASR4": {"E3", "E4"},
    "ASR5": {"E4", "E5", "E7"},
    "ASR6": {"E5", "E6", "E10"},
    "ASR7": {"E7", "E8"},
    "ASR8": {"E9", "E10"},
}
RING = ("E1", "E2", "E3", "E4", "E5", "E6")
CHORDS = ("E7", "E8", "E9", "E10")
RADIUS = 0.25


@cache
def office() -> FloorPlan:
    return FloorPlan.load("thesis_office")


@cache
def middle(door: str) -> Point:
    return Point(office().doors[door].mean(axis=0))


@cache
def doors_of(room: str) -> frozenset[str]:
    polygon = Polygon(office().rooms[room])
    return frozenset(n for n, d in office().doors.items() if polygon.distance(LineString(d)) < 1e-6)


def opened(radius: float) -> shapely.Geometry:
    """What a disc of ``radius`` sweeps in the free space."""
    return office().free_space().buffer(-radius).buffer(radius)


@cache
def routes() -> nx.Graph:
    """Doors and home, joined within a room by the shortest way of the robot's middle [m]."""
    graph = nx.Graph()
    for room in office().rooms:
        stops = {name: middle(name) for name in doors_of(room)}
        if room == "ASR1":
            stops["home"] = Point(office().home.position)
        for a, b, length in _ways(room, stops):
            graph.add_edge(a, b, weight=length, room=room)
    return graph


def _ways(room: str, stops: dict[str, Point]) -> list[tuple[str, str, float]]:
    space = Polygon(office().rooms[room]).buffer(0.5, cap_style="square")
    space = space.intersection(office().free_space()).buffer(-RADIUS, join_style="mitre")
    points = np.concatenate(([p.coords[0] for p in stops.values()], shapely.get_coordinates(space)))
    a, b = np.triu_indices(len(points), 1)
    lines = shapely.linestrings(np.stack((points[a], points[b]), axis=1))
    roomy = space.buffer(1e-6)
    shapely.prepare(roomy)
    seen = shapely.covers(roomy, lines)
    graph = nx.Graph()
    graph.add_weighted_edges_from(
        zip(a[seen].tolist(), b[seen].tolist(), shapely.length(lines)[seen].tolist(), strict=True)
    )
    names = list(stops)
    return [
        (names[i], names[j], nx.dijkstra_path_length(graph, i, j))
        for i in range(len(names))
        for j in range(i)
    ]


def way(*stops: str) -> float:
    return sum(routes().edges[pair]["weight"] for pair in pairwise(stops))


@pytest.mark.parametrize("name", plan_file.map_names())
def test_no_beam_leaves_the_building(name: str) -> None:
    plan = FloorPlan.load(name)
    walls = MultiLineString(list(plan.walls_and_furniture())).union(
        MultiLineString(list(plan.door_segments()))
    )
    assert plan.free_space().boundary.difference(walls.buffer(1e-9)).length == 0.0
    outline = MultiLineString(list(plan.wall_segments()))
    angles = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False) + 1e-4
    for room in plan.rooms:
        start = np.array(plan.room_free_space(room).representative_point().coords[0])
        ends = start + 60.0 * np.stack((np.cos(angles), np.sin(angles)), axis=1)
        rays = shapely.linestrings(np.stack((np.broadcast_to(start, ends.shape), ends), axis=1))
        assert shapely.intersects(outline, rays).all()


@pytest.mark.parametrize("name", plan_file.map_names())
def test_rooms_fill_the_free_space_without_overlap_and_meet_at_doors(name: str) -> None:
    plan = FloorPlan.load(name)
    spaces = [plan.room_free_space(room) for room in plan.rooms]
    assert sum(space.area for space in spaces) == pytest.approx(plan.area)
    assert shapely.union_all(spaces).area == pytest.approx(plan.area)
    for ends in plan.doors.values():
        meeting = [
            p for p in plan.rooms.values() if Polygon(p).buffer(1e-6).covers(LineString(ends))
        ]
        assert len(meeting) == 2


def test_each_room_of_the_office_has_the_doors_of_the_thesis() -> None:
    assert {room: doors_of(room) for room in office().rooms} == TOPOLOGY
    assert office().closed == CHORDS
    assert office().door_names == (*RING, *CHORDS)


def test_the_ring_runs_clockwise_and_is_at_least_80_m_long() -> None:
    ring = Polygon([middle(name) for name in RING])
    assert not ring.exterior.is_ccw
    assert way(*RING, RING[0]) >= 80.0


def test_the_office_has_the_size_and_the_wealth_of_the_thesis() -> None:
    x0, y0, x1, y1 = office().bounds
    assert x1 - x0 == pytest.approx(30.0, abs=0.6)
    assert y1 - y0 == pytest.approx(30.0, abs=0.6)
    assert len(office().furniture) >= 10
    assert len(office().wall_segments()) >= 60
    assert lengths(office().wall_segments()).min() >= 0.1


def test_the_walls_are_drawn_with_free_space_on_their_left() -> None:
    walls = office().wall_segments()
    along = (walls[:, 1] - walls[:, 0]) / lengths(walls)[:, None]
    beside = midpoints(walls) + 0.01 * np.stack((-along[:, 1], along[:, 0]), axis=1)
    bare = office().free_space().union(shapely.union_all([Polygon(p) for p in office().furniture]))
    assert shapely.contains_xy(bare, beside).all()


def test_home_is_well_inside_the_first_room() -> None:
    home = Point(office().home.position)
    assert office().room_at(home.x, home.y) == "ASR1"
    assert home.distance(office().free_space().boundary) > 1.5
    assert home.distance(Polygon(office().rooms["ASR1"]).centroid) < 1.5


def test_doorways_are_0_8_to_1_0_m_wide_with_jambs() -> None:
    walls = MultiLineString(list(office().wall_segments())).buffer(1e-6)
    for name, (a, b) in office().doors.items():
        assert 0.8 <= np.hypot(*(b - a)) <= 1.0
        through = 0.2 * np.array((-(b - a)[1], (b - a)[0])) / np.hypot(*(b - a))
        sides = (-0.5, 0.5) if name in RING else (-1.0, 1.0)
        jambs = [LineString((end, end + s * through)) for end in (a, b) for s in sides]
        held = [walls.covers(jamb) for jamb in jambs]
        assert sum(held) == (4 if name in RING else 2)


@pytest.mark.parametrize("radius", [0.30, 0.35, 0.39])
def test_a_disc_with_a_margin_passes_every_door(radius: float) -> None:
    roomy = office().free_space().buffer(-radius)
    assert roomy.geom_type == "Polygon"
    assert roomy.buffer(1e-6).covers(MultiPoint([middle(name) for name in office().doors]))


def test_no_passage_is_neither_wide_nor_shut() -> None:
    tight, roomy = (office().free_space().buffer(-radius) for radius in (0.25, 0.39))
    assert len(tight.interiors) == len(roomy.interiors)
    lost = shapely.get_parts(opened(0.25).difference(opened(0.39)))
    assert shapely.area(lost).max() < 0.05


def test_furniture_keeps_1_2_m_from_doors() -> None:
    doorways = [LineString(ends) for ends in office().doors.values()]
    for piece in map(Polygon, office().furniture):
        assert min(piece.distance(doorway) for doorway in doorways) >= 1.2


@pytest.mark.parametrize("name", CHORDS)
def test_a_shut_chord_is_one_plane_with_the_wall_of_the_ring(name: str) -> None:
    room = next(r for r in list(TOPOLOGY)[:6] if name in TOPOLOGY[r])
    outline = Polygon(office().rooms[room]).exterior.simplify(0.0)
    face = next(s for s in map(LineString, pairwise(outline.coords)) if s.covers(middle(name)))
    assert face.buffer(1e-9).covers(LineString(office().doors[name]))
    assert face.boundary.distance(LineString(office().doors[name])) > 0.5


def test_the_two_corridors_are_alike_after_half_a_turn() -> None:
    north = office().room_free_space("ASR2")
    south = affinity.rotate(office().room_free_space("ASR5"), 180.0, origin=(15.0, 15.0))
    assert north.symmetric_difference(south).area < 1e-6
    assert affinity.scale(north, -1.0, 1.0).symmetric_difference(north).area > 0.3


def test_the_other_rooms_differ_in_area() -> None:
    areas = sorted(office().room_free_space(f"ASR{k}").area for k in (1, 3, 4, 6, 7, 8))
    assert np.diff(areas).min() > 1.0


def test_the_barrier_parts_e4_from_the_rest_of_its_room() -> None:
    barrier = LineString(office().barriers["B5"]).buffer(1e-3)
    left = office().room_free_space("ASR5").difference(barrier).buffer(-RADIUS)
    for ends in office().doors.values():
        assert barrier.distance(LineString(ends)) > 0.1
    parts = shapely.get_parts(left)
    hall = max(parts, key=lambda part: part.area)
    assert hall.distance(middle("E4")) > RADIUS
    assert all(hall.distance(middle(name)) < RADIUS + 0.01 for name in ("E5", "E7"))
    assert hall.area > 0.9 * office().room_free_space("ASR5").buffer(-RADIUS).area


def test_the_detours_of_experiment_3_are_the_shorter_ones() -> None:
    assert way("E5", "E7", "E8") < way("E5", "E6", "E1", "E2")
    assert way("E2", "E9", "E10", "E6", "home") + 5.0 < way("E2", "E3", "E4", "E5", "E6", "home")
    to_asr2 = way("home", "E6", "E10", "E9")
    assert to_asr2 < way("home", "E6", "E5", "E4", "E3", "E2")
    assert way("home", "E6", "E5") < way("home", "E1", "E2", "E3", "E4")


def test_the_familiar_ways_of_experiment_3_are_the_shortest_until_they_are_blocked() -> None:
    assert way("E5", "E4", "E3") < way("E5", "E6", "E1", "E2")
    assert way("E2", "E1", "home") < way("E2", "E9", "E10", "E6", "home")


def test_most_of_each_room_is_in_sight_from_its_middle() -> None:
    for room in office().rooms:
        space = office().room_free_space(room)
        walls = office().room_free_space(room).buffer(1e-6)
        grid = np.stack(np.meshgrid(*(np.arange(0.3, 30.0, 0.6),) * 2), axis=-1).reshape(-1, 2)
        inside = grid[shapely.contains_xy(space, grid)]
        shapely.prepare(walls)
        views = inside[:: max(1, len(inside) // 12)]
        lines = np.stack(np.broadcast_arrays(views[:, None], inside[None]), axis=2)
        seen = shapely.covers(walls, shapely.linestrings(lines)).mean(axis=1)
        assert seen.max() > 0.7
