"""Parts of the compose file: commands, environments and checks, as an engine would read them."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import yaml

_FILE = Path(__file__).parents[2] / "docker" / "compose.yaml"
_VARIABLE = re.compile(r"\$\{(\w+)(?::([-?])([^}]*))?\}")


@dataclass(frozen=True)
class Part:
    """One container."""

    host: str
    command: list
    environment: dict
    restarts: bool
    check: list


def _filled(value, variables):
    """A value with the variables that it names."""
    if isinstance(value, list):
        return [_filled(each, variables) for each in value]

    def fill(found):
        name, kind, other = found.groups()
        if variables.get(name):
            return variables[name]
        assert kind == "-", f"{name} is not set: {other}"
        return other

    return _VARIABLE.sub(fill, str(value))


def parts_of_compose_file(variables):
    """Parts that run the project's own image, replicas each by its own name."""
    services = yaml.safe_load(_FILE.read_text())["services"]
    parts = []
    for name, service in services.items():
        if service["image"] != "gear-rattle":
            continue
        replicas = service.get("deploy", {}).get("replicas", 1)
        command = _filled(service["command"], variables)
        for number in range(1, replicas + 1):
            host = name if replicas == 1 else f"{name}-{number}"
            parts.append(
                Part(
                    host,
                    command if isinstance(command, list) else shlex.split(command),
                    {key: _filled(value, variables) for key, value in service["environment"].items()},
                    service["restart"] == "always",
                    _filled(service["healthcheck"]["test"], variables)[1:],
                )
            )
    return parts
