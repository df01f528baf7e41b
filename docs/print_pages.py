"""Puts figures into pages: python docs/print_pages.py

A figure in a page (README.md, docs, cases) stands between two marks, and the first says which function prints it:

    The chute lasts <!-- printed by cases/transfer_chute/lives.py: life -->68.5 +- 1.5 d<!-- end -->.

`life()` in that script takes no argument and returns Markdown: some words, or whole lines such as a table, whose marks then stand on lines
of their own. It only reads results that are stored beside it, as JSON, with the version that they were measured with; the scripts that
take minutes or hours write these. So a new measurement is: run the script, run this one, commit the results and the pages together.

tests/regression/test_pages.py fails where a page says anything else than its results.
"""

import re
import runpy
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"(<!-- printed by (\S+): (\w+) -->)(.*?)(<!-- end -->)", re.DOTALL)


def pages() -> list[Path]:
    """The pages that hold printed figures."""
    found = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("cases/*/*.md")]
    return [page for page in sorted(found) if "<!-- printed by " in page.read_text(encoding="utf-8")]


def printed(page: str) -> str:
    """The text of a page with its figures as the stored results have them now."""

    def anew(block: re.Match[str]) -> str:
        begin, script, function, old, end = block.groups()
        words = names_of(script)[function]().strip("\n")
        return f"{begin}\n{words}\n{end}" if old.startswith("\n") else f"{begin}{words}{end}"

    return BLOCK.sub(anew, page)


@cache
def names_of(script: str) -> dict[str, Any]:
    """What a script defines, without its main."""
    return runpy.run_path(str(ROOT / script), run_name=Path(script).stem)


def main() -> None:
    """Write what has changed."""
    for page in pages():
        old = page.read_text(encoding="utf-8")
        new = printed(old)
        if new != old:
            page.write_text(new, encoding="utf-8")
        print(f"{page.relative_to(ROOT)}: {'written' if new != old else 'as it was'}")


if __name__ == "__main__":
    main()
