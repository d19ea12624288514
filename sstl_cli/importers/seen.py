"""What has been read of a file so far, to tell a file that is written over or anew from one that goes on."""

from __future__ import annotations

import os
from hashlib import blake2b

# bytes of a block that is known by its digest alone
BLOCK = 1 << 16
# bytes at the end of what was read that are compared at every look
LAST = 256


class Seen:
    """Bytes read from the beginning of a file on: a digest a block, the first block and what follows the last whole one in full."""

    def __init__(self) -> None:
        self.size = 0
        self._first = b""
        self._rest = b""
        self._digests: list[bytes] = []

    def add(self, data: bytes) -> None:
        """Take the next bytes."""
        self._first += data[: BLOCK - len(self._first)]
        self._rest += data
        self.size += len(data)
        whole = len(self._rest) // BLOCK * BLOCK
        self._digests += [_digest(self._rest[at : at + BLOCK]) for at in range(0, whole, BLOCK)]
        self._rest = self._rest[whole:]

    def goes_on(self, descriptor: int, size: int) -> bool:
        """Whether a file of so many bytes still holds what was read, as far as its beginning and the last bytes of that tell."""
        if size < self.size or os.pread(descriptor, LAST, 0)[: self.size] != self._first[:LAST]:
            return False
        last = self._rest[-LAST:]
        return os.pread(descriptor, len(last), self.size - len(last)) == last

    def begins(self, descriptor: int, size: int) -> bool:
        """Whether the first bytes of a file of so many, or all if they are fewer, are those that were read."""
        size = min(size, self.size)
        if os.pread(descriptor, min(size, BLOCK), 0) != self._first[:size]:
            return False
        for k, known in enumerate(self._digests[1 : size // BLOCK], 1):
            if _digest(os.pread(descriptor, BLOCK, k * BLOCK)) != known:
                return False
        at = len(self._digests) * BLOCK
        return size <= at or os.pread(descriptor, size - at, at) == self._rest[: size - at]


def _digest(block: bytes) -> bytes:
    return blake2b(block, digest_size=16).digest()
