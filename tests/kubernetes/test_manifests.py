"""The manifests are of the schemas of Kubernetes and of the operators, and say what someone who runs them looks for."""

import base64
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import kubernetes_validate
import pytest
import yaml
from cryptography import x509
from jsonschema import Draft202012Validator

from service.routes import health
from service.settings import Settings
from tests.kubernetes.manifests import COMPONENTS, DOCKER, WITH_OPERATOR, built, containers, named, pods
from tests.kubernetes.policies import allowed

HERE = Path(__file__).parent
# The oldest that has what is used (preStop's sleep, from 1.30 without asking), and the newest that is known here.
VERSIONS = ("1.30", "1.37")
COMPOSE = yaml.safe_load((DOCKER / "compose.yaml").read_text())["services"]


@pytest.fixture(scope="module", params=[COMPONENTS, WITH_OPERATOR], ids=["workers", "operator"])
def objects(request, tmp_path_factory):
    return built(tmp_path_factory.mktemp("manifests"), request.param)


@pytest.fixture(scope="module")
def deployed(tmp_path_factory):
    return built(tmp_path_factory.mktemp("manifests"))


def closed(schema):
    """The same schema, that takes nothing it does not name: a server would drop it without a word."""
    if isinstance(schema, list):
        return [closed(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {name: closed(each) for name, each in schema.items()}
    free = schema.keys() & {"additionalProperties", "x-kubernetes-preserve-unknown-fields", "allOf", "anyOf"}
    if isinstance(schema.get("properties"), dict) and schema.get("type") == "object" and not free:
        schema["additionalProperties"] = False
    return schema


def schema_of(kind):
    """Schema of an operator's kind, with what every object has."""
    schema = closed(json.loads((HERE / f"{kind.lower()}.json").read_text()))
    schema["properties"] |= {"apiVersion": {"type": "string"}, "kind": {"const": kind}, "metadata": {"type": "object"}}
    return schema


def test_every_object_is_of_its_schema(objects):
    for each in objects:
        if each["apiVersion"].startswith(("kubernetes.dask.org/", "keda.sh/")):
            Draft202012Validator(schema_of(each["kind"])).validate(each)
        else:
            for version in VERSIONS:
                kubernetes_validate.validate(each, version, strict=True)


def test_a_word_that_no_schema_knows_is_refused(objects):
    cluster = [each for each in objects if each["kind"] in ("DaskCluster", "ScaledObject")]
    for each in cluster:
        wrong = each | {"spec": each["spec"] | {"pods": 1}}
        assert not Draft202012Validator(schema_of(each["kind"])).is_valid(wrong)
    service = named(objects, "Deployment", "service")
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(service | {"spec": service["spec"] | {"copies": 1}}, VERSIONS[0], strict=True)


def test_every_pod_may_run_in_a_restricted_namespace(objects):
    namespace = named(objects, "Namespace", "gear-rattle")
    assert namespace["metadata"]["labels"]["pod-security.kubernetes.io/enforce"] == "restricted"
    for name, (_, pod) in pods(objects).items():
        outer = pod["securityContext"]
        assert outer["runAsNonRoot"] and outer["runAsUser"] > 0 and outer["runAsGroup"] > 0, name
        assert outer["seccompProfile"] == {"type": "RuntimeDefault"}
        assert pod["automountServiceAccountToken"] is False and pod["enableServiceLinks"] is False
        assert not {"hostNetwork", "hostPID", "hostIPC"} & pod.keys()
        assert all(volume.keys() & {"secret", "configMap", "emptyDir"} for volume in pod.get("volumes", []))
        for container in containers(pod):
            assert container["securityContext"] == {
                "allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]},
            }  # fmt: skip


def test_every_container_has_requests_limits_and_a_version(objects):
    for _, pod in pods(objects).values():
        for container in containers(pod):
            for bounds in (container["resources"]["requests"], container["resources"]["limits"]):
                assert bounds.keys() == {"cpu", "memory", "ephemeral-storage"}
            assert re.search(r":v?\d+\.\d+(\.\d+)?[-\w]*$", container["image"]), container["image"]


def test_our_image_runs_where_it_was_built_for(objects):
    for name, (_, pod) in pods(objects).items():
        if any(container["image"].startswith("gear-rattle:") for container in containers(pod)):
            assert pod["nodeSelector"] == {"kubernetes.io/arch": "amd64"}, name


def test_versions_are_the_projects_and_the_compose_files(deployed):
    version = tomllib.loads((DOCKER.parent / "pyproject.toml").read_text())["project"]["version"]
    images = {container["image"] for _, pod in pods(deployed).values() for container in containers(pod)}
    others = {part["image"] for part in COMPOSE.values() if part["image"] != "gear-rattle"}
    assert images == others | {f"gear-rattle:{version}"}


def test_what_runs_is_probed_where_something_answers(objects):
    answered = {"/healthz", "/health"}  # the service's route; Dask's, and the object store's (VGW_HEALTH)
    assert "/healthz" in {route.path for route in health.router.routes}
    for name, (_, pod) in pods(objects).items():
        if pod.get("restartPolicy") == "OnFailure":
            continue
        for container in pod["containers"]:
            ports = {port["name"] for port in container["ports"]}
            assert "livenessProbe" in container, name
            for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
                if get := container.get(probe, {}).get("httpGet"):
                    assert get["path"] in answered and get["port"] in ports, name


def test_settings_are_those_of_the_service_and_of_the_compose_file(deployed):
    settings = named(deployed, "ConfigMap", "service")["data"]
    known = {f"RATTLE_{name.upper()}" for name in Settings.model_fields}
    assert settings.keys() < known
    Settings(**{name.removeprefix("RATTLE_").lower(): value for name, value in settings.items()})
    cluster = named(deployed, "ConfigMap", "cluster")["data"]
    theirs = COMPOSE["scheduler"]["environment"]
    shared = {name: value for name, value in theirs.items() if name.startswith("DASK_") or name == "AWS_ENDPOINT_URL"}
    assert shared.items() <= cluster.items()
    assert named(deployed, "ConfigMap", "proxy")["data"]["nginx.conf"] == (DOCKER / "proxy/nginx.conf").read_text()


def test_secrets_are_in_secrets_alone(objects):
    """And each Secret, ConfigMap and claim that a pod names is there."""
    text = json.dumps([each for each in objects if each["kind"] != "Secret"])
    for secret in (each for each in objects if each["kind"] == "Secret"):
        for value in secret["data"].values():
            assert base64.b64decode(value).decode() not in text
    there = {(each["kind"], each["metadata"]["name"]) for each in objects}
    for reference in re.findall(r'"(configMapRef|configMap|secretRef|secretKeyRef)": {[^}]*"name": "([^"]+)"', text):
        assert ("ConfigMap" if reference[0].startswith("config") else "Secret", reference[1]) in there
    for name in re.findall(r'"secretName": "([^"]+)"', text):
        assert ("Secret", name) in there


def test_the_documented_lines_make_every_secret(tmp_path):
    text = (DOCKER.parent / "docs" / "operations" / "clusters.md").read_text()
    lines = re.search(r"umask 077\n(.*?)kubectl apply", text, re.DOTALL)[1]
    programs = f"PATH={Path(sys.executable).parent}:$PATH\n"

    def as_documented(root):
        subprocess.run(["bash", "-e", "-c", programs + lines], cwd=root, check=True, capture_output=True, timeout=60)

    objects = built(tmp_path, make_secrets=as_documented)
    made = {name: base64.b64decode(value) for kind in ("certificates", "site", "database", "objects")
            for name, value in named(objects, "Secret", kind)["data"].items()}  # fmt: skip
    for name in ("ca", "certificate", "site_certificate"):
        x509.load_pem_x509_certificate(made[name])
    assert made["key"] != made["site_key"] and made["DATABASE_PASSWORD"] != made["AWS_SECRET_ACCESS_KEY"]


def test_a_connection_that_one_end_may_open_the_other_may_take(objects):
    taken = {(client, server, port) for server, client, port in allowed(objects, "ingress")}
    assert taken == allowed(objects, "egress")
    nothing = named(objects, "NetworkPolicy", "nothing-else")["spec"]
    assert nothing == {"podSelector": {}, "policyTypes": ["Ingress", "Egress"]}
    opened = {labels["app.kubernetes.io/component"]: {port["containerPort"] for port in pod["containers"][0]["ports"]}
              for labels, pod in pods(objects).values() if "ports" in pod["containers"][0]}  # fmt: skip
    assert all(port in opened[server] for _, server, port in taken)


def test_workers_follow_metrics_that_the_service_has_and_are_counted_by_nobody_else(deployed):
    spec = named(deployed, "ScaledObject", "gear-rattle-worker")["spec"]
    queries = " ".join(trigger["metadata"]["query"] for trigger in spec["triggers"])
    told = (DOCKER.parent / "docs" / "operations" / "README.md").read_text()
    assert set(re.findall(r"rattle_\w+", queries)) == {"rattle_tiles_left", "rattle_jobs"}
    assert all(f"`{name}" in told for name in ("rattle_tiles_left", "rattle_jobs"))
    target = spec["scaleTargetRef"]
    assert "replicas" not in named(deployed, target["kind"], target["name"])["spec"]


def test_no_more_than_one_of_several_is_taken_away_at_a_time(deployed):
    """A budget for a single pod would keep its node from ever being emptied."""
    budgets = {each["metadata"]["name"] for each in deployed if each["kind"] == "PodDisruptionBudget"}
    assert budgets == {"service", "proxy", "gear-rattle-worker"}


def test_a_worker_has_longer_to_leave_than_its_nanny_takes(objects):
    assert pods(objects)["gear-rattle-worker"][1]["terminationGracePeriodSeconds"] > 10 + 30
