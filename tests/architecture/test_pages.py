"""What pages point at exists, and the commands that they show can be typed."""

import re
import shlex
from pathlib import Path

import pytest

from wearfem.cli import wearfem
from wearfem.settings import parse_settings

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    {*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("cases/*/*.md"), *ROOT.glob("meshes/*.md")}
)
COMMAND = re.compile(r"^(?:    )?(?:\./dev|wearfem) ((?:[^\n]|(?<=\\)\n)+)", re.MULTILINE)


def where(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def commands_of(page: Path) -> list[str]:
    """The lines of a page's blocks that begin with ./dev or wearfem, without what follows two blanks or more."""
    text = page.read_text(encoding="utf-8")
    blocks = "\n".join(
        re.findall(r"^```\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
        + re.findall(r"(?:^    .*\n)+", text, re.MULTILINE)
    )
    found = [re.split(r" {2,}|\s+#", re.sub(r"\\\n\s*", "", line))[0] for line in COMMAND.findall(blocks)]
    return [line for line in found if not re.match(r"(test|lint)\b|[A-Z]", line)]


def test_there_are_commands_to_hold():
    assert sum(len(commands_of(page)) for page in PAGES) > 30


@pytest.mark.parametrize("page", PAGES, ids=where)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", target):
            assert (page.parent / target).exists(), f"{where(page)} points at {target}"


@pytest.mark.parametrize("page", PAGES, ids=where)
def test_commands_can_be_typed(page):
    """Every word and option is known, every setting can be read, and what is shipped is there."""
    for line in commands_of(page):
        word, *rest = shlex.split(line)
        assert word in wearfem.commands, line
        context = wearfem.commands[word].make_context(word, rest)
        parse_settings(context.params.get("settings", ()))
        for one in rest:
            if one.startswith("cases/") and "my_" not in one:
                assert (ROOT / one.rstrip("/")).exists(), line


def test_decisions_are_numbered():
    numbers = [int(page.name[:4]) for page in sorted(ROOT.glob("docs/decisions/*.md"))]
    assert numbers == list(range(1, len(numbers) + 1))
