import importlib.util
from pathlib import Path

import hypothesis
import pytest

# Property tests draw the same examples in every run, and are not judged by the clock.
hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None)
hypothesis.settings.load_profile("fixed")

_SPEC = importlib.util.spec_from_file_location("nets", Path(__file__).parent / "nets.py")
assert _SPEC is not None
assert _SPEC.loader is not None
_NETS = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(_NETS)


@pytest.fixture(scope="session")
def nets():
    """Quad nets of simple shapes."""
    return _NETS
