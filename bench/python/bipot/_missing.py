"""Why the native part is not there."""

import pathlib
import sys


def how_to_build():
    """One sentence."""
    here = pathlib.Path(__file__).parent
    built = [path.name.split(".")[1] for path in here.glob("_bipot.*.so")]
    this = f"Python {sys.version_info.major}.{sys.version_info.minor} ({sys.executable})"
    if built:
        return (
            f"bipot was built for {', '.join(built)}, this is {this}: run that Python, or build for "
            f"this one with cmake --preset release -DPython_EXECUTABLE={sys.executable}"
        )
    return (
        "the Python module of bipot is not built: in the folder of the sources run "
        "cmake --build --preset release --target bipot_python"
    )
