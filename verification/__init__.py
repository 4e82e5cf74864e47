"""Long verifications, a folder each, and what they share in `common`.

Several march the bodies that tests march, finer: the folder of the tests is put on the path.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent.parent / "tests"))
