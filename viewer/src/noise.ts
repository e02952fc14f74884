// SPDX-License-Identifier: Apache-2.0
// Seeded numbers and noise.

/** Mulberry32 (Ettinger 2017). */
export function randomOf(seed: number): () => number {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Value noise of size * size that repeats, octaves of half the size and 0.6 of the strength; -1 to 1. */
export function fractal(size: number, cells: number, octaves: number, random: () => number): Float32Array {
  const sum = new Float32Array(size * size);
  let strength = 1,
    total = 0;
  for (let octave = 0; octave < octaves; ++octave, cells *= 2, strength *= 0.6) {
    const corners = Float32Array.from({length: cells * cells}, () => 2 * random() - 1);
    total += strength;
    for (let y = 0; y < size; ++y)
      for (let x = 0; x < size; ++x) {
        const u = (x * cells) / size,
          v = (y * cells) / size;
        const i = Math.floor(u),
          j = Math.floor(v);
        const ease = (w: number) => w * w * (3 - 2 * w);
        const fu = ease(u - i),
          fv = ease(v - j);
        const at = (a: number, b: number) => corners[(b % cells) * cells + (a % cells)];
        const top = at(i, j) + fu * (at(i + 1, j) - at(i, j)),
          low = at(i, j + 1) + fu * (at(i + 1, j + 1) - at(i, j + 1));
        sum[y * size + x] += strength * (top + fv * (low - top));
      }
  }
  return sum.map((value) => value / total);
}
