"""The WebGL library of the page: three.js, which trimesh ships for its own viewer."""

from __future__ import annotations

import re
from functools import cache

from crispline.errors import InputError

# three.js as one script: its licence, then the minified library on a line of its own.
_LIBRARY = re.compile(r"<script>(/\*\*\s+\* @license.*?Three\.js Authors.*?\*/\s*![^\n]+)\n", re.S)


@cache
def three_js() -> str:
    """Source of three.js with its licence, for a ``<script>`` element; it sets ``THREE``.

    Raises
    ------
    InputError
        The installed trimesh ships no three.js where it used to.
    """
    import trimesh
    from trimesh.viewer import scene_to_html

    # A page of trimesh with one triangle: the library is the first thing in it.
    page = scene_to_html(trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).scene())
    found = _LIBRARY.search(page)
    if found is None:
        raise InputError(
            f"report: expected three.js inside the viewer of trimesh, found none in version "
            f"{trimesh.__version__}; install another one with: pip install 'trimesh>=4.9,<6'"
        )
    return found.group(1)
