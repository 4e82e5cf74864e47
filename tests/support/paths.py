"""Places of files that tests read and of programs that they start."""

import sys
from pathlib import Path

TESTS = Path(__file__).parent.parent
ROOT = TESTS.parent
# Files that tests read and never write.
DATA = TESTS / "data"
# The pages of the documentation, by section.
DOCS = ROOT / "docs"
# The cases that come with the package.
READY = ROOT / "src" / "staffa" / "case" / "ready"
# The programs of this environment: python, staffa, mpiexec.
BIN = Path(sys.executable).parent
