import importlib.util
from pathlib import Path

import pytest

_SPEC = importlib.util.spec_from_file_location("fit_shapes", Path(__file__).parent / "shapes.py")
assert _SPEC is not None
assert _SPEC.loader is not None
_SHAPES = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(_SHAPES)


@pytest.fixture(scope="session")
def patches():
    """Patches of analytic shapes with exact truth."""
    return _SHAPES
