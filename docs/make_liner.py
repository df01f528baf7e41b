"""Run docs/examples/liner.py and put what it is, prints and draws into docs/liner.md and docs/pictures: python docs/make_liner.py"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent
SCRIPT = DOCS / "examples" / "liner.py"
PICTURES = ("thickness", "stress", "deflection")


def between(page: str, name: str, text: str) -> str:
    """The page with `text` between its marks `<!-- name -->` and `<!-- end -->`."""
    return re.sub(
        rf"(<!-- {name} -->\n).*?(<!-- end -->)", lambda found: found[1] + text + found[2], page, flags=re.S
    )


def filled(page: str, printed: str) -> str:
    """The page with the script, and what it printed."""
    page = between(page, "script", f"```python\n{SCRIPT.read_text()}```\n")
    return between(page, "printed", f"```\n{printed}```\n")


def main() -> None:
    page = DOCS / "liner.md"
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, str(SCRIPT), folder], capture_output=True, text=True, check=True
        )
        print(done.stderr, end="", file=sys.stderr)
        for name in PICTURES:
            (DOCS / "pictures" / f"liner_{name}.png").write_bytes((Path(folder) / f"{name}.png").read_bytes())
    page.write_text(filled(page.read_text(), done.stdout.replace("\n\n", "\n").lstrip("\n")))
    print(f"wrote {page}")


if __name__ == "__main__":
    main()
