"""Draw docs/pictures/transfer_chute.png, the chute at the end of its life: python docs/make_chute.py [RUN]

With RUN, the folder of a finished `./dev run cases/transfer_chute`, from that; else the case is run first, some minutes.
"""

import sys
import tempfile
from pathlib import Path

from wearfem.case import load_any_case
from wearfem.errors import in_a_sentence
from wearfem.history import read_history
from wearfem.run import run_case

CASE = Path(__file__).parents[1] / "cases" / "transfer_chute"
TARGET = Path(__file__).parent / "pictures" / "transfer_chute.png"


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        run = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(folder) / "run"
        if len(sys.argv) < 2:
            run_case(CASE, {}, run)
        load_any_case(CASE).draw(read_history(run), Path(folder))
        TARGET.write_bytes((Path(folder) / "chute.png").read_bytes())
    print(f"wrote {TARGET}")


if __name__ == "__main__":
    with in_a_sentence(__file__):
        main()
