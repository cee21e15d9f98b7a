"""The image, built and run without an engine: buildah in a chroot, podman with runc. Takes root and some minutes."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_BASE = "docker.io/library/debian:bookworm-slim"
_TOOLS = ("buildah", "podman", "runc", "debootstrap")


@dataclass
class Engine:
    """Images of these tests, and the programs that build and run them."""

    folder: Path

    def call(self, program, *arguments, **options):
        """Output of a program on these images."""
        command = [program, "--root", self.folder / "images", "--runroot", self.folder / "run", *arguments]
        environment = os.environ | {"STORAGE_DRIVER": "vfs", "BUILDAH_ISOLATION": "chroot"}
        answer = subprocess.run(command, env=environment, capture_output=True, text=True, **options)
        assert answer.returncode == 0, answer.stdout[-4000:] + answer.stderr[-4000:]
        return answer.stdout.strip()

    def podman(self, *arguments, **options):
        """Output of podman."""
        return self.call("podman", "--cgroup-manager", "cgroupfs", "--runtime", "runc", *arguments, **options)

    def run(self, name, *arguments):
        """Run a container of the image as the compose file has it: read-only, without capabilities."""
        confined = "--read-only --cap-drop all --security-opt no-new-privileges --network host --memory 3g".split()
        # A sandbox may forbid to raise limits.
        limits = "--ulimit nofile=4096:4096 --ulimit nproc=2048:2048 --tmpfs /tmp:rw,size=256m".split()
        return self.podman("run", "--name", name, *confined, *limits, *arguments, timeout=300)


def _make_base(engine):
    """Base image as debootstrap makes it, under the name of the one that the Dockerfile asks for."""
    root = engine.folder / "base"
    command = ["debootstrap", "--variant=minbase", "bookworm", root]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=900)
    for waste in ("var/cache/apt/archives", "var/lib/apt/lists"):
        shutil.rmtree(root / waste)
        (root / waste).mkdir()
    container = engine.call("buildah", "from", "scratch")
    engine.call("buildah", "add", "--quiet", container, root, "/")
    engine.call("buildah", "commit", "--quiet", container, _BASE)
    engine.call("buildah", "rm", container)
    shutil.rmtree(root)


def _fetch_wheels(engine):
    """Packages of the image, fetched here: the build reaches no index, and needs no host's settings."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--require-hashes"]
    lock = ["--only-binary=:all:", "--requirement", ROOT / "requirements" / "image.txt", "--dest", engine.folder / "w"]
    subprocess.run(command + lock, check=True, timeout=600)
    (engine.folder / "pip.conf").write_text("[global]\nno-index = true\nfind-links = /wheels\n")


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Where images lie while these tests run."""
    folder = tmp_path_factory.mktemp("containers")
    yield folder
    # Podman mounts its storage onto itself: left mounted, it could be removed neither here nor by later runs.
    mounted = [line.split()[1] for line in Path("/proc/mounts").read_text().splitlines()]
    for place in sorted((each for each in mounted if each.startswith(str(folder))), reverse=True):
        subprocess.run(["umount", "--lazy", place], check=False)
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def engine(folder):
    """The image, tagged gear-rattle."""
    missing = [tool for tool in _TOOLS if shutil.which(tool) is None]
    if os.geteuid() != 0 or missing:
        pytest.fail(f"building an image takes root and {', '.join(missing) or 'nothing more'}")
    engine = Engine(folder)
    _make_base(engine)
    _fetch_wheels(engine)
    engine.call(
        "buildah", "bud", "--pull-never", "--format", "docker", "--secret", f"id=pip,src={engine.folder}/pip.conf",
        "--volume", f"{engine.folder}/w:/wheels:ro", "--file", ROOT / "docker" / "Dockerfile", "--tag", "gear-rattle",
        ROOT, timeout=3600,
    )  # fmt: skip
    return engine
