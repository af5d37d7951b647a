// Series are told apart three times over: by Okabe and Ito's colours (report.css, for light and dark), by symbols and by
// dashes, so that neither eyes nor a grey printer confuse them.
const symbols = ["circle", "triangle", "square", "diamond", "cross", "star", "wye"];
const dashes = ["", "7 3", "2 3", "9 3 2 3", "14 4", "4 2 1 2 1 2"];
const colours = 8;

export function lookOf(index) {
  return {
    colour: `var(--series-${index % colours})`,
    symbol: symbols[index % symbols.length],
    dash: dashes[index % dashes.length],
    strong: index % 2 === 0, // bars: every second one is lighter
  };
}
