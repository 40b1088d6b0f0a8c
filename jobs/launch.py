"""Starts the program on some ranks, as jobs/common.sh does."""
import os

if os.geteuid() == 0:
    os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")


def on_ranks(ranks, *words):
    """The command as a list."""
    return ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", *map(str, words)]
