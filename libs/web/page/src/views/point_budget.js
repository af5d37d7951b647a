// Which pieces of the cloud are drawn: near ones to their finest level, far ones coarsely, all within a budget.

/** @returns {{resident: number, drawn: number}} points that may be kept and drawn; a phone gets less */
export function budgets() {
  const phone = matchMedia("(pointer: coarse)").matches;
  return { resident: 5_000_000, drawn: phone ? 1_500_000 : 5_000_000 };
}

/**
 * Level 0 of every piece comes first, then finer levels, the nearest pieces first.
 * @param {{level: number, n: number, distance: number}[]} pieces what is in sight
 * @returns {Set} the pieces to draw
 */
export function choose(pieces, budget) {
  // A level that is twice as fine is worth its points at half the distance.
  const turn = ({ level, distance }) => (level === 0 ? distance - 1e6 : (distance + 0.5) * 2 ** level);
  const drawn = new Set();
  let left = budget;
  for (const piece of [...pieces].sort((a, b) => turn(a) - turn(b))) {
    if (piece.n > left && drawn.size > 0) break;
    drawn.add(piece);
    left -= piece.n;
  }
  return drawn;
}

/** @returns the pieces that go when more than `budget` points are kept: the finest and farthest first */
export function surplus(pieces, budget) {
  let total = pieces.reduce((sum, piece) => sum + piece.n, 0);
  const gone = [];
  for (const piece of [...pieces].sort((a, b) => b.level - a.level || b.distance - a.distance)) {
    if (total <= budget) break;
    gone.push(piece);
    total -= piece.n;
  }
  return gone;
}
