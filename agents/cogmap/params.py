"""Every number the thesis robot uses: one frozen dataclass for each algorithm.

Each field's docstring ends with its unit and its source: ``[m]. Thesis 3.3.`` or
``[m]. Ours: reason, measured effect.``
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True, slots=True)
class Lines:
    """Surfaces of a scan (thesis 3.2)."""

    cluster_jump: float = 1.2
    """Neighbouring points farther apart begin a new cluster, as written [m]. Thesis 3.2."""
    grazing_jump: float = 0.3
    """The same where the wall is seen squarely [m]. Ours: 1.2 m bridges furniture and wall."""
    grazing_angle: float = 0.07
    """A wall may be seen as flatly as this without breaking [rad]. Ours: FINDINGS 1, corridors."""
    max_missing: int = 3
    """Beams without evidence that a cluster may bridge [1]. Ours: single broken beams."""
    split_distance: float = 0.08
    """Largest deviation of a point from its line [m]. Ours: FINDINGS 1, 97 % of walls found."""
    slope_tolerance: float = 0.35
    """Largest change of slope on one line, as written [rad]. Ours: thesis 3.2 gives none."""
    min_hits: int = 4
    """Fewest beams on a surface [1]. Ours: phantoms behind edges 1 -> 0.05 a view."""
    min_length: float = 0.15
    """Shortest surface of a view; door jambs count for gaps [m]. Ours: FINDINGS 1."""
    min_range: float = 0.02
    """Readings below are no evidence [m]. Ours: broken beams read zero."""
    end_depth: float = 0.12
    """A beam this much deeper than a surface passes its end [m]. Ours: 10 noise sds."""
    literal: bool = False
    """Cluster by 1.2 m and group by slope as written [1]. Thesis 3.2."""


@dataclass(frozen=True, slots=True)
class Landmarks:
    """Algorithm 4: finding landmarks in view (thesis 3.4)."""

    literal_reach: float = 1.0
    """Half length of the imaginary lines across a surface, as written [m]. Thesis 3.4."""
    reach: float = 0.6
    """The same for directed surfaces [m]. Ours: serves as well as 1.0 m (FINDINGS 3)."""
    interval: float = 0.5
    """From one imaginary line to the next [m]. Thesis 3.4."""
    strong_hits: int = 5
    """More lines than this that meet are strong evidence [1]. Thesis 3.4."""
    similar_turn: float = 0.1745
    """Surfaces of similar orientation differ by at most this, 10 degrees [rad]. Thesis 3.4."""
    max_turn: float = 0.2618
    """The same on strong evidence, 15 degrees [rad]. Ours: FINDINGS 3, wrong matches 17 % -> 0."""
    literal: bool = False
    """Undirected surfaces, no limit of turn on strong evidence [1]. Thesis 3.4."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Where a view lies in the MFIS, from its landmarks (thesis 3.4; FINDINGS 3 and 8)."""

    kind: str = "consensus"
    """"nearest" landmark, "consensus" of all, "odometry" alone [1]. Ours: 1.24 -> 0.09 m."""
    recent: int = 8
    """Landmarks are looked for first among surfaces seen in as many views [1]. Ours: FINDINGS 8."""
    offset_gates: tuple[float, ...] = (0.6, 0.35, 0.15)
    """Largest distance of a landmark from its surface, round by round [m]. Ours: FINDINGS 8."""
    softness: float = 0.3
    """Share of the gate added to the sds in all rounds but the last [1]. Ours: local minima."""
    turn_gates: tuple[float, ...] = (0.26, 0.14, 0.09)
    """Largest turn of a landmark, round by round [rad]. Ours: FINDINGS 8."""
    near: float = 1.0
    """Surfaces within this of the view's bounds are compared [m]. Ours: bounds the cost."""
    range_sd: float = 0.015
    """Noise of one range [m]. Ours: SICK LMS-200, 12 mm and rounding."""
    floor_sd: float = 0.01
    """What no wall is straighter than [m]. Ours: keeps one long wall from ruling."""
    end_sd: float = 0.03
    """Noise of an end of a wall beside the beam spacing [m]. Ours: FINDINGS 3."""
    end_gate: float = 0.3
    """Ends farther apart along the wall are not one end [m]. Ours: FINDINGS 3."""
    max_spacing: float = 0.2
    """Ends seen by sparser beams do not weigh [m]. Ours: FINDINGS 8 b."""
    min_shared: float = 0.05
    """Shortest part shared by a landmark and its surface [m]. Ours: avoids division by nothing."""
    outlier: float = 2.0
    """Residuals beyond as many sds lose weight [1]. Ours: Cauchy weights."""
    iterations: int = 10
    """Gauss-Newton steps at most [1]. Ours: 3 are usual."""
    prior_distance: float = 0.05
    """Odometry's sd for each metre of a move [1]. Ours: weak, above the worst level."""
    prior_turn: float = 0.08
    """Odometry's sd for each radian of a move [1]. Ours: weak, above the worst level."""
    prior_base: tuple[float, float] = (0.02, 0.01)
    """Odometry's sd when standing, metres and radians [m, rad]. Ours: weak."""
    max_disagreement: float = 10.0
    """The prior's sd grows at most so many times [1]. Ours: FINDINGS 8 d."""
    forgetting: float = 0.7
    """What is left of the disagreement after a step [1]. Ours: FINDINGS 8 d."""
    beam_match: float = 0.12
    """A beam this near a surface ends on it [m]. Ours: FINDINGS 8."""
    search_below: float = 0.45
    """Share of matched beams below which headings are searched [1]. Ours: FINDINGS 8 c."""
    search_range: float = 0.7
    """How far headings are searched to both sides [rad]. Ours: at 90 deg rooms look alike."""
    search_step: float = 0.035
    """From one heading searched to the next [rad]. Ours: 2 degrees."""
    search_caution: float = 0.4
    """More gain asked for each radian of turn [1/rad]. Ours: rooms look alike when turned."""
    search_gain: float = 0.2
    """Gain of matched beams that makes a heading clear [1]. Ours: FINDINGS 8 c."""
    keep_odometry_below: float = 0.35
    """Share of matched beams below which no jump is believed [1]. Ours: FINDINGS 8 d."""
    odometry_jump: tuple[float, float] = (0.2, 0.1)
    """What counts as a jump then, metres and radians [m, rad]. Ours: three sds of a move."""
    max_jump: float = 0.8
    """Largest jump from the odometry's prediction [m]. Ours: FINDINGS 3."""


