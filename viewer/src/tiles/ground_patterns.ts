// SPDX-License-Identifier: Apache-2.0
// What the ground looks like from a metre away: grass, soil, forest floor, paving, gravel. Painted with seeded strokes
// that go on across the edges, so that the patterns repeat every 2 m. Runs in a worker: it takes some tenths of a second.

import {fractal, randomOf} from '../noise';

export const groundKinds = ['grass', 'soil', 'forest', 'paving', 'gravel'] as const;
export const groundPattern_m = 2;
export const groundPattern_px = 512;

/** Layers one after the other. Red: brightness (its mean is in `means`, 0 to 1), green: warmth (128: none), blue and alpha: 0.5 (n + 1) of the normal, x and y. */
export interface GroundPatterns {
  data: Uint8Array<ArrayBuffer>;
  means: number[];
}

const n = groundPattern_px,
  px_per_m = n / groundPattern_m;

/** A picture of brightness, warmth (0.5: none) and height (0 to 1) in red, green and blue. */
class Painter {
  readonly random: () => number;
  private readonly context: OffscreenCanvasRenderingContext2D;

  constructor(seed: number, ground: [number, number, number]) {
    this.random = randomOf(seed);
    this.context = new OffscreenCanvas(n, n).getContext('2d', {willReadFrequently: true})!;
    this.context.fillStyle = this.color(ground);
    this.context.fillRect(0, 0, n, n);
    this.context.lineCap = 'round';
  }

  between(low: number, high: number): number {
    return low + (high - low) * this.random();
  }
  private color(values: number[]): string {
    return `rgb(${values.map((value) => Math.round(255 * Math.min(1, Math.max(0, value)))).join(',')})`;
  }

  /** Draws at a random place, and once more beyond every edge that it reaches over. */
  private strew(reach_m: number, draw: (x: number, y: number) => void): void {
    const [x, y, reach] = [n * this.random(), n * this.random(), reach_m * px_per_m];
    for (const dx of [-n, 0, n])
      for (const dy of [-n, 0, n])
        if (x + dx > -reach && x + dx < n + reach && y + dy > -reach && y + dy < n + reach) draw(x + dx, y + dy);
  }
  /** A blade, straw or twig: bent a little. */
  stroke(length_m: number, width_m: number, values: [number, number, number]): void {
    const {context} = this;
    const angle = 2 * Math.PI * this.random(),
      bend = this.between(-0.25, 0.25),
      length = length_m * px_per_m;
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    this.strew(length_m, (x, y) => {
      context.strokeStyle = this.color(values);
      context.lineWidth = width_m * px_per_m;
      context.beginPath();
      context.moveTo(x, y);
      context.quadraticCurveTo(
        x + length * (0.5 * cos - bend * sin),
        y + length * (0.5 * sin + bend * cos),
        x + length * cos,
        y + length * sin,
      );
      context.stroke();
    });
  }
  /** A stone or leaf, brighter and higher towards its middle. */
  lump(length_m: number, width_m: number, values: [number, number, number], rings: number): void {
    const {context} = this;
    const angle = Math.PI * this.random();
    this.strew(length_m, (x, y) => {
      for (let ring = 0; ring < rings; ++ring) {
        const size = 1 - (0.75 * ring) / rings,
          rise = rings === 1 ? 1 : 0.55 + (0.45 * ring) / (rings - 1);
        context.fillStyle = this.color([values[0] * rise, values[1], values[2] * rise]);
        context.beginPath();
        context.ellipse(x, y, 0.5 * size * length_m * px_per_m, 0.5 * size * width_m * px_per_m, angle, 0, 2 * Math.PI);
        context.fill();
      }
    });
  }
  pixels(): Uint8ClampedArray {
    return this.context.getImageData(0, 0, n, n).data;
  }
}

interface Painted {
  painter: Painter;
  /** Added to the painted values: strength of noise in brightness, warmth and height. */
  noise: {cells: number; octaves: number; shade: number; warmth: number; height: number};
  height_m: number; // of 1
}

function grass(): Painted {
  const painter = new Painter(11, [0.16, 0.5, 0]);
  for (let i = 0; i < 9000; ++i) {
    const height = 0.25 + (0.75 * i) / 9000; // from the ground to the tips
    const dry = painter.random() < 0.08;
    const shade = (0.18 + 0.38 * height) * painter.between(0.75, 1.25) + (dry ? 0.15 : 0);
    painter.stroke(painter.between(0.04, 0.11), painter.between(0.004, 0.008), [
      shade,
      0.5 + painter.between(-0.06, 0.06) + (dry ? 0.1 : 0),
      height,
    ]);
  }
  return {painter, noise: {cells: 5, octaves: 3, shade: 0.1, warmth: 0.04, height: 0.1}, height_m: 0.035};
}

