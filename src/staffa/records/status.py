"""Status of solvers, minimizations and steps, and verdicts: enumerations that carry sentences."""

from enum import StrEnum
from typing import Self


class WithSentence(StrEnum):
    """An enumeration whose members carry a sentence; their value is what files hold."""

    sentence: str

    def __new__(cls, value: str, sentence: str) -> Self:
        """Make a member of its value and its sentence."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.sentence = sentence
        return member


class Status(WithSentence):
    """End of a step or a solver. The value is what stands in `steps.jsonl`.

    A step has one of the first four. The others say of a solver why it failed.

    Attributes
    ----------
    sentence : what happened, as a clause whose subject is the step or the solver.
    """

    CONVERGED = "converged", "it converged"
    NOT_CONVERGED = "not converged", "it ran out of iterations before it converged"
    FAILED = "failed", "it failed"
    REJECTED = "rejected", "it stands for no state of the run"

    DIVERGED = "diverged", "its residual grew"
    STALLED = "stalled", "it found no better point along its way"
    INDEFINITE = "indefinite", "its matrix or its preconditioner is not positive definite"
    NOT_FINITE = "not finite", "a value in it is not finite"
    NOT_PREPARED = "not prepared", "its preconditioner could not be made"
    BROKE_DOWN = "broke down", "it broke down"


class Verdict(WithSentence):
    """The result of the second-order test of a step's state.

    Attributes
    ----------
    sentence : what was found.
    """

    NOT_TESTED = "not tested", "the state was not tested"
    MINIMUM = "minimum", "no descent direction was found"
    BIFURCATION = "bifurcation", "only damage that heals would lower the energy"
    SADDLE = "saddle", "it is a saddle"