@dataclass(frozen=True, slots=True)
class Transfer:
    """Algorithm 5 and normalisation (thesis 3.4)."""

    min_length: float = 0.5
    """Smaller surfaces are ignored in the map [m]. Thesis 3.2."""
    min_hits: int = 5
    """Fewest beams on a surface that enters the map [1]. Ours: FINDINGS 8."""
    max_heading_sd: float = 0.05
    """A surface waits until its heading is known as well [rad]. Ours: its line stays for ever."""
    known_heading_sd: float = 0.0015
    """A heading known as well is good enough to enter the surface [rad]. Ours: 3 cm in 20 m."""
    range_sd: float = 0.015
    """Noise of one range [m]. Ours: SICK LMS-200."""
    min_growth: float = 0.05
    """A surface lengthens by no less [m]. Ours: noise of its end."""
    rounding: float = 1e-9
    """Less is no growth but rounding [m]. Ours: processors differ in the last bit."""
    end_growth: float = 0.3
    """The end of a wall moves only for as much [m]. Ours: FINDINGS 3, walls grow else."""
    corner_slack: float = 0.25
    """Surfaces may cross this near their ends: corners do [m]. Ours: new walls lost at corners."""
    most_forgotten: int = 1000
    """So many forgotten surfaces may stay in the table [1]. Ours: bounds memory and cost."""
    literal: bool = False
    """Intersect test first and without slack, unlimited growth [1]. Thesis 3.4."""


@dataclass(frozen=True, slots=True)
class Obstacles:
    """The short memory of what not to touch."""

    radius: float = 12.0
    """Points farther from the robot are forgotten [m]. Ours: beyond a local plan."""
    seen_through: float = 0.15
    """A point is gone when beams beside it end so far behind it [m]. Ours: 10 noise sds."""
    cell: float = 0.06
    """One point is kept a cell of this size [m]. Ours: half the navigator's cell."""


