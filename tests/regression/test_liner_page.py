"""The script of docs/liner.md runs, and the page shows the script as it is and the numbers that it prints."""

import importlib.util
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_the_page_shows_what_the_script_prints(tmp_path, capsys):
    module(DOCS / "examples" / "liner.py").main(tmp_path, time_limit=0.0)
    printed = capsys.readouterr().out.replace("\n\n", "\n").lstrip("\n")
    page = (DOCS / "liner.md").read_text()
    shown = re.search(r"<!-- printed -->\n```\n(.*?)```\n<!-- end -->", page, re.S)[1]
    number = r"\d+(?:\.\d+)?"
    assert re.sub(number, "#", shown) == re.sub(number, "#", printed), "python docs/make_liner.py"
    found, told = ([float(x) for x in re.findall(number, text)] for text in (printed, shown))
    assert found == pytest.approx(
        told, rel=0.02
    )  # numbers are rounded to two digits and more, machines round differently
    filled = module(DOCS / "make_liner.py").filled
    assert filled(page, shown) == page, "the script has changed: python docs/make_liner.py"
    names = printed.splitlines()[-1].removeprefix("files: ").split()
    assert len(names) == 8 and all((tmp_path / name).is_file() for name in names)
