"""How long threads waited for a processor, as Linux counts it: the part of a delay that a busy
machine makes, and not the program. Zero on other systems."""

import os
from pathlib import Path

STATISTICS = Path("/proc/stat")


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


def stolen():
    """Seconds that the host of a virtual machine has kept its processors from running, all
    processors together."""
    if not STATISTICS.exists():
        return 0.0
    total = STATISTICS.read_text(encoding="ascii").splitlines()[0].split()
    return int(total[8]) / os.sysconf("SC_CLK_TCK")


class Waits:
    """The waits of processes from now on. chains: how many threads of each process act one after
    the other."""

    def __init__(self, chains):
        self.chains = chains
        self.before = {process: waits_of(process) for process in chains}
        self.latest = {process: dict(waits) for process, waits in self.before.items()}
        self.stolen_before = stolen()

    def until_now(self):
        """Seconds that the chains can have waited: the sum of the longest waits of so many threads
        of each process, and what the host has taken."""
        return stolen() - self.stolen_before + sum(map(self._of_chain, self.chains))

    def _of_chain(self, process):
        before, latest = self.before[process], self.latest[process]
        latest.update(waits_of(process))
        longest = sorted(
            (waited - before.get(thread, 0.0) for thread, waited in latest.items()), reverse=True
        )
        return sum(longest[: self.chains[process]])