@dataclass(frozen=True, slots=True)
class Exits:
    """Remembered exits and crossings (thesis 3.3, 3.5)."""

    same_distance: float = 0.6
    """Exits nearer than this are one [m]. Ours: less than the narrowest exit."""
    same_turn: float = 0.6
    """And turned by a sine of at most this [1]. Ours: 37 degrees, doors are seen at a slant."""
    min_sightings: int = 2
    """An exit counts once seen in as many views [1]. Ours: false exits are seen once."""
    near: float = 4.0
    """A sighting from within this places an exit well [m]. Ours: beams 3 cm apart."""
    near_share: float = 0.5
    """Weight of a near sighting against what was known [1]. Ours: follows the local frame."""
    far_share: float = 0.1
    """Weight of a far sighting against what was known [1]. Ours: far ones are 0.1 m off."""
    beyond: float = 0.35
    """A crossing is complete so far beyond the line [m]. Ours: FINDINGS 2, 144 of 144 noticed."""
    squarely: float = 1.0
    """Squarely before an exit, this near, a robot sees on which side it is [m]. Ours: no wall."""
    doorway: float = 0.45
    """Between the jambs and nearer to the line, it stands in the exit [m]. Ours: body and wall."""
    flank: float = 0.2
    """Wall beside an exit that no way round it leads through [m]. Ours: jambs are seen late."""
    aside: float = 0.8
    """That way begins and ends so far beside the exit [m]. Ours: clear of its jambs."""
    wide: float = 0.36
    """A disc of this radius passes along it [m]. Ours: narrow doors stop it, tables do not."""
    thing: float = 0.45
    """It leads round a thing at least as deep, not a wall [m]. Ours: walls 0.1 to 0.3 m."""
    thing_free: float = 0.3
    """Largest share of a thing that was seen to be free [1]. Ours: cells at its edges."""
    largest_thing: float = 3.0
    """And at most as deep, not a room [m]. Ours: a table and its chairs."""
    way_round: float = 9.0
    """An exit parts two spaces unless a way about as short leads round it [m]. Ours: a table."""
    seen_share: float = 0.95
    """Share of that way that must have been seen to be free [1]. Ours: the unseen may be wall."""
    slack: float = 0.2
    """A path this much beside an exit's end still crosses it [m]. Ours: jambs are seen late."""


@dataclass(frozen=True, slots=True)
class Passages:
    """Doorways noticed by having gone through them."""

    stretch: float = 3.5
    """How much of the path is looked back at [m]. Ours: a move and a wall's thickness."""
    path_kept: int = 5000
    """Poses of the whole path that are remembered, for pictures [1]. Ours: bounded memory."""
    spacing: float = 0.1
    """From one spot on it to the next [m]. Ours: half a wall's thickness."""
    band: float = 0.12
    """Points so far before or behind a spot lie beside it [m]. Ours: half a wall's thickness."""
    far: float = 1.8
    """Points farther from the path do not matter [m]. Ours: a doorway and its walls."""
    min_width: float = 0.5
    """Narrowest passage [m]. Ours: the robot went through."""
    max_width: float = 1.3
    """Widest passage [m]. Ours: 1.2 m (thesis 3.3) and noise."""
    wide: float = 1.6
    """The space before and behind is wider [m]. Ours: corridors are 2 m wide."""
    wider: float = 0.4
    """Or wider than the passage by this [m]. Ours: two frames; necks narrow to 1.4 m."""
    wide_within: float = 0.7
    """And is so within this of the passage [m]. Ours: a wall's thickness and a band."""
    wall: float = 1.0
    """A wall goes on so far beyond both jambs [m]. Ours: more than a pillar and a cupboard."""
    wall_share: float = 0.7
    """Share of that which must be seen [1]. Ours: sparse beams."""
    wall_band: float = 0.2
    """Points so far beside its line are on the wall [m]. Ours: both faces of a wall."""
    wall_slant: float = 0.15
    """How that grows with the distance from the jamb [1]. Ours: walls wave a little."""
    nib: float = 0.2
    """The shortest wall beside a doorway that ends in a wall across it [m]. Ours: a frame."""
    max_slant: float = 0.3
    """A doorway's wall is turned by as much against the path at most [rad]. Ours: 17 degrees."""
    slant_step: float = 0.15
    """From one turn that is tried to the next [rad]. Ours: 0.15 m at the wall's end."""
    literal: bool = False
    """Never look back [1]. Thesis 3.3 knows exits from views alone."""


