"""Flights, impact maps and cell mapping of a backlash oscillator: NumPy and Numba, nothing else."""

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import UNASSIGNED, coarser_boxes, landing_boxes, name_solutions
from rattle_kernels.attractors.matching import attractor_distance, continue_attractor
from rattle_kernels.attractors.trapping_region import build_trap_table
from rattle_kernels.basin_measures.boundary import boundary_cells, boundary_share
from rattle_kernels.basin_measures.entropy import BasinEntropy, basin_entropy
from rattle_kernels.basin_measures.integrity import (
    LargestDisc,
    global_integrity_measure,
    integrity_factor,
    local_integrity_measure,
)
from rattle_kernels.basin_measures.least_disturbance import LeastDisturbance, least_disturbance
from rattle_kernels.basin_measures.uncertainty_exponent import UncertaintyExponent, uncertainty_exponent
from rattle_kernels.cell_mapping.cell_grid import SINK, CellGrid, check_grid
from rattle_kernels.cell_mapping.cell_groups import CellGroups, find_groups, label_cells
from rattle_kernels.cell_mapping.cell_map import (
    PERMANENT_CONTACT,
    UNDECIDED,
    CellImages,
    map_cells,
    map_points,
)
from rattle_kernels.cell_mapping.image_set import (
    ImageSet,
    MarkedWords,
    has_members,
    mark_images,
    members_of,
    place_images,
    unite,
    with_counts,
)
from rattle_kernels.cell_mapping.iterations import (
    check_iterations,
    expected_applications,
    settled_iterations,
)
from rattle_kernels.impact_map.apply import Impacts, previous_impacts
from rattle_kernels.impact_map.time_history import Contacts, Direction, TimeHistory, time_history
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.lanes.traps import NO_TRAPS, LaneTraps
from rattle_kernels.manifolds.grazing_preimages import (
    STRETCHES,
    TooManyPoints,
    grazing_preimages,
    join_stretches,
    preimages_of_stretch,
)
from rattle_kernels.manifolds.polyline import (
    CurveResolution,
    Piece,
    arclength,
    check_resolution,
    split_at_wrap,
)
from rattle_kernels.manifolds.saddle import NotASaddle, find_saddle
from rattle_kernels.manifolds.stable_manifold import (
    ManifoldBranch,
    ManifoldEnd,
    ManifoldLimits,
    check_limits,
    stable_manifold,
    unstable_manifold,
)
from rattle_kernels.model.grazing_curve import grazing_velocity
from rattle_kernels.model.oscillator import (
    Oscillator,
    OutsideDomain,
    check_domain,
    check_impacting,
    check_quiet,
    eccentricity_bound_convexity,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    stiffness_bound,
)
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from rattle_kernels.numerics.jit import watch_compiling
from rattle_kernels.orbits.bifurcation_curve import SpecialCurve, continue_special_point
from rattle_kernels.orbits.bifurcation_diagram import (
    BifurcationDiagram,
    Motions,
    bifurcation_diagram,
    follow_values,
)
from rattle_kernels.orbits.bifurcation_point import SpecialKind, SpecialPoint
from rattle_kernels.orbits.continuation import Branch, BranchEnd, continue_orbit
from rattle_kernels.orbits.orbit_beyond_graze import orbit_beyond_graze
from rattle_kernels.orbits.orbit_search import FoundOrbit, find_orbit, find_orbits, merge_orbits
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit
from rattle_kernels.orbits.single_contact_orbit import (
    SingleContactOrbit,
    eccentricity_bound_single_contact,
    single_contact_orbits,
)
from rattle_kernels.warm_up import warm_up, warm_up_analyses, warm_up_curves

__all__ = [
    "PERMANENT_CONTACT",
    "SINK",
    "UNASSIGNED",
    "STRETCHES",
    "UNDECIDED",
    "Attractor",
    "AttractorKind",
    "BasinEntropy",
    "BifurcationDiagram",
    "Branch",
    "BranchEnd",
    "CellGrid",
    "CellGroups",
    "CellImages",
    "FoundOrbit",
    "ImageSet",
    "Contacts",
    "CurveResolution",
    "Direction",
    "ImageSet",
    "Impacts",
    "LargestDisc",
    "LaneTraps",
    "LeastDisturbance",
    "ManifoldBranch",
    "ManifoldEnd",
    "ManifoldLimits",
    "Motions",
    "MarkedWords",
    "NO_TRAPS",
    "NotASaddle",
    "Oscillator",
    "Outcome",
    "OutsideDomain",
    "Piece",
    "PeriodicOrbit",
    "SingleContactOrbit",
    "SpecialCurve",
    "SpecialKind",
    "SpecialPoint",
    "UncertaintyExponent",
    "basin_entropy",
    "bifurcation_diagram",
    "TimeHistory",
    "attractor_distance",
    "TooManyPoints",
    "UncertaintyExponent",
    "arclength",
    "basin_entropy",
    "boundary_cells",
    "boundary_share",
    "check_domain",
    "check_grid",
    "check_impacting",
    "check_iterations",
    "check_limits",
    "check_quiet",
    "check_resolution",
    "coarser_boxes",
    "continue_attractor",
    "continue_orbit",
    "continue_special_point",
    "eccentricity_bound_convexity",
    "eccentricity_bound_quiet",
    "eccentricity_bound_single_contact",
    "eccentricity_bound_smooth_maxima",
    "find_attractors",
    "find_groups",
    "expected_applications",
    "follow_values",
    "find_orbit",
    "find_saddle",
    "find_orbits",
    "fuses_multiply_add",
    "global_integrity_measure",
    "grazing_preimages",
    "grazing_velocity",
    "has_members",
    "integrity_factor",
    "join_stretches",
    "label_cells",
    "landing_boxes",
    "least_disturbance",
    "local_integrity_measure",
    "map_cells",
    "map_points",
    "mark_images",
    "members_of",
    "merge_orbits",
    "name_solutions",
    "next_impacts",
    "place_images",
    "orbit_beyond_graze",
    "preimages_of_stretch",
    "previous_impacts",
    "split_at_wrap",
    "stable_manifold",
    "stiffness_bound",
    "time_history",
    "build_trap_table",
    "settled_iterations",
    "single_contact_orbits",
    "uncertainty_exponent",
    "unite",
    "unstable_manifold",
    "warm_up",
    "warm_up_analyses",
    "warm_up_curves",
    "watch_compiling",
    "with_counts",
]
