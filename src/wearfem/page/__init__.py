"""Pages for a browser: templates with one layout and one style, whole in one file each."""

from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Any


def rendered(template: str, filters: Mapping[str, Callable[..., Any]], **told: Any) -> str:
    """A page as text.

    Parameters
    ----------
    template
        A file of this folder.
    filters
        What the template may put values through, by name.
    told
        Values that the template speaks of, by name.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("wearfem", "page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters
    style = (files("wearfem") / "page" / "page.css").read_text(encoding="utf-8")
    return environment.get_template(template).render(style=style, **told)