@dataclass(frozen=True, slots=True)
class Association:
    """Recognising a known place on re-entry (thesis 4.2.2; FINDINGS 5)."""

    views: int = 5
    """Views whose beams are judged together [1]. Ours: FINDINGS 5."""
    first_view: int = 2
    """The first view after a crossing at which a place is tried [1]. Ours: FINDINGS 5."""
    dense_views: int = 8
    """Until this view every view is tried, then every third [1]. Ours: FINDINGS 5."""
    later_every: int = 3
    """From one late trial to the next [1]. Ours: FINDINGS 5."""
    base_shift: float = 0.4
    """Drift allowed at once [m]. Ours: FINDINGS 5."""
    shift_per_metre: float = 0.006
    """Drift allowed for each metre since the place was left [1]. Ours: 0.3 m after 90 m, severe."""
    max_shift: float = 1.0
    """Largest drift allowed [m]. Ours: right ones to 0.75 m (severe), wrong ones from 0.86 m."""
    base_turn: float = 0.035
    """Turn allowed at once, 2 degrees [rad]. Ours: FINDINGS 5."""
    turn_per_metre: float = 0.0006
    """Turn allowed for each metre since, 0.03 degrees [rad/m]. Ours: 0.01 rad after 90 m."""
    max_turn: float = 0.14
    """Largest turn allowed, 8 degrees [rad]. Ours: twice what was seen at the severe level."""
    search_beams: int = 100
    """About as many beam ends are laid on the map in the search [1]. Ours: cost."""
    search_step: float = 0.15
    """Step of the coarse search [m]. Ours: the reach of a match."""
    search_turn: float = 0.02
    """Step of the coarse search in heading [rad]. Ours: 0.1 m at 5 m."""
    peaks: int = 6
    """Best shifts of the coarse search that are refined [1]. Ours: the true one is among them."""
    peak_distance: float = 0.4
    """Peaks are at least so far apart [m]. Ours: two matches."""
    refinements: int = 4
    """Rounds of refinement, each twice as fine [1]. Ours: ends at 1 cm."""
    field_cell: float = 0.08
    """Cell of the distance field [m]. Ours: half the reach of a match."""
    beam_match: float = 0.15
    """A beam this near a surface ends on it [m]. Ours: 10 noise sds."""
    shift_penalty: float = 0.05
    """Score lost for each metre of shift [1/m]. Ours: corridors slide freely."""
    min_coverage: float = 0.45
    """Least share of beams that end on its surfaces [1]. Ours: right 0.38 up, wrong to 0.44."""
    max_contradiction: float = 0.1
    """Largest share of beams that go through them [1]. Ours: FINDINGS 5."""
    sure_coverage: float = 0.7
    """From this share on, and near, no boundary is asked [1]. Ours: some rooms are cut badly."""
    sure_contradiction: float = 0.02
    """And up to this share of beams that go through surfaces [1]. Ours: single beams err."""
    margin: float = 0.15
    """Coverage by which the best place must lead the next [1]. Ours: FINDINGS 5."""
    min_inside: float = 0.9
    """Least share of the poses since the crossing inside the place [1]. Ours: FINDINGS 5."""
    inside_slack: float = 0.3
    """How far outside its boundary still counts as inside [m]. Ours: boundaries are rough."""
    seam_shift: float = 0.1
    """A larger shift on recognition leaves a seam in the map [m]. Ours: below the last gate."""
    seam_turn: float = 0.02
    """A larger turn on recognition leaves a seam in the map [rad]. Ours: 0.1 m at 5 m."""
    literal: bool = False
    """Any surface may be named at any time; two names make a place known [1]. Thesis 4.2.2."""
    literal_names: int = 2
    """So many surfaces named [1]. Thesis 4.2.2: landmarks 22 and 8."""
    door_distance: float = 1.0
    """The crossed exit lies this near to the place's boundary [m]. Ours: FINDINGS 5."""


@dataclass(frozen=True, slots=True)
class Union:
    """A new place that goes on into a known one (thesis 4.2.2)."""

    depth: float = 0.5
    """Space counts as a known place's so far inside its boundary [m]. Ours: drift and doors."""
    min_area: float = 1.0
    """Least area of it seen to be free from the new place [m2]. Ours: a doorway's sight is less."""
    passage: float = 1.2
    """They are one if a body so wide gets across [m]. Ours: no exit is wider (thesis 3.3)."""
    off_door: float = 0.45
    """It sets out so far from all exits [m]. Ours: clear of their jambs."""
    seen_share: float = 0.95
    """Share of its way that must have been seen to be free [1]. Ours: the unseen may be wall."""
    min_beams: int = 30
    """Beams that must end there [1]. Ours: 15 degrees of a view."""
    min_agreeing: float = 0.7
    """Least share of them that end on surfaces of the known place [1]. Ours: backs of things."""
    spots_back: int = 2
    """Steps so deep inside the place just left, without an exit crossed [1]. Ours: not one slip."""
    near_look: float = 1.0
    """So near to where it once stood in a place, it is there [m]. Ours: drift."""
    max_through: float = 0.1
    """Largest share of them that go through such surfaces [1]. Ours: as in ``Association``."""


