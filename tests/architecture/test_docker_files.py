"""The Dockerfile and the compose file are sound, say what they must, and keep no secret."""

import os
import re
import subprocess
import sys
import time
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
DOCKER = ROOT / "docker"
COMPOSE = yaml.safe_load((DOCKER / "compose.yaml").read_text())
PARTS = [name for name, part in COMPOSE["services"].items() if part["image"] == "gear-rattle"]


def linted(program, *arguments):
    command = [Path(sys.executable).parent / program, *arguments]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=60)
    return answer.returncode, answer.stdout + answer.stderr


def test_the_dockerfile_passes_its_linter():
    assert linted("hadolint", DOCKER / "Dockerfile") == (0, "")


def test_every_package_is_copied_into_the_image_and_nothing_that_is_copied_is_ignored():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    packages = set(project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"])
    copied = {
        source
        for sources in re.findall(r"^COPY (?!--from)(.+) \S+$", (DOCKER / "Dockerfile").read_text(), re.MULTILINE)
        for source in sources.split()
    }
    everything, *patterns = (ROOT / ".dockerignore").read_text().split()
    let_through = [pattern[1:] for pattern in patterns if pattern.startswith("!")]
    assert everything == "**" and packages <= copied
    assert [source for source in copied if not any(fnmatch(source, pattern) for pattern in let_through)] == []


def test_the_compose_file_is_of_the_schema():
    code, told = linted("check-jsonschema", "--builtin-schema", "vendor.compose-spec", DOCKER / "compose.yaml")
    assert code == 0, told


def test_the_image_has_a_user_of_its_own_and_a_health_check():
    last_stage = (DOCKER / "Dockerfile").read_text().rpartition("\nFROM ")[2]
    assert re.search(r"^USER \d+$", last_stage, re.MULTILINE) and "HEALTHCHECK" in last_stage


def test_there_is_everything_that_a_cluster_needs():
    assert COMPOSE["services"].keys() == {
        "proxy", "service", "scheduler", "worker", "database", "objects", "bucket", "dump", "backup",
    }  # fmt: skip
    assert PARTS == ["service", "scheduler", "worker"]


def test_a_backup_is_of_the_database_first_and_only_where_it_is_asked_for():
    """A result without a record is an orphan; a record without its result is a job that has none."""
    services = COMPOSE["services"]
    assert services["backup"]["depends_on"]["dump"] == {"condition": "service_completed_successfully"}
    assert {name for name, part in services.items() if part.get("profiles")} == {"dump", "backup"}
    assert "pg_dump" in services["dump"]["command"][0] and "s3 sync" in services["backup"]["command"][0]
    assert services["dump"]["volumes"] == services["backup"]["volumes"] == ["backup:/backup"]


@pytest.mark.parametrize("name", PARTS)
def test_every_part_is_restarted_whatever_its_code_and_can_do_little(name):
    part = COMPOSE["services"][name]
    assert part["restart"] == "always" and part["read_only"]
    # The image's volume has a name, or is no volume: else each start would leave one behind.
    assert ("service:/data" in part.get("volumes", [])) != ("/data" in part["tmpfs"])
    assert part["cap_drop"] == ["ALL"] and part["security_opt"] == ["no-new-privileges:true"]
    assert part["healthcheck"]["test"][0] == "CMD"
    assert "privileged" not in part and "network_mode" not in part


def test_only_the_proxy_is_published_and_on_loopback_unless_asked_otherwise():
    published = {name: part["ports"] for name, part in COMPOSE["services"].items() if "ports" in part}
    assert published == {"proxy": ["${RATTLE_PUBLISH:-127.0.0.1:8000}:8443"]}


def test_the_proxy_has_nothing_of_the_cluster():
    """Who has the cluster's key and reaches its scheduler runs code on every worker."""
    proxy, files = COMPOSE["services"]["proxy"], {name: each["file"] for name, each in COMPOSE["secrets"].items()}
    held = {files[name] for name in proxy["secrets"]}
    of_the_cluster = {files[name] for name in ("ca", "certificate", "key")}
    assert len(held) == 2 and not any(path in each for path in of_the_cluster for each in held)
    assert not re.search("certs/rattle|ca.pem", (DOCKER / "env.example").read_text())
    reached = [name for name, part in COMPOSE["services"].items() if set(part["networks"]) & set(proxy["networks"])]
    assert reached == ["service", "proxy"] and COMPOSE["services"]["service"]["networks"] == ["site", "cluster"]


@pytest.mark.parametrize("name", COMPOSE["services"])
def test_every_part_has_limits_and_logs_that_rotate(name):
    part = COMPOSE["services"][name]
    assert part["deploy"]["resources"]["limits"].keys() == {"cpus", "memory", "pids"}
    assert part["logging"]["options"].keys() == {"max-size", "max-file"}


def test_volumes_have_names():
    for part in COMPOSE["services"].values():
        for volume in part.get("volumes", []):
            source = volume.partition(":")[0]
            assert source.startswith("./") or source in COMPOSE["volumes"], volume


def test_a_clients_address_is_told_by_the_proxy_alone():
    conf = (DOCKER / "proxy" / "nginx.conf").read_text()
    assert "proxy_set_header X-Forwarded-For $remote_addr;" in conf  # what a client says of itself is dropped
    (subnet,) = COMPOSE["networks"]["site"]["ipam"]["config"]
    assert COMPOSE["services"]["service"]["environment"]["RATTLE_TRUSTED_PROXIES"] == subnet["subnet"]


def test_parts_of_the_cluster_speak_tls_and_show_no_dashboard():
    for name in ("scheduler", "worker"):
        command = COMPOSE["services"][name]["command"]
        assert "tls" in command and "--tls-key /run/secrets/key" in command and "--no-dashboard" in command
    assert COMPOSE["services"]["service"]["environment"]["RATTLE_SCHEDULER"].startswith("tls://")


def test_secrets_come_from_outside_and_are_demanded():
    for name, part in COMPOSE["services"].items():
        for variable, value in part.get("environment", {}).items():
            if re.search("PASSWORD|SECRET|KEY|DATABASE_URL", variable) and not str(value).startswith("/run/secrets/"):
                assert re.search(r"\$\{\w+:\?", value), f"{name}: {variable}"
    assert re.findall(r"^(.*(?:PASSWORD|SECRET).*)=$", (DOCKER / "env.example").read_text(), re.MULTILINE)


@pytest.mark.parametrize("script", ["start.sh", "processor.sh", "slim.sh"])
def test_scripts_are_of_the_plain_shell(script):
    assert linted("shellcheck", "--shell", "sh", DOCKER / script) == (0, "")


@pytest.mark.parametrize("script", ["service.sbatch", "workers.sbatch"])
def test_scripts_for_slurm_pass_their_linter(script):
    assert linted("shellcheck", DOCKER / "slurm" / script) == (0, "")


def test_parts_have_the_same_settings_on_slurm_as_in_the_compose_file():
    for part, script in (("scheduler", "service.sbatch"), ("worker", "workers.sbatch")):
        text = (DOCKER / "slurm" / script).read_text()
        exported = dict(re.findall(r"\b((?:DASK|MALLOC)_\w+)=(\S+)", text))
        variables = COMPOSE["services"][part]["environment"]
        theirs = {name: value for name, value in variables.items() if name.startswith(("DASK_", "MALLOC_"))}
        if part == "worker":
            theirs = {name: value for name, value in theirs.items() if "SCHEDULER" not in name}
        assert exported == theirs


def test_a_processor_is_told_and_kept_where_it_is_given():
    def name_of(**environment):
        command = ["sh", DOCKER / "processor.sh", "sh", "-c", "echo ${NUMBA_CPU_NAME:-none} ${NUMBA_CPU_FEATURES-none}"]
        return subprocess.run(
            command, env={"PATH": "/usr/bin:/bin"} | environment, capture_output=True, text=True, check=True
        ).stdout.strip()

    assert name_of() in ("x86-64-v4 -prefer-256-bit", "x86-64-v3", "none none")
    assert name_of(NUMBA_CPU_NAME="x86-64-v4") == "x86-64-v4 -prefer-256-bit"
    assert name_of(NUMBA_CPU_NAME="x86-64-v3") == "x86-64-v3"


@pytest.mark.parametrize("seconds, code", [(100, 1), (3600, 0)])
def test_a_task_of_slurm_whose_time_is_too_short_says_so(tmp_path, seconds, code):
    """The script alone under bash: what it calls does nothing, and `dask` ends the task as Slurm would."""
    programs = tmp_path / "venv" / "bin"
    programs.mkdir(parents=True)
    for name, body in (("python", "exit 0"), ("dask", 'echo "$@" > "$TOLD"; kill -USR1 "$PPID"')):
        (programs / name).write_text(f"#!/bin/sh\n{body}\n")
        (programs / name).chmod(0o755)
    (tmp_path / "scheduler").write_text("tls://node1:8786\n")
    slurm = {"SLURM_JOB_ID": "1", "SLURM_CPUS_PER_TASK": "8", "SLURM_JOB_END_TIME": str(int(time.time()) + seconds)}
    done = subprocess.run(
        ["bash", DOCKER / "slurm" / "workers.sbatch", tmp_path], capture_output=True, text=True, timeout=60,
        env={"PATH": os.environ["PATH"], "TMPDIR": str(tmp_path), "TOLD": str(tmp_path / "told"), **slurm},
    )  # fmt: skip
    assert done.returncode == code, done.stderr
    assert ("no time is left for workers" in done.stderr) == (code == 1) == (not (tmp_path / "told").exists())
    if code == 0:
        told = (tmp_path / "told").read_text()
        assert told.startswith("worker tls://node1:8786 --nworkers 8 --nthreads 1")
        (lifetime,) = re.findall(r"--lifetime (\d+)s", told)
        assert seconds - 240 - 60 <= int(lifetime) <= seconds - 240