function soil(): Painted {
  const painter = new Painter(12, [0.5, 0.5, 0.4]);
  for (let i = 0; i < 500; ++i)
    painter.lump(
      painter.between(0.01, 0.035),
      painter.between(0.008, 0.025),
      [painter.between(0.5, 0.72), 0.49, 0.6],
      3,
    );
  for (let i = 0; i < 160; ++i)
    painter.stroke(painter.between(0.03, 0.14), 0.004, [painter.between(0.6, 0.8), 0.55, 0.6]);
  return {painter, noise: {cells: 10, octaves: 6, shade: 0.3, warmth: 0.04, height: 0.4}, height_m: 0.04};
}

function forest(): Painted {
  const painter = new Painter(13, [0.25, 0.5, 0.1]);
  for (let i = 0; i < 4000; ++i) {
    const kind = painter.random();
    painter.lump(
      painter.between(0.025, 0.06),
      painter.between(0.012, 0.03),
      [(0.22 + 0.4 * kind) * painter.between(0.7, 1.2), 0.5 + 0.14 * (kind - 0.3), painter.between(0.2, 0.8)],
      2,
    );
  }
  for (let i = 0; i < 120; ++i)
    painter.stroke(painter.between(0.08, 0.35), painter.between(0.004, 0.01), [painter.between(0.35, 0.6), 0.52, 0.9]);
  for (let i = 0; i < 700; ++i)
    painter.stroke(painter.between(0.04, 0.1), 0.006, [painter.between(0.3, 0.55), 0.44, 0.9]);
  return {painter, noise: {cells: 8, octaves: 4, shade: 0.12, warmth: 0.03, height: 0.15}, height_m: 0.03};
}

function paving(): Painted {
  const painter = new Painter(14, [0.5, 0.5, 0.4]);
  for (let i = 0; i < 9000; ++i)
    painter.lump(
      painter.between(0.006, 0.014),
      painter.between(0.005, 0.01),
      [painter.between(0.38, 0.66), painter.between(0.48, 0.52), 0.6],
      1,
    );
  return {painter, noise: {cells: 4, octaves: 6, shade: 0.12, warmth: 0.01, height: 0.1}, height_m: 0.004};
}

function gravel(): Painted {
  const painter = new Painter(15, [0.22, 0.5, 0]);
  for (let i = 0; i < 7000; ++i)
    painter.lump(
      painter.between(0.02, 0.045),
      painter.between(0.015, 0.03),
      [painter.between(0.4, 0.75), painter.between(0.46, 0.55), painter.between(0.5, 1)],
      3,
    );
  return {painter, noise: {cells: 6, octaves: 4, shade: 0.06, warmth: 0.02, height: 0.05}, height_m: 0.02};
}

const painters: Record<(typeof groundKinds)[number], () => Painted> = {grass, soil, forest, paving, gravel};

export function paintGround(): GroundPatterns {
  const data = new Uint8Array(4 * n * n * groundKinds.length);
  const means = groundKinds.map((kind, layer) => {
    const {painter, noise, height_m} = painters[kind]();
    const painted = painter.pixels(),
      field = fractal(n, noise.cells, noise.octaves, painter.random);
    const height = (x: number, y: number) => {
      const i = (y & (n - 1)) * n + (x & (n - 1));
      return (painted[4 * i + 2] / 255 + noise.height * field[i]) * height_m * px_per_m;
    };
    let sum = 0;
    for (let y = 0; y < n; ++y)
      for (let x = 0; x < n; ++x) {
        const i = y * n + x,
          to = 4 * (layer * n * n + i);
        const [sx, sy] = [0.5 * (height(x + 1, y) - height(x - 1, y)), 0.5 * (height(x, y + 1) - height(x, y - 1))];
        const length = Math.sqrt(1 + sx * sx + sy * sy);
        const byte = (value: number) => Math.round(255 * Math.min(1, Math.max(0, value)));
        data[to] = byte(painted[4 * i] / 255 + noise.shade * field[i]);
        data[to + 1] = byte(painted[4 * i + 1] / 255 + noise.warmth * field[i]);
        data[to + 2] = byte(0.5 - (0.5 * sx) / length);
        data[to + 3] = byte(0.5 - (0.5 * sy) / length);
        sum += data[to];
      }
    return sum / (255 * n * n);
  });
  return {data, means};
}