@dataclass(frozen=True, slots=True)
class Exploration:
    """Algorithm 1 and looking round (thesis 3.3)."""

    look_turn: float = 3.1416
    """A look round turns by this much [rad]. Ours: with a view of 180 degrees it shows all."""
    standoff: float = 0.6
    """The robot lines up so far before an exit [m]. Ours: FINDINGS 2."""
    lookout: float = 1.2
    """An exit seen once is looked at from so far before it [m]. Ours: it is found best there."""
    through: float = 0.8
    """And aims so far beyond it [m]. Ours: past the 0.35 m of a crossing."""
    spot_tolerance: float = 0.1
    """How exactly the most open spot is found [m]. Ours: a quarter of an arrival."""
    inside: float = 1.4
    """A new place is looked at from so far inside at least [m]. Ours: to have been there."""
    arrival: float = 0.4
    """A target within this is reached [m]. Ours: a step's uncertainty."""
    same_target: float = 1.0
    """Targets nearer than this are one [m]. Ours: seen from one, the other hides nothing."""
    survey_reach: float = 4.0
    """Beams are cut at this length to find the middle of a space [m]. Ours: rooms of 8 m."""
    patience: int = 12
    """Steps after which a target not reached is given up [1]. Ours: three times the usual."""
    exit_patience: int = 25
    """The same for an exit across the place [1]. Ours: 13 steps cost a lap its direction."""
    shut_for: int = 200
    """Steps for which an exit found shut is no way to leads [1]. Ours: a lap is half of that."""
    max_failures: int = 2
    """An exit given up as often is left alone [1]. Ours: deadlocks."""
    literal: bool = False
    """Choose anew in each view, go straight, never look round [1]. Thesis 3.3, Algorithm 1."""


@dataclass(frozen=True, slots=True)
class Curiosity:
    """What a place still hides (thesis 3.3, gaps)."""

    visited: float = 1.2
    """A gap the robot came as near to is explored [m]. Ours: what it hid is then in view."""
    lead_width: float = 1.5
    """Narrower gaps are not come back for [m]. Ours: what furniture hides is not worth it."""
    cell: float = 0.25
    """Side of the cells by which is remembered what was seen to be free [m]. Ours: a body."""
    reach: float = 10.0
    """Beams are followed so far for that [m]. Ours: beyond, beams are 0.1 m apart."""
    edge_cost: float = 3.0
    """Extra cost of a cell beside what is not free, on a coarse way [1]. Ours: keeps off walls."""
    leg: float = 6.0
    """A local plan reaches so far along a coarse way [m]. Ours: what is remembered in detail."""
    near_free: float = 1.2
    """A coarse way ends at a free cell this near [m]. Ours: leads lie at the edge of free space."""
    behind: tuple[float, ...] = (0.35, 0.7, 1.05)
    """So far behind a gap is looked for what it hides [m]. Ours: room for a robot."""
    behind_shares: tuple[float, ...] = (0.2, 0.5, 0.8)
    """And at these shares of its width [1]. Ours: nine spots in all."""
    hidden_share: float = 0.5
    """A gap is explored once a smaller share of that is unseen [1]. Ours: nooks cost moves."""
    max_spacing: float = 0.07
    """Walls seen by beams farther apart may hide a doorway [m]. Ours: 8 m off, doors are missed."""
    piece: float = 0.75
    """Walls are judged by pieces of this length [m]. Ours: about a door."""
    beside_exit: float = 0.3
    """Sights this far beside an exit still go through it [m]. Ours: jambs and noise."""
    lit_sine: float = 0.4
    """Walls seen more flatly may hide a doorway, sine of the angle [1]. Ours: 73 deg."""
    square_sine: float = 0.5
    """A wall is seen squarely up to 60 degrees from its normal [1]. Ours: 95 % of doors found."""
    square_reach: float = 5.0
    """And from within this [m]. Ours: 95 % of doors found."""
    jamb_aside: float = 0.4
    """And with so much wall on both sides in view [m]. Ours: half a door."""
    facing: float = 0.5
    """A wall is faced up to this bearing [rad]. Ours: both jambs of a door are in view."""
    search_step: float = 1.2
    """Longest drive of a robot that looks for exits [m]. Ours: two sights of each door."""
    search_steps: int = 60
    """Steps after which the search of a place ends [1]. Ours: a corridor of 30 m and back."""
    stand: float = 0.8
    """A wall is looked at from so far before it [m]. Ours: the middle of a corridor."""


