"""What can be seen of a service without asking its jobs: metrics, logs, readiness."""

import atexit
import io
import json
import logging
import subprocess
import sys
import threading
from importlib import metadata

import pytest

from service.logs import LogFormat, about_job, write_logs
from service.records.job_record import JobState
from service.runner import metrics as run_metrics
from tests.service.idle_service import idle_service
from tests.waiting import wait_until
from worker.cluster.connection import ReconnectingCluster
from worker.cluster.driver import Driver
from worker.progress import Progress, Stage


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def sample(service, name):
    lines = [line for line in service.request("GET", "/metrics").text.splitlines() if line.startswith(name + " ")]
    return float(lines[0].split()[-1]) if lines else 0.0


def progress(stage, tiles, cells):
    return Progress(stage, tiles, 10, cells, 100, 1.0, None, 0, 1)


def test_metrics_count_jobs_by_state_from_the_database(service):
    first, _ = service.add_job(10), service.add_job(11)
    service.jobs.transition(first.id, JobState.QUEUED, JobState.RUNNING)
    assert sample(service, 'rattle_jobs{state="queued"}') == 1
    assert sample(service, 'rattle_jobs{state="running"}') == 1
    service.jobs.transition(first.id, JobState.RUNNING, JobState.FAILED)
    assert sample(service, 'rattle_jobs{state="running"}') == 0
    assert sample(service, 'rattle_jobs{state="failed"}') == 1


def test_metrics_count_what_a_run_does_and_not_what_was_there_before(service):
    tiles, cells = 'rattle_tiles_total{stage="mapping"}', "rattle_cells_total"
    before = sample(service, tiles), sample(service, cells)
    pace = run_metrics.Pace()
    for each in (
        progress(Stage.MAPPING, 4, 40),  # resumed
        progress(Stage.MAPPING, 7, 70),
        progress(Stage.LABELLING, 1, 100),
        progress(Stage.LABELLING, 3, 100),
        progress(Stage.MAPPING, 1, 10),
    ):
        pace(each)
    assert (sample(service, tiles) - before[0], sample(service, cells) - before[1]) == (3, 30)
    assert sample(service, 'rattle_tiles_total{stage="labelling"}') >= 2


def test_metrics_say_how_many_tiles_the_runs_of_a_replica_have_left(service):
    one, other = run_metrics.Pace(), run_metrics.Pace()
    before, left = sample(service, "rattle_tiles_left"), []
    for report in (
        lambda: one(progress(Stage.MAPPING, 4, 40)),
        lambda: other(progress(Stage.MAPPING, 9, 90)),
        lambda: one(progress(Stage.LABELLING, 0, 100)),
        one.end,
        other.end,
    ):
        report()
        left.append(sample(service, "rattle_tiles_left") - before)
    assert left == [6, 7, 11, 1, 0]


def test_metrics_time_requests_by_route_and_not_by_path(service):
    for number in range(3):
        service.request("GET", f"/v1/jobs/{number:032x}")
        service.request("GET", f"/nothing/{number}")
    text = service.request("GET", "/metrics").text
    counted = 'rattle_request_seconds_count{method="GET",route="%s",status="404"} '
    assert counted % "/v1/jobs/{job_id}" in text and counted % "none" in text
    assert "/nothing" not in text and "0" * 20 not in text


def written(form, what, until="", least="info"):
    """Lines that the log has of what a function logs, once a word is among them."""
    root, handlers, level = logging.getLogger(), logging.getLogger().handlers[:], logging.getLogger().level
    listener = write_logs(form, least)
    listener.handlers[0].stream = stream = io.StringIO()
    atexit.unregister(listener.stop)
    try:
        what(logging.getLogger("rattle.test"))
        wait_until(f"{until} is logged", lambda: until in stream.getvalue(), pause=0.01)
        listener.stop()
        return stream.getvalue().splitlines()
    finally:
        root.handlers[:] = handlers
        root.setLevel(level)


def test_log_lines_are_json_and_say_which_job_they_are_about():
    def work(log):
        log.info("before")
        with about_job("abc"):
            log.warning("a line\nand another")
            try:
                raise ValueError("why")
            except ValueError:
                log.exception("failed")
        other = threading.Thread(target=lambda: log.info("elsewhere"))
        other.start()
        other.join()

    lines = [json.loads(line) for line in written(LogFormat.JSON, work)]
    assert [line.get("job") for line in lines] == [None, "abc", "abc", None]
    assert lines[1]["message"] == "a line\nand another" and lines[1]["level"] == "warning"
    assert lines[2]["traceback"].endswith("ValueError: why")
    assert all(line["time"].endswith("+00:00") and line["logger"] == "rattle.test" for line in lines)


_ALL_THAT_LOGS = """
import logging, threading, warnings
import distributed  # its loggers have a stream of their own
from service.logs import LogFormat, write_logs

write_logs(LogFormat.JSON, "info")
logging.getLogger("distributed.client").warning("Dask's warning\\nof two lines")
logging.getLogger("distributed.core").error("Dask's error")
logging.getLogger("distributed.core").info("Dask's news")
logging.getLogger("uvicorn.error").error("Uvicorn's error")
warnings.warn("Python's warning")
ending = threading.Thread(target=lambda: 1 / 0, name="ending")
ending.start()
ending.join()
"""


