"""Pauses between attempts of Newton's method that are refused."""

from dataclasses import dataclass


@dataclass
class Patience:
    """Pauses of Newton: twice as many sweeps after each refusal in a row.

    Attributes
    ----------
    pause, wait : sweeps of the next pause, and sweeps left of the current one.
    """

    pause: int = 1
    wait: int = 0

    def allows(self) -> bool:
        """Return True if Newton may try now; else count down."""
        self.wait -= 1
        return self.wait < 0

    def learn(self, taken: bool) -> None:
        """Record that a proposal was taken or refused."""
        self.pause, self.wait = (1, 0) if taken else (2 * self.pause, self.pause)