@dataclass(frozen=True, slots=True)
class Journeys:
    """Going home and to other marks (thesis 4.2.4)."""

    arrival: float = 0.4
    """The robot declares this near to where it remembers the mark [m]. Ours: within 1 m asked."""
    near_enough: float = 0.9
    """A mark that cannot be reached is declared from within this [m]. Ours: 1 m is asked."""
    much_shorter: float = 0.6
    """A new exit is taken at once if it promises a way as short against the known one [1]. Ours:
    it may lead nowhere; 0.8: own doors in experiment 3 20 -> 15 of 20."""
    search_worth: float = 0.5
    """Share of what a straight way would save that is spent on looking [1]. Ours: a detour."""
    shared_wall: float = 0.9
    """A wall so near to a place bounds it too [m]. Ours: a wall's thickness and drift."""
    lost_steps: int = 140
    """Steps after which a robot without a known way gives in [1]. Ours: half of a budget."""
    there_steps: int = 80
    """Steps in its place after which a mark is out of reach [1]. Ours: three patiences."""
    patience: int = 25
    """Steps after which an exit on the way is given up [1]. Ours: three times the usual."""
    trail_jump: float = 0.5
    """Poses of the path this much farther apart than a move are not joined [m]. Ours: carried."""
    trail_cut: float = 0.5
    """What was found shut cuts the path so far around it [m]. Ours: two cells, a body."""
    near_exit: float = 3.0
    """Whether an exit is shut is judged from within this [m]. Ours: its line is exact to 0.1 m."""
    doorway_depth: float = 0.35
    """What is looked at before and behind its line [m]. Ours: over a wall's thickness."""
    doorway_free: float = 0.15
    """Free space on both sides of its middle that keeps it open [m]. Ours: half a narrow door."""
    literal: bool = False
    """Home is a beacon from anywhere [1]. Thesis 4.2.4."""


@dataclass(frozen=True, slots=True)
class Gaps:
    """Algorithm 2 and the gaps and exits of a view (thesis 3.3)."""

    min_width: float = 0.6
    """Narrowest gap the robot can cross [m]. Thesis 3.3."""
    max_exit_width: float = 1.2
    """Widest gap that counts as an exit [m]. Thesis 3.3."""
    occlusion_depth: float = 0.3
    """An end hides something if the next beam goes so much deeper [m]. Ours: 25 noise sds."""
    cover_share: float = 0.25
    """Share of its width by which an exit covers more than itself [1]. Ours: jambs and noise."""
    wall_length: float = 0.3
    """Shortest surface whose line may hold a doorway [m]. Ours: shorter ones point anywhere."""
    line_distance: float = 0.06
    """A point so near a wall's line is on it [m]. Ours: 5 noise sds, below half a jamb."""
    line_spread: float = 0.03
    """How that grows with the distance beyond the wall [1]. Ours: 2 deg of a fitted direction."""
    line_turn: float = 0.17
    """Slope up to which two walls are in line [1]. Ours: 10 deg, short walls point badly."""
    square_turn: float = 0.5
    """Slope up to which a wall is square to another [1]. Ours: 30 deg."""
    jamb_distance: float = 0.15
    """Something so near a jamb along the wall belongs to it [m]. Ours: spacing of beams at 5 m."""
    edge_slip: float = 0.3
    """How far a surface's end may lie from its wall's true end [m]. Ours: splits at jambs."""
    beyond: float = 0.4
    """A beam so far beyond the wall has gone through it [m]. Ours: over a wall's thickness."""
    room_beyond: float = 1.3
    """Some of those go so far at least [m]. Ours: a niche 1.05 m deep beside a cupboard passed."""
    known_wall: float = 0.15
    """A beam that ends so near to a known wall ends on it [m]. Ours: drift, noise."""
    max_known_door: float = 1.35
    """Widest opening in a known wall that is a door [m]. Ours: 1.2 m and beams 7 cm apart."""
    wall_beams: int = 3
    """So many beams pass through it [1]. Ours: single beams err."""
    room_share: float = 0.2
    """Share that does [1]. Ours: a door in a corner is seen against the wall that goes on."""
    blocked_share: float = 0.1
    """Share of beams that may end inside the doorway away from its jambs [1]. Ours: noise."""
    clear_share: float = 0.3
    """Share of the width through which beams must go [1]. Ours: 0.2 m walls at 60 deg leave 0.5."""
    min_sight_sine: float = 0.2
    """Flattest sight of a doorway, sine of the angle to the wall [1]. Ours: 78 deg of incidence."""
    corner_wall: float = 0.5
    """Least wall beside a doorway in a corner, or on both sides together [m]. Ours: stubs."""
    long_wall: float = 2.0
    """Longer than furniture [m]. Ours: desks and cupboards up to 1.8 m."""
    face_distance: float = 0.08
    """A beam so near a jamb along the wall shows its face [m]. Ours: 6 noise sds."""
    max_thickness: float = 0.3
    """Thickest wall [m]. Ours: 0.15 to 0.2 m in offices."""
    literal: bool = False
    """Merge neighbouring gaps alone; exits by width alone, as written [1]. Thesis 3.3."""


