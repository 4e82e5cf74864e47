"""Rule for the place of files that a case names: below its folder or, if allowed, anywhere."""

import stat
from dataclasses import dataclass
from os.path import abspath
from pathlib import Path

from staffa.errors import InputError

WHERE = "a path counts from the folder of the case file"


@dataclass(frozen=True)
class FileAccess:
    """Place of the files that a case names.

    A case may come from anyone; its files are read and copied into the run.

    Attributes
    ----------
    folder : folder of the case file.
    outside : True if files may also lie elsewhere.
    """

    folder: Path = Path()
    outside: bool = False

    def file(self, name: str) -> Path:
        """Return the file that a case calls so. Links count as what they lead to.

        Raises
        ------
        InputError
            It is not there, no ordinary file, or lies elsewhere without leave.
        """
        path = Path(abspath(self.folder / name))
        try:
            kind, real = path.stat().st_mode, path.resolve()
        except FileNotFoundError:
            raise InputError(f"there is no file {path}; {WHERE}") from None
        except OSError as error:
            raise InputError(f"{path} cannot be read ({error.strerror}); {WHERE}") from None
        if not self.outside and not real.is_relative_to(self.folder.resolve()):
            raise InputError(
                f"{real} lies outside of the folder of the case file; copy it there or, if you "
                f"trust the case, allow it with --outside"
            )
        if not stat.S_ISREG(kind):  # a pipe would be waited for, a device may never end
            raise InputError(f"{path} cannot be read (it is no ordinary file); {WHERE}")
        return path
