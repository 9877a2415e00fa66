"""Which register holds which value of straight-line code."""

from collections.abc import Sequence

__all__ = ["allocate"]


def allocate(
    inputs: int, operands: Sequence[tuple[int, ...]], outputs: Sequence[int]
) -> tuple[list[int], dict[int, int], int]:
    """Drop dead instructions and give every value a register, reused after its last use.

    Value ``i < inputs`` is an input, value ``inputs + n`` the result of instruction n with the
    values ``operands[n]``. Returns the kept instructions in order, the register of every live
    value and the number of registers. No instruction writes to a register it reads, so that its
    loop over points has no overlap.

    >>> allocate(1, [(0,), (0,), (1,), (3,)], [4])
    ([0, 2, 3], {0: 0, 1: 1, 3: 0, 4: 1}, 2)
    """
    last = _last_uses(inputs, operands, outputs)
    place = {value: value for value in range(inputs)}
    free = [value for value in range(inputs) if value not in last]
    count, kept = inputs, []
    for index, used in enumerate(operands):
        if inputs + index not in last:
            continue
        kept.append(index)
        if free:
            place[inputs + index] = free.pop()
        else:
            place[inputs + index] = count
            count += 1
        free += [place[value] for value in used if last[value] == index]
    return kept, place, count


def _last_uses(
    inputs: int, operands: Sequence[tuple[int, ...]], outputs: Sequence[int]
) -> dict[int, int]:
    """The last instruction that needs each live value; outputs live to the end."""
    last = {value: len(operands) for value in outputs}
    for index in range(len(operands) - 1, -1, -1):
        if inputs + index in last:
            for value in operands[index]:
                last.setdefault(value, index)
    return last