@dataclass(frozen=True, slots=True)
class Navigation:
    """Reaching a point without touching anything."""

    cell: float = 0.1
    """Cell of the local grid [m]. Ours: 2.3 ms of search on 12 x 12 m; doors of 0.8 m pass."""
    margin: float = 0.03
    """Free room kept round the body [m]. Ours: two sd of a range (12 mm) and a little."""
    soft_clearance: float = 0.6
    """Clearance beyond which more is worth nothing [m]. Ours: half a wide doorway; 0.45 on
    journeys: own doors in experiment 3 20 -> 18 of 20."""
    near_cost: float = 4.0
    """Extra cost of the tightest safe cell [1]. Ours: a detour five times as long is taken."""
    detour: float = 4.0
    """How far the grid reaches beyond start and goal [m]. Ours: round a desk or a partition."""
    max_grid: float = 24.0
    """Largest side of the local grid [m]. Ours: keeps the search under 10 ms."""
    goal_reach: float = 0.5
    """A goal in a tight place moves at most so far [m]. Ours: within the 1 m of an arrival."""
    leave_radius: float = 0.5
    """Around a tight start, cells as tight may be driven [m]. Ours: a body and its margin."""
    slack: float = 0.02
    """Clearance a straight stretch may lose against the grid's path [m]. Ours: grid rounding."""
    stop_margin: float = 0.05
    """Where a drive stops before what lies ahead [m]. Ours: range noise and 2 % of a drive."""
    drift: float = 0.15
    """Sideways error allowed for, a metre driven [m/m]. Ours: 1.0 m drives at 0.4 m clearance."""
    min_drive: float = 0.3
    """A drive is not made shorter than this for fear of drift [m]. Ours: gets out of clutter."""


