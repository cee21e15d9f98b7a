"""The certificate of a proof over HTTP."""

from fastapi import APIRouter, Response
from fastapi.responses import JSONResponse

from rattle_proof.arrays import proof_of
from service.errors import NotReady
from service.routes.dependencies import LARGE, JobId, JobsHere, SettingsHere, problems, require_kind
from service.routes.results import location_of
from worker.stores.basin_store import BasinStore

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["results"])


@router.get(
    "/certificate.json",
    summary="The certificate of a proof",
    response_class=Response,
    responses={
        200: {"content": {"application/json": {}}},
        **problems(
            s404="there is no such job, or it has not begun",
            s409="the job is no basin: only basins have a certificate",
        ),
    },
    dependencies=[LARGE],
)
def get_certificate(job_id: JobId, jobs: JobsHere, settings: SettingsHere) -> Response:
    """What a basin is proven from: the machine's intervals, the targets with their constants, counts and shares.

    Where `counts` are missing the proof is under way.
    """
    require_kind(jobs.get(job_id), "a certificate", "basin")
    # Opened anew: a certificate grows while the root, by which open stores are known, stays as it is.
    certificate = proof_of(BasinStore(location_of(job_id, jobs, settings))).certificate
    if certificate is None:
        raise NotReady(f"job {job_id} has no certificate: no proof was asked for, or it has not begun")
    return JSONResponse(certificate)
