"""Which classes the objects of a frame have: dealt from shuffled decks, which balances every beginning of a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from usdsdg.scenarios.draws import Draws

_CARDS = 200  # of a deck at most, whatever the shares


def deal(draws: Draws, counts: Sequence[int], shares: Mapping[str, float]) -> list[list[str]]:
    """Return the classes of each frame's objects; `counts` are their numbers, `shares` relative ones of classes."""
    deck = _deck(shares)
    dealt: list[str] = []
    for number in range(-(-sum(counts) // len(deck))):
        dealt += [deck[index] for index in draws.generator("deck", number).permutation(len(deck))]
    hands, at = [], 0
    for count in counts:
        hands.append(dealt[at : at + count])
        at += count
    return hands


def variants(hands: Sequence[Sequence[str]], available: Mapping[str, int]) -> list[list[tuple[str, int]]]:
    """Return class and number of the shape of each object: the shapes of a class take turns."""
    used: Counter[str] = Counter()
    found = []
    for hand in hands:
        row = []
        for label in hand:
            row.append((label, used[label] % available[label]))
            used[label] += 1
        found.append(row)
    return found


def most_of_each(hands: Iterable[Sequence[tuple[str, int]]]) -> Counter[tuple[str, int]]:
    """Return how many objects of each shape a frame has at most."""
    most: Counter[tuple[str, int]] = Counter()
    for hand in hands:
        most |= Counter(hand)
    return most


def _deck(shares: Mapping[str, float]) -> list[str]:
    """Return cards in the ratio of the shares, one of each class at least."""
    smallest = min(shares.values())
    factor = 1.0 if len(set(shares.values())) == 1 else min(4.0, _CARDS * smallest / sum(shares.values()))
    return [label for label, share in shares.items() for _ in range(max(1, round(share / smallest * factor)))]
