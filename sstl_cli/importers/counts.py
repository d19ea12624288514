"""What an import found and set aside, and the named policies it followed."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

from sstl_cli.importers.base import Notes
from sstl_cli.importers.mapping import Repair, Time


@dataclass
class Counts:
    """What was found in the recordings, in samples or places."""

    samples_in: int = 0
    samples_out: int = 0
    runs: int = 0
    repeated: int = 0
    # of those with a repeated time, the samples of which both tensions are others than those of the one beside them
    differing: int = 0
    backward: int = 0
    gaps: int = 0
    filled: int = 0
    dropouts: int = 0
    # dropouts between readings of a channel that go on behind them: interpolating fills these
    between: int = 0
    spikes: int = 0
    step_s: float | None = None
    gap_s: float | None = None
    blanked: dict[str, int] = field(default_factory=dict)
    notes: Notes = field(default_factory=Notes)
    remarks: list[str] = field(default_factory=list)

    def copy(self) -> Counts:
        """Return the counts as they are now."""
        notes = Notes(dict(self.notes.set_aside), self.notes.trimmed)
        return replace(self, blanked=dict(self.blanked), notes=notes, remarks=list(self.remarks))

    def blank(self, name: str, values: int) -> None:
        """Count values of a column that may be empty which no sensor can have given: the samples stay, these go."""
        if values:
            self.blanked[name] = self.blanked.get(name, 0) + values

    def back_to(self, before: Counts) -> None:
        """Forget what was counted since ``before``, a copy made earlier."""
        for one in fields(self):
            setattr(self, one.name, getattr(before, one.name))

    @property
    def found(self) -> dict[str, int]:
        """What was wrong with times and readings, and what was filled, by name."""
        return {
            "repeated_time": self.repeated,
            "backward_time": self.backward,
            "gaps": self.gaps,
            "dropouts": self.dropouts,
            "spikes": self.spikes,
            "filled": self.filled,
        }

    @property
    def set_aside_pct(self) -> float:
        """The same as a percentage of those read."""
        return 100 * self.set_aside / max(self.samples_in, 1)

    @property
    def set_aside(self) -> int:
        """Samples that were read and not written."""
        return sum(self.notes.set_aside.values())


@dataclass(frozen=True)
class Policy:
    """The named policies of one import."""

    time: Time
    repair: Repair
