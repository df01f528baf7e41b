"""The one exception for what a user can put right."""

from collections.abc import Sequence


class UserError(Exception):
    """A mistake of the user, or of the user's machine, told in one sentence.

    The sentence says what was given, what was expected, what exists and what to do. The command line prints
    it without a traceback and ends with exit code 2.
    """


def in_words(names: Sequence[str], join: str = "and") -> str:
    """The names as words of a sentence: `a, b and c`, or `none`."""
    if len(names) < 2:
        return names[0] if names else "none"
    return f"{', '.join(names[:-1])} {join} {names[-1]}"
