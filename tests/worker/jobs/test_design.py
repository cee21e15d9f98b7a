"""The request of a list of machines: what it becomes, and what is wrong with one that is refused."""

import json

import numpy as np
import pytest

from rattle_kernels import CellGrid, ExpectedLoudness, Harmonic, Loudness, Oscillator, check_quiet, settled_iterations
from worker.errors import InvalidFields, InvalidJob, SweptOutsideDomain
from worker.jobs.basin_job import BasinJob, SweepJob, basin_job
from worker.jobs.design import RESERVED, Design
from worker.kinds import kind_of
from worker.results import measures
from worker.stores import layout
from worker.stores.new_store import new_metadata

PARAMETERS = {"eccentricity": [0.12, 0.1, 0.09], "damping": [0.9, 0.6, 0.55]}
DESIGN = {"name": "speed", "units": "rpm", "values": [800, 1000, 1200], "parameters": PARAMETERS}


def test_a_design_survives_the_way_through_its_request():
    job = SweepJob(design=DESIGN, grid=CellGrid(time_cells=3, velocity_cells=4))
    request = job.request()
    assert basin_job(json.loads(json.dumps(request))) == job == SweepJob.trusted(request, job.digest)
    assert "vary" not in request and kind_of(request) == "sweep"
    # The oscillator is that of the first machine, and the columns are in order.
    assert request["oscillator"] == {"model": "impacting", "damping": 0.9, "eccentricity": 0.12, "half_backlash": 0.6}
    assert list(request["design"]["parameters"]) == ["damping", "eccentricity"]
    assert (job.basins, job.sweep_shape, job.cell_count) == (3, (3,), 36)
    assert [job.oscillator_of(number) for number in range(3)] == [
        Oscillator(0.9, 0.12), Oscillator(0.6, 0.1), Oscillator(0.55, 0.09)
    ]  # fmt: skip
    assert job.values_of(1) == {"speed": 1000.0}
    assert job.iterations == settled_iterations(0.55)


def test_equal_designs_have_equal_digests_however_they_were_written():
    job = SweepJob(design=DESIGN)
    turned = DESIGN | {"parameters": dict(reversed(PARAMETERS.items())), "values": [800.0, 1e3, 1.2e3]}
    assert SweepJob(design=turned, oscillator=Oscillator(damping=0.7)).digest == job.digest
    assert SweepJob(design=Design(**DESIGN)).digest == job.digest
    assert SweepJob(design=DESIGN | {"units": "1/min"}).digest != job.digest
    assert SweepJob(design=DESIGN | {"units": None}).digest == SweepJob(
        design={name: value for name, value in DESIGN.items() if name != "units"}
    ).digest  # fmt: skip


def test_a_stiffness_that_changes_is_given_by_the_design_alone():
    parameters = {"stiffness": [1e3, 2e3], "phase_2": [0.0, 0.5]}
    oscillator = {"model": "piecewise_linear", "harmonics": [{"order": 2, "amplitude": 0.001}]}
    job = SweepJob(oscillator=oscillator, design={"name": "machine", "values": [0, 1], "parameters": parameters})
    assert job.oscillator_of(1) == Oscillator(stiffness=2e3, harmonics=(Harmonic(2.0, 0.001, 0.5),))


