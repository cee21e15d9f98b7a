"""The objects that `kubectl apply --kustomize docker/kubernetes` would send, built by kubectl, offline."""

import shutil
import subprocess
import sys
from pathlib import Path

import yaml

DOCKER = Path(__file__).parents[2] / "docker"
KUBECTL = Path(sys.executable).parent / "kubectl"
COMPONENTS = ("storage", "workers", "autoscaling")
WITH_OPERATOR = ("storage", "operator")
PASSWORDS = {"database": {"DATABASE_PASSWORD": "secret-1"},
             "objects": {"AWS_ACCESS_KEY_ID": "access-1", "AWS_SECRET_ACCESS_KEY": "secret-2"}}  # fmt: skip


def make_up_secrets(root):
    """What `docker/kubernetes/secrets` holds; the tests know the passwords."""
    secrets = root / "secrets"
    secrets.mkdir()
    for name in ("ca.pem", "rattle.pem", "rattle-key.pem", "site.pem", "site-key.pem"):
        (secrets / name).write_text("made up\n")
    for name, variables in PASSWORDS.items():
        (secrets / f"{name}.env").write_text("".join(f"{key}={value}\n" for key, value in variables.items()))


def built(folder, components=COMPONENTS, make_secrets=make_up_secrets):
    """Objects of a deployment of these components; `folder` is for a copy, to which `make_secrets` adds."""
    for name in ("kubernetes", "proxy"):
        shutil.copytree(DOCKER / name, folder / name, ignore=shutil.ignore_patterns("secrets"))
    root = folder / "kubernetes"
    kustomization = yaml.safe_load((root / "kustomization.yaml").read_text())
    (root / "kustomization.yaml").write_text(yaml.safe_dump(kustomization | {"components": list(components)}))
    make_secrets(root)
    answer = subprocess.run([KUBECTL, "kustomize", root], capture_output=True, text=True, timeout=60)
    assert (answer.returncode, answer.stderr) == (0, "")
    return [each for each in yaml.safe_load_all(answer.stdout) if each]


def named(objects, kind, name):
    """The object of a kind and a name; names of ConfigMaps and Secrets end in a hash of what they hold."""
    found = [each for each in objects if each["kind"] == kind and
             (each["metadata"]["name"] == name or kind in ("ConfigMap", "Secret")
              and each["metadata"]["name"].rpartition("-")[0] == name)]  # fmt: skip
    assert len(found) == 1, f"{kind} {name}: {len(found)}"
    return found[0]


def pods(objects):
    """Labels and specification of the pods of each Deployment, StatefulSet, Job and DaskCluster, by name."""
    found = {}
    for each in objects:
        name, spec = each["metadata"]["name"], each.get("spec", {})
        if each["kind"] in ("Deployment", "StatefulSet", "Job"):
            found[name] = spec["template"]["metadata"]["labels"], spec["template"]["spec"]
        if each["kind"] == "DaskCluster":
            for part in ("scheduler", "worker"):
                found[f"{name}-{part}"] = spec[part]["metadata"]["labels"], spec[part]["spec"]
    return found


def containers(pod):
    """All containers of a pod's specification, those that run before the others too."""
    return [*pod.get("initContainers", []), *pod["containers"]]
