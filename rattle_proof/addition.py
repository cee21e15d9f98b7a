"""What a proof adds to basins: the entry of `rattle.additions`, by which the doors and the worker find it."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from worker.additions import Addition, Cost, Fields, Mask, TextOption


class _Proof(Addition):
    """A proof of a basin: of each cell, that every departure in it ends as the cell is coloured."""

    name = "prove"
    stages = ("enclosing", "proving")
    overlay = "proven"
    on_pairs = "a proof (prove=True) a tolerance"
    of_tiles = (
        "Where the tile has a proof, two arrays of uint8 follow: the sixty-fourths of each cell of which every "
        "departure is proven to end as the solution says, and why not all are (0 all are, 1 arrives nowhere, 2 spreads "
        "too wide, 3 straddles grazing, 4 a part ends otherwise)."
    )

    def field(self) -> tuple[Any, Any]:
        from rattle_proof.request import FIELD

        return FIELD

    def check(self, job: Any, large: bool) -> Any:
        from rattle_proof.request import check_proof

        return check_proof(job.prove, job.oscillator, job.axes, job.sample, large)

    def cost(self, job: Any) -> Cost:
        from rattle_proof.request import cost_of

        return cost_of(job)

    def arrays(self) -> tuple[Any, ...]:
        from rattle_proof.layout import PROVEN, UNPROVEN_REASON

        return PROVEN, UNPROVEN_REASON

    def run(self, store: Any, attractors: tuple[Any, ...]) -> Any:
        from rattle_proof.run import ProofRun

        return ProofRun(store, attractors)

    def read_tile(self, store: Any, tile: Any) -> tuple[Any, ...]:
        from rattle_proof.arrays import proof_of

        proof = proof_of(store)
        return (proof.read_tile(tile) if proof.wanted else None) or ()

    def owns(self, path: str) -> bool:
        from rattle_proof.layout import PROOF, PROVEN, UNPROVEN_REASON

        return path in (PROVEN.path, UNPROVEN_REASON.path) or path.split("/")[0] == PROOF

    def invalidate(self, store: Any, paths: Sequence[str]) -> None:
        from rattle_proof.arrays import proof_of
        from rattle_proof.layout import PROOF

        # A tile whose proof is not there is proven again.
        if any(path.startswith(f"{PROOF}/") for path in paths):
            proof_of(store).forget_lattice()

    def opened(self, dataset: Any, open_group: Callable[[str], Any]) -> Any:
        from rattle_proof.results import with_proof

        return with_proof(dataset, open_group)

    def mask(self) -> Mask:
        from rattle_proof.unproven import UNPROVEN

        return UNPROVEN

    def solution_fields(self) -> Fields:
        from rattle_proof.results import SOLUTION_FIELDS

        return SOLUTION_FIELDS

    def of_solutions(self, store: Any) -> Iterable[dict[str, Any]]:
        from rattle_proof.arrays import proof_of

        return [{"share_proven": share} for share in (proof_of(store).certificate or {}).get("shares", ())]

    def outline_fields(self) -> Fields:
        from rattle_proof.results import OUTLINE_FIELDS

        return OUTLINE_FIELDS

    def of_outline(self, store: Any) -> dict[str, Any]:
        from rattle_proof.arrays import proof_of

        return {"proof": proof_of(store).wanted}

    def page(self) -> dict[str, Any]:
        from rattle_proof.page import PAGE

        return PAGE

    def routes(self) -> Any:
        from rattle_proof.routes import router

        return router

    def with_values(self, arguments: dict[str, Any]) -> dict[str, Any]:
        from rattle_proof.arguments import with_middles

        return with_middles(arguments)

    def from_arguments(self, arguments: dict[str, Any]) -> Any:
        from rattle_proof.arguments import prove_of

        return prove_of(arguments)

    def text_options(self) -> dict[str, TextOption]:
        from rattle_proof.arguments import TOLERANCES

        return {"tolerances": TOLERANCES}

    def least(self) -> dict[str, int]:
        return {"levels": 0}

    def in_words(self, solution: Mapping[str, Any]) -> str:
        share = solution.get("share_proven")
        return "" if share is None else f", {100 * share:.3f} % proven"

    def results(self) -> dict[str, Callable[[Any], Any]]:
        from rattle_proof.results import certificate

        return {"certificate": certificate}

    def crate_files(self, dataset: Any) -> Iterator[tuple[str, bytes, str, str]]:
        from rattle_proof.results import crate_files

        return crate_files(dataset)


ADDITION = _Proof()
