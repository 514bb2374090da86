"""Finds the solver, starts it on some ranks, and ends it with the process that started it."""

import contextlib
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[3]
RANK = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}  # set in the ranks of a job
LAUNCHED = ("OMPI_", "PMIX_", "PMI_", "PRTE_")  # variables that launchers set for their ranks


class SolverError(ValueError):
    """The solver cannot be started; the message is one line."""


def find():
    """Finds the solver: QUOIN_SOLVER, else the one of this checkout, else `quoin-solver` on the PATH."""
    named = os.environ.get("QUOIN_SOLVER")
    if named:
        if not os.access(named, os.X_OK):
            raise SolverError(f"QUOIN_SOLVER: {named}: no program there")
        return os.path.abspath(named)
    built = CHECKOUT / "build/quoin"
    found = str(built) if os.access(built, os.X_OK) else shutil.which("quoin-solver")
    if found is None:
        raise SolverError("the solver is not installed: build it and run `cmake --install build`, which makes quoin-solver, or let QUOIN_SOLVER name it")
    return found


def command(words, ranks=1):
    """Returns the command of the solver on some ranks; QUOIN_MPIRUN: another launcher, such as srun."""
    if ranks == 1:
        return [find(), *words]
    launcher = shlex.split(os.environ.get("QUOIN_MPIRUN", "mpirun"))
    if not launcher or shutil.which(launcher[0]) is None:
        raise SolverError(f"{' '.join(launcher) or 'QUOIN_MPIRUN'}: no such program, and {ranks} ranks need it")
    quiet = ["-q"] if is_open_mpi(launcher) else []  # the solver says why it ends; Open MPI would add a dozen lines
    return [*launcher, *quiet, "-n", str(ranks), find(), *words]


def is_open_mpi(launcher):
    version = subprocess.run([*launcher, "--version"], capture_output=True, text=True, check=False).stdout
    return "Open MPI" in version or "OpenRTE" in version


def environment(ranks=1):
    """Returns the environment of the solver's processes. Variables that the user has set stay."""
    wanted = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # the ranks are the threads
    if ranks > 1:
        wanted["OMPI_MCA_rmaps_base_oversubscribe"] = "1"  # more ranks than cores are allowed
        if os.geteuid() == 0:
            wanted |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        if not memory_copy_works():
            wanted["OMPI_MCA_btl_vader_single_copy_mechanism"] = "none"
    return wanted | os.environ


def environment_of_one():
    """Returns the environment of a solver that is no part of the MPI job to which this process may belong."""
    if not RANK & set(os.environ):
        return environment()
    return {name: value for name, value in environment().items() if not name.startswith(LAUNCHED)} | {"OMPI_MCA_ess_singleton_isolated": "1"}


class Ended(BaseException):
    """A signal that ends this process, once it has ended its solvers."""


RUNNING: set[subprocess.Popen] = set()  # solvers that this process has started and that have not ended
ENDING = threading.Event()  # a signal ends this process: no solver is started any more
PATIENCE = 10  # s: a solver that receives SIGTERM writes a checkpoint


def start(words, **options):
    """Starts the solver or mpirun (Popen), which end when this process ends in any way (setpriv, of Debian's util-linux). Call `ended` when it has ended."""
    if ENDING.is_set():
        raise SolverError("a signal ends this process")
    setpriv = shutil.which("setpriv")
    process = subprocess.Popen([setpriv, "--pdeathsig", "TERM", "--", *words] if setpriv else words, **options)
    RUNNING.add(process)
    if ENDING.is_set():  # the signal came while it started, so that end_all may have missed it
        process.terminate()
    return process


def ended(process):
    RUNNING.discard(process)


def end_all():
    """Sends SIGTERM to all running solvers; mpirun hands it on to its ranks."""
    ENDING.set()
    for process in list(RUNNING):
        with contextlib.suppress(OSError):
            os.kill(process.pid, signal.SIGTERM)


def run(words, time_limit=None, running=None, **options):
    """Runs a command as subprocess.run does, in text mode. An exception that leaves it, also of a signal's handler, leaves no solver running. running: set that has the process as long as it runs, so that another thread may end it."""
    running = set() if running is None else running
    with stopping(), start(words, text=True, **options) as process:
        running.add(process)
        try:
            out, error = process.communicate(timeout=time_limit)
        except BaseException:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)
            process.kill()
            raise
        finally:
            running.discard(process)
            ended(process)
    return subprocess.CompletedProcess(words, process.returncode, out, error)


@contextlib.contextmanager
def stopping():
    """Lets SIGTERM and SIGHUP, where nobody else handles or ignores them, end all solvers before they end this process."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def on_signal(number, _frame):
        raise Ended(number)

    wanted = [n for n in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(n) is signal.SIG_DFL]
    for number in wanted:
        signal.signal(number, on_signal)
    try:
        yield
    except Ended as end:
        end_all()
        signal.signal(end.args[0], signal.SIG_DFL)
        os.kill(os.getpid(), end.args[0])
    finally:
        for number in wanted:
            signal.signal(number, signal.SIG_DFL)


def memory_copy_works():
    """Tells whether one process may read another's memory. Containers often refuse it, and Open MPI's shared memory relies on it."""
    import ctypes

    class Part(ctypes.Structure):
        _fields_ = (("base", ctypes.c_void_p), ("size", ctypes.c_size_t))

    buffer = ctypes.create_string_buffer(8)
    part = ctypes.byref(Part(ctypes.addressof(buffer), 8))
    child = os.fork()
    if child == 0:
        signal.pause()
    try:
        copied = ctypes.CDLL(None).process_vm_readv(child, part, 1, part, 1, 0)
    except AttributeError:
        copied = 8
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return copied == 8


def settled(scene, words=(), program=None):
    """Text of a scene with every key in force as the solver understands it: units, defaults, the words of the command line. SolverError: its line about what is wrong. The solver sets up
    what it would run and prints the scene."""
    done = run([program or find(), "-options_file", os.fspath(scene), *words, "-echo"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", env=environment_of_one())
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        raise SolverError(lines[-1] if lines else f"{scene}: the solver ended with code {done.returncode} and said nothing")
    return done.stdout


def become(words, ranks=1):
    """Replaces this process by the solver: output, signals and exit code are its own."""
    started = command(words, ranks)
    sys.stdout.flush()
    os.execvpe(started[0], started, environment(ranks))  # noqa: S606