@pytest.mark.parametrize(
    ("changes", "place", "told"),
    [
        ({"values": [1, 2]}, ("design", "parameters", "eccentricity"), "eccentricity has 3 values for 2 machines"),
        ({"values": []}, ("design", "values"), "speed needs at least one value"),
        ({"values": [1, 3, 2]}, ("design", "values", 2), "must ascend or descend"),
        ({"parameters": {"damping": []}}, ("design", "parameters", "damping"), "damping has 0 values for 3 machines"),
        ({"parameters": {"phase_2": [0.1, 0.2, 0.3]}}, ("design", "parameters", "phase_2"), "phase_2 cannot be swept"),
        ({"parameters": {"stiffness": [1, 2, 3]}}, ("design", "parameters", "stiffness"), "where it is infinite"),
        (
            {"parameters": {"contact_damping": [0.1, 0.2, 0.3]}},
            ("design", "parameters", "contact_damping"),
            "impacting model, which has none",
        ),
    ],
)
def test_what_is_wrong_with_a_design_is_said_with_its_location(changes, place, told):
    with pytest.raises(InvalidJob, match=told) as refused:
        SweepJob(design=DESIGN | changes)
    assert refused.value.place == place


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"parameters": {}}, "design.parameters: Dictionary should have at least 1 item"),
        ({"parameters": {"mass": [1, 2, 3]}}, "mass is no parameter; these are: damping"),
        ({"parameters": {"damping": [0.6, "x", 0.6]}}, r"design.parameters.damping.1: Input should be a valid number"),
        ({"name": "damping"}, "damping is a parameter, and no coordinate"),
        ({"name": "velocity"}, "velocity is a name of results already"),
        ({"name": "Speed"}, "named in small letters"),
        ({"units": " "}, "units are 1 to 24 printed characters"),
        ({"unit": "rpm"}, "design.unit: Extra inputs are not permitted"),
    ],
)
def test_a_field_of_a_design_that_is_wrong_is_named(changes, told):
    with pytest.raises(InvalidFields, match=told):
        SweepJob(design=DESIGN | changes)


def test_a_sweep_steps_along_parameters_or_along_a_design():
    vary = [{"parameter": "damping", "values": [0.5]}]
    with pytest.raises(InvalidJob, match="vary, or a design, not both"):
        SweepJob(vary=vary, design=DESIGN)
    for neither in ({}, {"design": None}):
        with pytest.raises(InvalidJob, match="Field required: the swept parameters, or else a design"):
            SweepJob(**neither)
    assert SweepJob(vary=vary, design=None).digest == SweepJob(vary=vary).digest
    with pytest.raises(InvalidFields, match="design: Extra inputs"):
        BasinJob(design=DESIGN)


def curved(count):
    """Machines whose first and last are within the bound of Eq. (3), as those in the middle are not."""
    damping = 0.6 - 0.4 * np.sin(np.linspace(0.0, np.pi, count))
    return {"damping": damping.tolist(), "eccentricity": np.linspace(0.1, 0.11, count).tolist()}


def test_the_first_machine_outside_the_domain_is_named_wherever_it_lies():
    machines = curved(41)
    oscillators = [Oscillator(*each, stiffness=1e4) for each in zip(*machines.values(), strict=True)]

    def accepted(oscillator):
        try:
            return bool(check_quiet(oscillator))
        except ValueError:
            return False

    taken = [accepted(oscillator) for oscillator in oscillators]
    first = taken.index(False)
    assert taken[0] and taken[-1] and first > 1
    speeds = np.linspace(600.0, 1000.0, 41).tolist()
    with pytest.raises(SweptOutsideDomain, match=rf"machine {first} \(at speed = {speeds[first]:g} rpm\)") as refused:
        SweepJob(
            oscillator={"model": "piecewise_linear", "stiffness": 1e4},
            design={"name": "speed", "units": "rpm", "values": speeds, "parameters": machines},
        )
    assert refused.value.place == ("design", "parameters", "eccentricity", first)
    # A bound of one number alone is no less seen.
    half_backlash = [0.6] * 20 + [-0.6] + [0.6] * 20
    with pytest.raises(SweptOutsideDomain, match="machine 20 .*half_backlash must be positive"):
        SweepJob(design={"name": "speed", "values": speeds, "parameters": {"half_backlash": half_backlash}})


def test_no_coordinate_takes_a_name_of_results():
    names = set(Loudness._fields) | {f"expected_{name}" for name in Loudness._fields} | set(ExpectedLoudness._fields)
    names |= {*measures._OF_SOLUTIONS, *measures._OF_PANEL}
    for job in (BasinJob(grid=CellGrid(time_cells=9, velocity_cells=9)), BasinJob(sample={"points": 64})):
        for path, node in new_metadata(job).items():
            names |= {path.split("/")[-1], *(node.get("dimension_names") or ())}
    names |= {variable.name for variable in layout.measured(8)}
    assert {name for name in names if name.islower()} <= RESERVED
