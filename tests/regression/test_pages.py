"""Figures in pages are those of the stored results: docs/print_pages.py."""

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PRINTING = runpy.run_path(str(ROOT / "docs" / "print_pages.py"), run_name="print_pages")
PAGES = PRINTING["pages"]()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_says_what_its_results_say(page):
    text = page.read_text(encoding="utf-8")
    assert PRINTING["printed"](text) == text, "run: python docs/print_pages.py"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_block_is_closed_and_has_figures(page):
    """A lost end mark would swallow the text up to the next one."""
    text = page.read_text(encoding="utf-8")
    blocks = PRINTING["BLOCK"].findall(text)
    assert text.count("<!-- printed by") == text.count("<!-- end -->") == len(blocks)
    for _, script, function, words, _ in blocks:
        assert "<!--" not in words, f"{script}: {function} is not closed"
        assert re.search(r"\d", words), f"{script}: {function} prints no figure"


def test_a_figure_that_was_typed_over_is_seen():
    """In every block of every page."""
    for page in PAGES:
        for _, script, function, words, _ in PRINTING["BLOCK"].findall(page.read_text(encoding="utf-8")):
            typed = re.sub(r"\d", lambda digit: str((int(digit[0]) + 1) % 10), words, count=1)
            block = f"<!-- printed by {script}: {function} -->{{}}<!-- end -->"
            assert PRINTING["printed"](block.format(typed)) == block.format(words) != block.format(typed)
