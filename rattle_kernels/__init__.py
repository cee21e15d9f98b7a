"""Flights, impact maps and cell mapping of a backlash oscillator, with NumPy and Numba alone.

This is the public face. What else the folders hold is for the worker, and may change.

Floors, the highest first; each imports from lower ones alone ::

    warm_up
    basins
    basin_measures
    manifolds
    attractors
    cell_mapping
    lanes | orbits
    impact_map
    model
    numerics
"""

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import UNASSIGNED, name_solutions
from rattle_kernels.attractors.loudness import Loudness, loudness
from rattle_kernels.attractors.matching import attractor_distance, continue_attractor
from rattle_kernels.basin_measures.boundary import boundary_cells, boundary_share
from rattle_kernels.basin_measures.boundary_dimension import BoundaryDimension, boundary_dimension
from rattle_kernels.basin_measures.entropy import BasinEntropy, basin_entropy
from rattle_kernels.basin_measures.expected_loudness import ExpectedLoudness, expected_loudness
from rattle_kernels.basin_measures.integrity import (
    LargestDisc,
    global_integrity_measure,
    integrity_factor,
    local_integrity_measure,
)
from rattle_kernels.basin_measures.least_disturbance import LeastDisturbance, least_disturbance
from rattle_kernels.basin_measures.shares import Shares, shares_of
from rattle_kernels.basin_measures.uncertainty_exponent import UncertaintyExponent, uncertainty_exponent
from rattle_kernels.basins.basin import Basin, basin
from rattle_kernels.cell_mapping.cell_grid import SINK, CellGrid
from rattle_kernels.cell_mapping.cell_groups import CellGroups, find_groups, label_cells
from rattle_kernels.cell_mapping.cell_map import NOT_CONVERGED, PERMANENT_CONTACT, CellImages, map_cells, map_points
from rattle_kernels.cell_mapping.iterations import expected_applications, settled_iterations
from rattle_kernels.impact_map.apply import Impacts, previous_impacts
from rattle_kernels.impact_map.capture_velocity import capture_velocity
from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.impact_map.pulse import PulseDepartures, departures_after_pulses
from rattle_kernels.impact_map.rest_velocity import rest_velocity
from rattle_kernels.impact_map.time_history import Contacts, Direction, TimeHistory, time_history
from rattle_kernels.lanes.listening import Episodes, until_captured
from rattle_kernels.lanes.lyapunov import TangentGrowth, tangent_growth
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.manifolds.grazing_preimages import FirstCurve, TooManyPoints, grazing_preimages
from rattle_kernels.manifolds.polyline import CurveResolution, Piece, arclength
from rattle_kernels.manifolds.saddle import NotASaddle, find_saddle
from rattle_kernels.manifolds.stable_manifold import (
    ManifoldBranch,
    ManifoldEnd,
    ManifoldLimits,
    stable_manifold,
    unstable_manifold,
)
from rattle_kernels.manifolds.tangency import (
    ManifoldGap,
    ManifoldTip,
    NoTangency,
    Tangency,
    find_tangency,
    follow_tangency,
    manifold_gap,
    manifold_tips,
)
from rattle_kernels.model.bounds import (
    damping_bound_quiet,
    eccentricity_bound_convexity,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    stiffness_bound,
    stiffness_gap_quiet,
)
from rattle_kernels.model.domain import (
    OutsideDomain,
    check_domain,
    check_impacting,
    check_invertible,
    check_oscillator,
    check_quiet,
)
from rattle_kernels.model.forcing import Forcing, eccentric_gears, torque_ripple
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.harmonics import Harmonic
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.model.transmission_error import AngleUnit, TransmissionError, UnusableCurve, transmission_error
from rattle_kernels.orbits.bifurcation_curve import SpecialCurve, continue_special_point
from rattle_kernels.orbits.bifurcation_diagram import BifurcationDiagram, bifurcation_diagram
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.branch import Branch, BranchEnd
from rattle_kernels.orbits.codimension_two import CodimensionTwo, CodimensionTwoPoint, codimension_two_points
from rattle_kernels.orbits.continuation import continue_orbit
from rattle_kernels.orbits.graze_kind import (
    AttractorBeyond,
    GrazeKind,
    GrazeScenario,
    attractor_beyond,
    graze_kind,
)
from rattle_kernels.orbits.orbit_beyond_graze import curve_beside_graze, orbit_beyond_graze
from rattle_kernels.orbits.orbit_equations import SpecialKind
from rattle_kernels.orbits.orbit_search import FoundOrbit, find_orbit, find_orbits
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit
from rattle_kernels.orbits.single_contact_orbit import (
    SingleContactOrbit,
    eccentricity_bound_single_contact,
    single_contact_orbits,
)
from rattle_kernels.warm_up import warm_up, warm_up_analyses, warm_up_curves

