"""A Slurm of one node that lives in a folder: its daemons start with a test and end with it.

Without cgroups: jobs are told apart by their process trees. With accounting where that is asked
for, by a database of its own.
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
NEEDED_TO_ACCOUNT = ("slurmdbd", "sacctmgr", "mariadbd", "mariadb", "mariadb-install-db")
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
{accounting}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=20000 State=UNKNOWN
PartitionName=main Nodes={host} Default=YES State=UP
"""
NO_ACCOUNTING = """\
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none"""
ACCOUNTING = """\
JobAcctGatherType=jobacct_gather/linux
AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=127.0.0.1
AccountingStoragePort={keeper}
AccountingStoragePass={folder}/munge.socket"""
DBD_CONF = """\
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
DbdHost=localhost
DbdPort={keeper}
SlurmUser=root
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort={database}
StorageUser=slurm
StoragePass=slurm
StorageLoc=accounting
LogFile={folder}/slurmdbd.log
PidFile={folder}/slurmdbd.pid
"""


def missing(accounting: bool = False) -> str:
    """Why no Slurm can be started here; empty when one can."""
    needed = (*NEEDED, *(NEEDED_TO_ACCOUNT if accounting else ()))
    absent = [name for name in needed if shutil.which(name, path=_path()) is None]
    if absent:
        packages = "slurm-wlm munge" + (" slurmdbd mariadb-server" if accounting else "")
        return f"no {', '.join(absent)}: apt-get install {packages}"
    return "" if os.geteuid() == 0 else "the daemons of Slurm need root"


@contextmanager
def running(folder: Path, accounting: bool = False) -> Iterator[dict[str, str]]:
    """Start munged, slurmctld and slurmd in an empty folder; mariadbd and slurmdbd to account.

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
    keeper = _port()
    ports = {"controller": _port(), "node": _port()}
    kept = ACCOUNTING.format(folder=folder, keeper=keeper) if accounting else NO_ACCOUNTING
    conf.write_text(CONF.format(folder=folder, host=socket.gethostname(), accounting=kept, **ports))
    path = f"{_wrapped(folder, 'srun', conf)}:{_path()}"
    environment = {**os.environ, "SLURM_CONF": str(conf), "PATH": path}
    with ExitStack() as stack:
        munged = ["munged", "--foreground", "--force", f"--key-file={key}"]
        munged += [f"--{kind}-file={folder}/munge.{kind}" for kind in ("pid", "seed", "log")]
        _daemon(stack, [*munged, f"--socket={folder}/munge.socket"], environment)
        _until(lambda: (folder / "munge.socket").exists(), folder)
        if accounting:
            _keep_accounts(stack, folder, keeper, environment)
        _daemon(stack, ["slurmctld", "-D", "-f", str(conf)], environment)
        _daemon(stack, ["slurmd", "-D", "-f", str(conf)], environment)
        _until(lambda: "idle" in ask(environment, "sinfo", "-h", "-o", "%T"), folder)
        stack.callback(_cancel_all, environment)
        yield environment


def _keep_accounts(
    stack: ExitStack, folder: Path, keeper: int, environment: dict[str, str]
) -> None:
    """Start a database and slurmdbd, which has an account for root from the start."""
    data, database, client = folder / "data", _port(), folder / "database.socket"
    made = ["mariadb-install-db", f"--datadir={data}", "--user=root", "--skip-test-db"]
    subprocess.run(made, env=environment, check=True, capture_output=True)
    server = ["mariadbd", "--no-defaults", "--user=root", f"--datadir={data}"]
    server += [f"--socket={client}", f"--port={database}", "--bind-address=127.0.0.1"]
    _daemon(stack, [*server, f"--log-error={folder}/mariadbd.log"], environment)
    _until(client.exists, folder)
    grant = "CREATE USER slurm@'%' IDENTIFIED BY 'slurm'; GRANT ALL ON accounting.* TO slurm@'%'"
    told = ["mariadb", "--no-defaults", f"--socket={client}", "--execute", grant]
    subprocess.run(told, env=environment, check=True, capture_output=True)
    conf = folder / "slurmdbd.conf"  # found beside slurm.conf
    conf.write_text(DBD_CONF.format(folder=folder, keeper=keeper, database=database))
    conf.chmod(0o600)
    _daemon(stack, ["slurmdbd", "-D"], environment)

    def added() -> bool:
        ask(environment, "sacctmgr", "--immediate", "add", "cluster", "one")
        return "one" in ask(environment, "sacctmgr", "--noheader", "list", "cluster")

    _until(added, folder)


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
