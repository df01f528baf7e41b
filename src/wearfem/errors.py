"""The one exception for what a user can put right, and how a program ends with it: in one sentence."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn


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


@contextmanager
def in_a_sentence(program: str) -> Iterator[None]:
    """What a program does, ended by a user's mistake with one sentence and exit code 2, by Ctrl-C with code 130; no traceback.

    Parameters
    ----------
    program
        Its name, or that of its file: the sentence begins with it.
    """
    try:
        yield
    except UserError as error:
        _stop(program, str(error), 2)
    except KeyboardInterrupt:
        _stop(program, "interrupted; what was written so far is whole", 130)
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)


def _stop(program: str, sentence: str, code: int) -> NoReturn:
    """Print the sentence on the error stream, after the name of the program, and end."""
    print(f"{Path(program).name}: {sentence.rstrip('.')}.", file=sys.stderr)
    sys.exit(code)