@dataclass(frozen=True, slots=True)
class Boundary:
    """Algorithms 6 to 8: cutting an ASR out of the MFIS (thesis 3.5)."""

    large: float = 2.0
    """Surfaces at least this long are large [m]. Thesis 3.5, Algorithm 8."""
    corner_distance: float = 0.5
    """Small surfaces nearer than this make a corner point [m]. Thesis 3.5, Algorithm 8 step 1b."""
    confirm_before: bool = True
    """Keep only surfaces seen before the crossing [1]. Ours: mean IoU 0.915 -> 0.928."""
    walk: Literal["nearest", "least_gap"] = "least_gap"
    """How items are connected [1]. Ours: nearest is the text, 75 % close; 100 %."""
    keep_small: bool = True
    """Small surfaces are boundary items too [1]. Ours: IoU under 0.85 19 % -> 13 %."""
    drop_outside: bool = True
    """A closed ASR disowns surfaces outside it [1]. Ours: a wrong tag ruins the next ASR."""
    shut_gap: float = 1.3
    """Narrower gaps in a wall are not seen through [m]. Ours: IoU under 0.85 6 % -> 4 %."""
    exit_flank: float = 1.0
    """Wall beside an exit that is not seen through [m]. Ours: IoU under 0.85 5 % -> 4 %."""
    look_spacing: float = 0.7
    """Least distance between path points to look from [m]. Ours: half a move."""
    max_looks: int = 14
    """Most path points to look from [1]. Ours: bounds the run time."""
    look_earlier: bool = True
    """Look from the spots of earlier stays, too [1]. Ours: a part seen then is not cut off."""
    min_seen: float = 0.8
    """Share of a sight line that must have been seen to be free [1]. Ours: walls are hidden."""
    seen_spacing: float = 0.25
    """From one spot that is looked up for that to the next [m]. Ours: ``Curiosity.cell``."""
    seen_reach: float = 9.5
    """And as far from the eye [m]. Ours: ``Curiosity.reach`` and two cells."""
    margin: float = 0.12
    """Slack of sight lines and of crossings at surface ends [m]. Ours: twice the map's noise."""
    exit_slack: float = 0.4
    """How far beyond a jamb a path still counts as crossing the exit [m]. Ours: jamb noise."""
    max_trim: float = 0.6
    """Most that is cut off a surface beyond a corner [m]. Ours: surfaces overshoot corners."""
    max_extend: float = 2.5
    """Most that a surface is lengthened to an unseen corner [m]. Ours: occluded corners."""
    overlap_offset: float = 0.3
    """Parallel surfaces nearer than this are one wall [m]. Ours: twice-mapped walls."""
    min_corner_sine: float = 0.34
    """Sine of the least angle (20 deg) between lines that make a corner [1]. Ours: stable."""
    max_gap: float = 30.0
    """Longest connection between two items [m]. Ours: bounds the search."""
    hidden_cost: float = 1.0
    """Cost of a metre of seen surface cut off [m/m]. Ours: IoU under 0.85 19 % -> 13 %."""
    exit_worth: float = 3.0
    """Metres of surface that an exit counts for, when cut off [m]. Ours: exits are sure."""
    small_cost: float = 1.5
    """Cost of crossing a small surface [m]. Ours: furniture legs may not stop a boundary."""
    max_tries: int = 60
    """Alternatives that the search may try [1]. Ours: bounded backtracking."""
    max_fold: float = 0.05
    """Folds of the walk up to this area are cut off [m2]. Ours: ends overlap by the noise."""
    min_side: float = 1e-6
    """Shorter sides are no sides [m]. Ours: rounding."""
    path_inside: float = 0.9
    """Least share of the path inside the boundary [1]. Ours: the path may graze an exit."""

    @classmethod
    def literal(cls) -> Boundary:
        """The text of thesis 3.5 as written."""
        return cls(
            confirm_before=False,
            walk="nearest",
            keep_small=False,
            drop_outside=False,
            look_earlier=False,
            min_seen=0.0,
        )


@dataclass(frozen=True, slots=True)
class Params:
    """All parameters of the thesis robot; one set serves every map."""

    lines: Lines = field(default_factory=Lines)
    landmarks: Landmarks = field(default_factory=Landmarks)
    frame: Frame = field(default_factory=Frame)
    transfer: Transfer = field(default_factory=Transfer)
    obstacles: Obstacles = field(default_factory=Obstacles)
    passages: Passages = field(default_factory=Passages)
    exits: Exits = field(default_factory=Exits)
    association: Association = field(default_factory=Association)
    union: Union = field(default_factory=Union)
    exploration: Exploration = field(default_factory=Exploration)
    curiosity: Curiosity = field(default_factory=Curiosity)
    journeys: Journeys = field(default_factory=Journeys)
    gaps: Gaps = field(default_factory=Gaps)
    navigation: Navigation = field(default_factory=Navigation)
    boundary: Boundary = field(default_factory=Boundary)

    @classmethod
    def literal(cls) -> Params:
        """The text as written wherever text and default differ, so that each can be measured."""
        return cls(
            lines=Lines(literal=True),
            landmarks=Landmarks(literal=True),
            frame=Frame(kind="nearest"),
            transfer=Transfer(literal=True),
            passages=Passages(literal=True),
            exits=Exits(min_sightings=1),
            association=Association(literal=True),
            exploration=Exploration(literal=True),
            journeys=Journeys(literal=True),
            gaps=Gaps(literal=True),
            boundary=Boundary.literal(),
        )
