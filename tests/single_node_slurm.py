"""A Slurm of one node that lives in a folder: its daemons start with a test and end with it.

Without accounting, without cgroups: jobs are told apart by their process trees.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "srun")
CONF = """\
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
MpiDefault=none
ReturnToService=2
MinJobAge=300
SlurmdParameters=config_overrides
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=20000 State=UNKNOWN
PartitionName=main Nodes={host} Default=YES State=UP
"""


def missing() -> str:
    """Why no Slurm can be started here; empty when one can."""
    absent = [name for name in NEEDED if shutil.which(name, path=_path()) is None]
    if absent:
        return f"no {', '.join(absent)}: apt-get install slurm-wlm munge"
    return "" if os.geteuid() == 0 else "the daemons of Slurm need root"


@contextmanager
def running(folder: Path) -> Iterator[dict[str, str]]:
    """Start munged, slurmctld and slurmd in an empty folder.

    Yields:
        The environment in which Slurm's commands find it.

    Raises:
        RuntimeError: when the node is not idle within a minute; what the daemons logged.
    """
    for name in ("state", "spool"):
        (folder / name).mkdir()
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o400)
    conf = folder / "slurm.conf"
    conf.write_text(
        CONF.format(folder=folder, host=socket.gethostname(), controller=_port(), node=_port())
    )
    path = f"{_wrapped(folder, 'srun', conf)}:{_path()}"
    environment = {**os.environ, "SLURM_CONF": str(conf), "PATH": path}
    with ExitStack() as stack:
        munged = ["munged", "--foreground", "--force", f"--key-file={key}"]
        munged += [f"--{kind}-file={folder}/munge.{kind}" for kind in ("pid", "seed", "log")]
        _daemon(stack, [*munged, f"--socket={folder}/munge.socket"], environment)
        _until(lambda: (folder / "munge.socket").exists(), folder)
        _daemon(stack, ["slurmctld", "-D", "-f", str(conf)], environment)
        _daemon(stack, ["slurmd", "-D", "-f", str(conf)], environment)
        _until(lambda: "idle" in ask(environment, "sinfo", "-h", "-o", "%T"), folder)
        stack.callback(_cancel_all, environment)
        yield environment


def ask(environment: dict[str, str], *command: str) -> str:
    """What a command of Slurm's prints."""
    return subprocess.run(command, env=environment, capture_output=True, text=True).stdout


def _wrapped(folder: Path, command: str, conf: Path) -> Path:
    """A folder with a command that knows its slurm.conf: Snakemake's jobs drop SLURM_CONF."""
    wrapper = folder / "bin" / command
    wrapper.parent.mkdir()
    program = shutil.which(command, path=_path())
    wrapper.write_text(f'#!/bin/sh\nSLURM_CONF={conf} exec {program} "$@"\n')
    wrapper.chmod(0o755)
    return wrapper.parent


def _path() -> str:
    return f"{os.environ['PATH']}:/usr/sbin:/sbin"


def _port() -> int:
    with closing(socket.socket()) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _daemon(stack: ExitStack, command: list[str], environment: dict[str, str]) -> None:
    process = subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )

    def end() -> None:
        process.terminate()
        process.wait()

    stack.callback(end)


def _cancel_all(environment: dict[str, str]) -> None:
    ask(environment, "scancel", "--me")
    deadline = time.monotonic() + 60
    while ask(environment, "squeue", "-h") and time.monotonic() < deadline:
        time.sleep(0.5)


def _until(holds, folder: Path) -> None:
    deadline = time.monotonic() + 60
    while not holds():
        if time.monotonic() > deadline:
            logs = [path.read_text()[-2000:] for path in folder.glob("*.log")]
            raise RuntimeError("Slurm did not start:\n" + "\n".join(logs))
        time.sleep(0.2)
