"""Parts of the Kubernetes manifests: commands, environments and probes, as a kubelet would read them."""

import base64
import re

from tests.hosts.compose import Part
from tests.kubernetes.manifests import named, pods

# Host by host: a Service's name where others ask for it, a pod's where they do not.
_HOSTS = {"gear-rattle-scheduler": ["gear-rattle-scheduler"], "service": ["service"],
          "gear-rattle-worker": ["worker-1", "worker-2"]}  # fmt: skip


def parts_of_manifests(objects):
    """The first pod of service and scheduler, and two of the workers."""
    parts = []
    for name, hosts in _HOSTS.items():
        container = pods(objects)[name][1]["containers"][0]
        environment = environment_of(container, objects)
        command = [_expanded(word, environment) for word in container["args"]]
        parts += [Part(host, command, environment, True, probe_of(container)) for host in hosts]
    return parts


def environment_of(container, objects):
    """Variables of a container: of ConfigMaps and Secrets, and its own."""
    environment = {}
    for source in container.get("envFrom", []):
        if "configMapRef" in source:
            environment |= _data_of(objects, "ConfigMap", source["configMapRef"]["name"])
        else:
            environment |= _data_of(objects, "Secret", source["secretRef"]["name"])
    for variable in container.get("env", []):
        if "value" in variable:
            environment[variable["name"]] = _expanded(variable["value"], environment)
        else:
            reference = variable["valueFrom"]["secretKeyRef"]
            environment[variable["name"]] = _data_of(objects, "Secret", reference["name"])[reference["key"]]
    return environment


def probe_of(container):
    """A command that succeeds in silence where the liveness probe would."""
    get = container["livenessProbe"]["httpGet"]
    port = next(port["containerPort"] for port in container["ports"] if port["name"] == get["port"])
    return ["curl", "--silent", "--fail", "--output", "/dev/null", f"http://127.0.0.1:{port}{get['path']}"]


def _data_of(objects, kind, name):
    data = named(objects, kind, name.rpartition("-")[0])["data"]
    return data if kind == "ConfigMap" else {key: base64.b64decode(value).decode() for key, value in data.items()}


def _expanded(text, environment):
    """A text with the variables that it names as $(NAME)."""
    return re.sub(r"\$\((\w+)\)", lambda found: environment[found[1]], text)
