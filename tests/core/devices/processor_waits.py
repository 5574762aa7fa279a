"""How long threads waited for a processor, as Linux counts it: the part of a delay that a busy
machine makes, and not the program."""

from pathlib import Path


def waits_of(process):
    """Seconds that the threads of a process were ready to run but did not, by thread; empty for a
    process that has ended."""
    waits = {}
    for thread in Path(f"/proc/{process}/task").glob("*/schedstat"):
        try:
            waits[thread.parent.name] = int(thread.read_text().split()[1]) / 1e9
        except (OSError, IndexError):
            continue  # it has ended meanwhile
    return waits


class Waits:
    """The waits of a process from now on. chain: how many of its threads act one after the
    other."""

    def __init__(self, process, chain):
        self.process, self.chain = process, chain
        self.before = waits_of(process)
        self.latest = dict(self.before)

    def until_now(self):
        """Seconds that a chain of threads can have waited: the sum of the longest waits of so many
        threads."""
        self.latest.update(waits_of(self.process))
        longest = sorted(
            (waited - self.before.get(thread, 0.0) for thread, waited in self.latest.items()),
            reverse=True,
        )
        return sum(longest[: self.chain])
