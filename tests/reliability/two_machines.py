"""One scene over two machines that share no memory: MPI between two network namespaces of this machine, by TCP alone. The same bits as on one rank.

    python tests/reliability/two_machines.py --quoin build/quoin [--columns 48]

Prints what goes over the wire a cycle, for several sizes of the model. Exit code 1: other bits, or no end; 77: no namespaces can be made here (root and the command ip are needed)."""

import argparse
import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml
from run import ENVIRONMENT

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.dam import G1, dam_mesh  # noqa: E402

SKIPPED = 77  # as CTest has it
NET = "10.213.77"
NAMES = [f"quoin{os.getpid() % 10000}{end}" for end in "ab"]

SCENE = {
    "relaxation": {"tolerance": 1e-5, "max_cycles": 600, "method": "explicit"},
    "materials": {"dam": {"density": 2400, "young": 10e9, "poisson": 0.2}, "rock": {"density": 2500, "young": 10e9, "poisson": 0.2}},
    "joints": {"base": {"k_n": 10e9, "k_s": 3e9, "friction": 45}, "default": {"law": "elastic", "k_n": 10e9, "k_s": 3e9}},
    "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 33}},
    "stages": [{"full": {"loads": ["weight", "water"]}}],
}


def ip(*words):
    return subprocess.run(["ip", *words], capture_output=True, text=True, check=True).stdout


@contextlib.contextmanager
def machines():
    """Two namespaces with a cable between them; CalledProcessError where they cannot be made."""
    try:
        for name in NAMES:
            ip("netns", "add", name)
        ip("link", "add", "va", "netns", NAMES[0], "type", "veth", "peer", "name", "vb", "netns", NAMES[1])
        for k, (name, end) in enumerate(zip(NAMES, ("va", "vb"))):
            ip("-n", name, "addr", "add", f"{NET}.{k + 1}/24", "dev", end)
            for link in ("lo", end):
                ip("-n", name, "link", "set", link, "up")
        yield
    finally:
        for name in NAMES:
            subprocess.run(["ip", "netns", "del", name], capture_output=True)


def sent():
    """(bytes, packets) that the first machine has sent."""
    lines = ip("-n", NAMES[0], "-s", "link", "show", "va").split("\n")
    at = next(k for k, line in enumerate(lines) if line.strip().startswith("TX:"))
    return np.array([int(word) for word in lines[at + 1].split()[:2]])


def over_the_wire(quoin, folder, output):
    """A run on two ranks, one a machine; the process that starts the second one enters its namespace instead of logging in."""
    enter = folder / "enter.sh"
    enter.write_text(f'#!/bin/bash\nshift\nexec ip netns exec {NAMES[1]} bash -c "$*"\n')
    enter.chmod(0o755)
    mca = [word for key, value in (("plm_rsh_agent", enter), ("btl", "tcp,self"), ("btl_tcp_if_include", f"{NET}.0/24"), ("oob_tcp_if_include", f"{NET}.0/24")) for word in ("--mca", key, str(value))]
    command = ["ip", "netns", "exec", NAMES[0], "mpirun", "-n", "2", "--host", f"{NET}.1:1,{NET}.2:1", *mca, quoin, "-options_file", "scene.yaml", "-output", output]
    environment = {key: value for key, value in (os.environ | ENVIRONMENT).items() if not key.startswith(("OMPI_MCA_ess", "OMPI_MCA_btl", "OMPI_MCA_plm"))}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=280, env=environment)


def compared(quoin, folder, columns):
    """Line of the table, and whether the bits are the same."""
    mesh = dam_mesh(G1, columns)
    write(str(folder / "model.h5"), mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5"} | SCENE, sort_keys=False))
    alone = subprocess.run([quoin, "-options_file", "scene.yaml", "-output", "one"], cwd=folder, capture_output=True, text=True, env=os.environ | ENVIRONMENT)
    before = sent()
    done = over_the_wire(quoin, folder, "two")
    if done.returncode != alone.returncode:
        return f"{columns} columns: exit code {done.returncode}, on one rank {alone.returncode}\n{done.stdout[-1500:]}{done.stderr[-3000:]}", False
    stages = [Results(folder / name).summary["stages"][0] for name in ("one", "two")]
    size, packets = (sent() - before) / stages[1]["cycles"]
    same = stages[0]["checksum"] == stages[1]["checksum"]
    return f"{len(mesh.blocks):6} blocks: {size:7.0f} bytes and {packets:4.1f} packets a cycle each way, {'the same bits' if same else 'OTHER BITS'}", same


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    parser.add_argument("--columns", type=int, nargs="+", default=[12, 24])
    given = parser.parse_args()
    if os.geteuid() != 0 or not shutil.which("ip"):
        print("skipped: it needs root and the command ip (Debian: iproute2)")
        return SKIPPED
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(machines())
        except subprocess.CalledProcessError as error:
            print(f"skipped: no network namespaces here: {error.stderr.strip()}")
            return SKIPPED
        good = True
        for columns in given.columns:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            line, same = compared(str(Path(given.quoin).resolve()), Path(folder), columns)
            print(line, flush=True)
            good = good and same
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