__all__ = [
    "NOT_CONVERGED",
    "PERMANENT_CONTACT",
    "SINK",
    "UNASSIGNED",
    "AngleUnit",
    "Attractor",
    "AttractorBeyond",
    "AttractorKind",
    "Basin",
    "BasinEntropy",
    "BifurcationDiagram",
    "BoundaryDimension",
    "Branch",
    "BranchEnd",
    "CellGrid",
    "CellGroups",
    "CellImages",
    "CodimensionTwo",
    "CodimensionTwoPoint",
    "Contacts",
    "CurveResolution",
    "Direction",
    "Episodes",
    "ExpectedLoudness",
    "FirstCurve",
    "Forcing",
    "FoundOrbit",
    "GrazeKind",
    "GrazeScenario",
    "Harmonic",
    "Impacts",
    "LargestDisc",
    "LeastDisturbance",
    "Loudness",
    "ManifoldBranch",
    "ManifoldEnd",
    "ManifoldGap",
    "ManifoldLimits",
    "ManifoldTip",
    "NoTangency",
    "NotASaddle",
    "Oscillator",
    "Outcome",
    "OutsideDomain",
    "PeriodicOrbit",
    "Piece",
    "PulseDepartures",
    "Shares",
    "SingleContactOrbit",
    "SpecialCurve",
    "SpecialKind",
    "SpecialPoint",
    "Tangency",
    "TangentGrowth",
    "TimeHistory",
    "TooManyPoints",
    "TransmissionError",
    "UncertaintyExponent",
    "UnusableCurve",
    "arclength",
    "attractor_beyond",
    "attractor_distance",
    "basin",
    "basin_entropy",
    "bifurcation_diagram",
    "boundary_cells",
    "boundary_dimension",
    "boundary_share",
    "capture_velocity",
    "check_domain",
    "check_impacting",
    "check_invertible",
    "check_oscillator",
    "check_quiet",
    "codimension_two_points",
    "continue_attractor",
    "continue_orbit",
    "continue_special_point",
    "curve_beside_graze",
    "damping_bound_quiet",
    "departures_after_pulses",
    "eccentric_gears",
    "eccentricity_bound_convexity",
    "eccentricity_bound_quiet",
    "eccentricity_bound_single_contact",
    "eccentricity_bound_smooth_maxima",
    "expected_applications",
    "expected_loudness",
    "find_attractors",
    "find_groups",
    "find_orbit",
    "find_orbits",
    "find_saddle",
    "find_tangency",
    "follow_tangency",
    "global_integrity_measure",
    "graze_kind",
    "grazing_preimages",
    "grazing_velocity",
    "integrity_factor",
    "label_cells",
    "largest_grazing_speed",
    "least_disturbance",
    "local_integrity_measure",
    "loudness",
    "manifold_gap",
    "manifold_tips",
    "map_cells",
    "map_points",
    "name_solutions",
    "next_impacts",
    "orbit_beyond_graze",
    "previous_impacts",
    "rest_velocity",
    "settled_iterations",
    "shares_of",
    "single_contact_orbits",
    "stable_manifold",
    "stiffness_bound",
    "stiffness_gap_quiet",
    "tangent_growth",
    "time_history",
    "torque_ripple",
    "transmission_error",
    "uncertainty_exponent",
    "unstable_manifold",
    "until_captured",
    "warm_up",
    "warm_up_analyses",
    "warm_up_curves",
]