def test_what_libraries_log_and_warn_of_and_what_ends_a_thread_are_lines_of_the_same_log():
    ran = subprocess.run([sys.executable, "-c", _ALL_THAT_LOGS], capture_output=True, text=True)
    assert ran.returncode == 0 and ran.stdout == "", ran.stderr
    told = {line["logger"]: line for line in map(json.loads, ran.stderr.splitlines())}
    assert set(told) == {"distributed.client", "distributed.core", "uvicorn.error", "py.warnings", "rattle.service"}
    assert told["distributed.client"]["message"] == "Dask's warning\nof two lines"
    assert told["distributed.core"]["message"] == "Dask's error" and len(ran.stderr.splitlines()) == 5
    assert "Python's warning" in told["py.warnings"]["message"]
    assert "the thread ending has ended" in told["rattle.service"]["message"]
    assert "ZeroDivisionError" in told["rattle.service"]["traceback"]


def test_plain_lines_say_it_too():
    def work(log):
        with about_job("abc"):
            log.info("runs")

    assert written(LogFormat.PLAIN, work)[0].endswith("INFO rattle.test: runs [job abc]")


def test_answers_are_logged_with_who_asked_and_no_client_breaks_a_line(service):
    def work(_):
        service.request("GET", "/v1/jobs?size=1")
        service.request("GET", "/nothing/%0d%0aINFO forged")

    lines = [json.loads(line) for line in written(LogFormat.JSON, work, until="forged")]
    first, second = (line for line in lines if line["logger"] == "rattle.access")
    assert (first["method"], first["path"], first["status"], first["key"]) == ("GET", "/v1/jobs", 200, "local")
    assert first["client"] == "127.0.0.1" and first["milliseconds"] >= 0
    assert second["path"].startswith("/nothing/%0D%0A") or second["path"].startswith("/nothing/%0d%0a")


@pytest.mark.parametrize(
    ("trusted", "told"), [(None, "127.0.0.1"), ("10.0.0.1", "127.0.0.1"), ("10.0.0.1,127.0.0.0/8", "192.0.2.7")]
)
def test_a_clients_address_is_what_a_trusted_proxy_says(monkeypatch, tmp_path, trusted, told):
    def work(_):
        service.request("GET", "/v1/jobs", headers={"x-forwarded-for": "192.0.2.7"})

    with idle_service(monkeypatch, tmp_path, trusted_proxies=trusted) as service:
        lines = [json.loads(line) for line in written(LogFormat.JSON, work, until="/v1/jobs")]
    (line,) = (line for line in lines if line["logger"] == "rattle.access")
    assert line["client"] == told


def test_what_monitors_ask_for_is_logged_for_debugging_alone(service):
    def work(_):
        for path in ("/healthz", "/readyz", "/metrics", "/v1/jobs?size=2"):
            service.request("GET", path)

    def paths(level):
        lines = [json.loads(line) for line in written(LogFormat.JSON, work, "/v1/jobs", level)]
        return [line["path"] for line in lines if line["logger"] == "rattle.access"]

    assert paths("info") == ["/v1/jobs"]
    assert paths("debug") == ["/healthz", "/readyz", "/metrics", "/v1/jobs"]


def test_the_version_is_told_by_health_and_metrics(service):
    assert service.request("GET", "/healthz").json()["version"] == metadata.version("gear-rattle")
    told = f'rattle_info{{version="{metadata.version("gear-rattle")}"}} 1.0'
    assert told in service.request("GET", "/metrics").text.splitlines()


def test_a_service_is_ready_with_a_database_and_a_worker_alone(service):
    runner, jobs = service.app.state.runner, service.app.state.jobs
    assert service.request("GET", "/readyz").json() == {"ready": True, "database": True, "workers": 2}
    runner.there = 0
    answer = service.request("GET", "/readyz")
    assert answer.status_code == 503 and answer.json() == {"ready": False, "database": True, "workers": 0}
    runner.there = 1
    service.app.state.probes.database._ask = lambda: False
    answer = service.request("GET", "/readyz")
    assert answer.status_code == 503 and answer.json() == {"ready": False, "database": False, "workers": 1}
    assert jobs.answers()


def test_readiness_is_answered_in_time_by_what_hangs_and_waits_in_one_thread(service):
    asked, answered, release = [], [], threading.Event()

    def hang():
        asked.append(1)
        release.wait(60)
        answered.append(1)
        return True

    service.app.state.probes.database._ask = hang
    threads = [threading.Thread(target=service.request, args=("GET", "/readyz")) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(asked) == 1 and not answered
    assert service.request("GET", "/readyz").status_code == 503 and len(asked) == 1
    release.set()


def test_a_scheduler_that_hangs_has_no_workers():
    class Hanging:
        status = "running"
        scheduler = type("Scheduler", (), {"ncores": None})()

        def sync(self, *_, callback_timeout, **__):
            assert callback_timeout <= 3
            raise TimeoutError

    cluster = ReconnectingCluster(None, 1)
    cluster._driver = Driver(Hanging())
    assert cluster.workers() == 0
