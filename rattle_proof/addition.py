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
        "too wide, 3 straddles grazing, 4 a part ends otherwise, 5 the rest never falls quiet)."
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
        from rattle_proof.layout import NEVER_QUIET, PROVEN, UNPROVEN_REASON

        return PROVEN, NEVER_QUIET, UNPROVEN_REASON

    def run(self, store: Any, attractors: tuple[Any, ...]) -> Any:
        from rattle_proof.run import ProofRun

        return ProofRun(store, attractors)

    def read_tile(self, store: Any, tile: Any) -> tuple[Any, ...]:
        from rattle_proof.arrays import proof_of

        proof = proof_of(store)
        cells = proof.read_tile(tile) if proof.wanted else None
        return () if cells is None else (cells.proven, cells.reason)

    def owns(self, path: str) -> bool:
        from rattle_proof.layout import NEVER_QUIET, PROOF, PROVEN, UNPROVEN_REASON

        own = (PROVEN.path, NEVER_QUIET.path, UNPROVEN_REASON.path)
        return path in own or path.split("/")[0] == PROOF

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
        from rattle_proof.results import shares_of

        return [
            {"share_proven": least, "share_at_most": most} for least, most in shares_of(proof_of(store).certificate)
        ]

    def outline_fields(self) -> Fields:
        from rattle_proof.results import OUTLINE_FIELDS

        return OUTLINE_FIELDS

    def of_outline(self, store: Any) -> dict[str, Any]:
        from rattle_proof.arrays import proof_of
        from rattle_proof.results import shares_of

        proof = proof_of(store)
        return {"proof": True, "share_bounds": shares_of(proof.certificate)} if proof.wanted else {"proof": False}

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
        from rattle_proof.results import bounds_in_words

        least, most = solution.get("share_proven"), solution.get("share_at_most")
        return "" if least is None or most is None else f", {bounds_in_words(least, most)}"

    def below_shares(self, dataset: Any) -> list[str]:
        from rattle_proof.results import bounds_in_words, certificate_in, shares_of

        return [bounds_in_words(*bounds) for bounds in shares_of(certificate_in(dataset))]

    def results(self) -> dict[str, Callable[[Any], Any]]:
        from rattle_proof.results import certificate

        return {"certificate": certificate}

    def crate_files(self, dataset: Any) -> Iterator[tuple[str, bytes, str, str]]:
        from rattle_proof.results import crate_files

        return crate_files(dataset)


ADDITION = _Proof()
