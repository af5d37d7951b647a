// Numbers as people read them: always with the unit.

/** Two decimals, and never -0.00. */
export function fixed(value) {
  return (Math.round(value * 100) / 100).toFixed(2);
}

/** A length: mm below 1 cm, cm below 1 m. */
export function length(metres) {
  if (metres === null || metres === undefined || !Number.isFinite(metres)) return "–";
  const size = Math.abs(metres);
  if (size < 0.01) return `${(metres * 1000).toFixed(1)} mm`;
  if (size < 1) return `${(metres * 100).toFixed(1)} cm`;
  return `${metres.toFixed(2)} m`;
}

export function angle(radians) {
  return Number.isFinite(radians) ? `${((radians * 180) / Math.PI).toFixed(1)}°` : "–";
}

export function seconds(value) {
  if (!Number.isFinite(value)) return "–";
  return value < 1 ? `${(value * 1000).toFixed(value < 0.1 ? 1 : 0)} ms` : `${value.toFixed(1)} s`;
}

export function memory(bytes) {
  return bytes < 1e9 ? `${(bytes / 1e6).toFixed(0)} MB` : `${(bytes / 1e9).toFixed(2)} GB`;
}

export function count(n) {
  if (n >= 1e6) return `${(n / 1e6).toFixed(2)} M`;
  return n >= 1e4 ? `${(n / 1e3).toFixed(0)} k` : String(n);
}

/** How long something lasts: 0:42, 12:05, 1:02:03. */
export function duration(total) {
  const s = Math.max(0, Math.round(total));
  const two = (n) => String(n).padStart(2, "0");
  const minutes = Math.floor(s / 60);
  return minutes < 60 ? `${minutes}:${two(s % 60)}` : `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(s % 60)}`;
}

/** utime as the time of day where the reader is. */
export function clock(utime) {
  return new Date(utime / 1000).toLocaleTimeString([], { hour12: false });
}

export function point([x, y, z]) {
  return `${[x, y, z].map(fixed).join(", ")} m`;
}
