// SPDX-License-Identifier: Apache-2.0
// Shapes of a passenger car as smooth surfaces: cross sections along the car, from the lower edge of one side over the
// top to that of the other. Panels, windows, lamps and pillars are pieces of such a surface, a little off it.
// The car's frame: x ahead, y left, z up, origin on the road under the middle of the wheelbase.

import {BufferGeometry, Float32BufferAttribute, Vector3} from 'three';

import type {VehicleShape} from './vehicle_shape';

/** `u`: share of the length from the rear; `v`: from -1 (lower edge on the right) over 0 (middle of the top) to 1. */
export type Surface = (u: number, v: number) => Vector3;

/** Through all points, without overshoot between them (Fritsch and Carlson 1980). */
export function curve(points: [number, number][]): (x: number) => number {
  const n = points.length;
  const slope = (i: number) => (points[i + 1][1] - points[i][1]) / (points[i + 1][0] - points[i][0]);
  const tangents = points.map((_, i) => {
    if (i === 0) return slope(0);
    if (i === n - 1) return slope(n - 2);
    const [a, b] = [slope(i - 1), slope(i)];
    return a * b <= 0 ? 0 : (2 * a * b) / (a + b);
  });
  return (x) => {
    if (x <= points[0][0]) return points[0][1];
    if (x >= points[n - 1][0]) return points[n - 1][1];
    const i = points.findIndex(([px], k) => k > 0 && x <= px) - 1;
    const [[x0, y0], [x1, y1]] = [points[i], points[i + 1]];
    const h = x1 - x0,
      t = (x - x0) / h;
    return (
      y0 * (1 + 2 * t) * (1 - t) ** 2 +
      h * tangents[i] * t * (1 - t) ** 2 +
      y1 * t * t * (3 - 2 * t) +
      h * tangents[i + 1] * t * t * (t - 1)
    );
  };
}

/** Heights are shares of the car's height, widths of half its width. */
interface Profile {
  low: (u: number) => number;
  top: (u: number) => number;
  width: (u: number) => number;
}

const sideShare = 0.62; // of v: what stands upright

/** A section with upright sides, rounded shoulders and a crowned top. `lean`: how much narrower it is at the top. */
function section(
  y_m: number,
  low_m: number,
  top_m: number,
  lean: number,
  shoulder_m: number,
  crown_m: number,
  v: number,
): [number, number] {
  const side = Math.sign(v) || 1,
    w = Math.abs(v);
  const height_m = Math.max(0.01, top_m - low_m);
  const round_m = Math.min(shoulder_m, 0.6 * height_m);
  const belly = (t: number) => 1 - 0.05 * (1 - t) ** 3 - lean * t * t; // narrower at the sill and at the top
  const upper_m = top_m - crown_m - round_m;
  if (w >= sideShare) {
    const t = (1 - w) / (1 - sideShare);
    const z_m = low_m + t * Math.max(0, upper_m - low_m);
    return [side * y_m * belly((t * Math.max(0, upper_m - low_m)) / height_m), z_m];
  }
  const yShoulder_m = y_m * belly(Math.max(0, upper_m - low_m) / height_m);
  const inner_m = Math.max(0.3 * yShoulder_m, yShoulder_m - 1.3 * round_m);
  const corner = 0.4; // of v: where the corner ends
  if (w >= corner) {
    const angle = (0.5 * Math.PI * (sideShare - w)) / (sideShare - corner);
    return [side * (inner_m + (yShoulder_m - inner_m) * Math.cos(angle)), upper_m + round_m * Math.sin(angle)];
  }
  return [(inner_m * v) / corner, top_m - crown_m * (w / corner) ** 2];
}

/** Bodywork below the windows: boot, flanks with openings above the wheels, bonnet. */
export function bodySurface(shape: VehicleShape): Surface {
  const {length_m, width_m, height_m, wheelbase_m, wheelRadius_m, rearOverhang_m} = shape;
  const rear_m = -0.5 * wheelbase_m - rearOverhang_m;
  const {low, top, width} = bodyProfile;
  const arch_m = 1.14 * wheelRadius_m;
  return (u, v) => {
    const x_m = rear_m + u * length_m;
    const off_m = Math.min(Math.abs(x_m - 0.5 * wheelbase_m), Math.abs(x_m + 0.5 * wheelbase_m));
    const opening_m = off_m < arch_m ? wheelRadius_m + Math.sqrt(arch_m ** 2 - off_m ** 2) : 0;
    const top_m = top(u) * height_m;
    const low_m = Math.min(Math.max(low(u) * height_m, opening_m), top_m - 0.03);
    const flare =
      1 +
      (0.018 / (0.5 * width_m)) * Math.exp(-((off_m / (1.15 * arch_m)) ** 4)) * Math.min(1, (Math.abs(v) - 0.5) * 4);
    const [y_m, z_m] = section(0.5 * width_m * width(u) * 0.985, low_m, top_m, 0.045, 0.11, 0.028, v);
    return new Vector3(x_m, y_m * Math.max(1, flare), z_m);
  };
}

const bodyProfile: Profile = {
  low: curve([
    [0, 0.32],
    [0.012, 0.24],
    [0.05, 0.175],
    [0.15, 0.16],
    [0.85, 0.16],
    [0.96, 0.155],
    [0.99, 0.18],
    [1, 0.24],
  ]),
  top: curve([
    [0, 0.5],
    [0.008, 0.58],
    [0.03, 0.63],
    [0.08, 0.655],
    [0.3, 0.665],
    [0.6, 0.645],
    [0.72, 0.625],
    [0.82, 0.588],
    [0.9, 0.545],
    [0.95, 0.5],
    [0.98, 0.44],
    [0.995, 0.38],
    [1, 0.33],
  ]),
  width: curve([
    [0, 0.74],
    [0.01, 0.82],
    [0.04, 0.91],
    [0.12, 0.97],
    [0.25, 1],
    [0.72, 1],
    [0.85, 0.975],
    [0.93, 0.91],
    [0.97, 0.83],
    [0.99, 0.74],
    [1, 0.64],
  ]),
};

/** Windows and roof, from the foot of the rear window to that of the windscreen. */
export function cabinSurface(shape: VehicleShape): Surface {
  const {length_m, width_m, height_m, wheelbase_m, rearOverhang_m} = shape;
  const rear_m = -0.5 * wheelbase_m - rearOverhang_m;
  return (u, v) => {
    const low_m = (bodyProfile.top(u) - 0.045) * height_m;
    const top_m = Math.max(low_m + 0.012, cabinTop(u) * height_m);
    const [y_m, z_m] = section(
      0.5 * width_m * 0.93,
      low_m,
      top_m,
      0.2 * Math.min(1, (top_m - low_m) / (0.38 * height_m)) ** 0.8,
      0.09,
      0.03,
      v,
    );
    return new Vector3(rear_m + u * length_m, y_m * cabinWidth(u), z_m);
  };
}
export const cabin = {rear: 0.035, front: 0.745} as const; // u of its feet
const cabinTop = curve([
  [0.035, 0.63],
  [0.07, 0.76],
  [0.12, 0.9],
  [0.165, 0.96],
  [0.28, 0.995],
  [0.38, 1],
  [0.48, 0.985],
  [0.56, 0.935],
  [0.65, 0.79],
  [0.745, 0.6],
]);
const cabinWidth = curve([
  [0.035, 0.88],
  [0.12, 0.95],
  [0.3, 1],
  [0.55, 1],
  [0.68, 0.965],
  [0.745, 0.9],
]);

export interface Patch {
  u: [number, number];
  v: [number, number];
  off_m?: number; // outwards
  columns?: number; // along the car
  rows?: number; // across it
  breaks?: number[]; // u where a column of points has to stand
}

/** Outwards. */
function normalAt(surface: Surface, u: number, v: number): Vector3 {
  const e = 2e-3;
  const along = surface(Math.min(1, u + e), v).sub(surface(Math.max(0, u - e), v));
  const across = surface(u, Math.min(1, v + e)).sub(surface(u, Math.max(-1, v - e)));
  return along.cross(across).normalize();
}

/** A piece of a surface as triangles, seen from outside. */
export function patchOf(
  surface: Surface,
  {u, v, off_m = 0, columns = 24, rows = 16, breaks = []}: Patch,
): BufferGeometry {
  const positions: number[] = [],
    normals: number[] = [],
    indices: number[] = [];
  const us = Array.from({length: columns + 1}, (_, i) => u[0] + ((u[1] - u[0]) * i) / columns)
    .concat(breaks.filter((b) => b > u[0] && b < u[1]))
    .sort((a, b) => a - b);
  for (const at of us)
    for (let r = 0; r <= rows; ++r) {
      const across = v[0] + ((v[1] - v[0]) * r) / rows;
      const normal = normalAt(surface, at, across);
      positions.push(...surface(at, across).addScaledVector(normal, off_m).toArray());
      normals.push(...normal.toArray());
    }
  for (let c = 0; c + 1 < us.length; ++c)
    for (let r = 0; r < rows; ++r) {
      const a = c * (rows + 1) + r,
        b = a + rows + 1;
      indices.push(a, b, b + 1, a, b + 1, a + 1);
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new Float32BufferAttribute(normals, 3));
  geometry.setIndex(indices);
  return geometry;
}

/** Closes the surface's end at u = 0 or 1 with a flat face. */
export function capOf(surface: Surface, u: 0 | 1): BufferGeometry {
  const rows = 32;
  const rim = Array.from({length: rows + 1}, (_, r) => surface(u, -1 + (2 * r) / rows));
  const normal = u === 1 ? 1 : -1;
  const geometry = new BufferGeometry();
  geometry.setAttribute(
    'position',
    new Float32BufferAttribute(
      rim.flatMap((p) => p.toArray()),
      3,
    ),
  );
  geometry.setAttribute(
    'normal',
    new Float32BufferAttribute(
      rim.flatMap(() => [normal, 0, 0]),
      3,
    ),
  );
  const indices: number[] = [];
  for (let r = 1; r < rows; ++r) indices.push(0, ...(u === 1 ? [r + 1, r] : [r, r + 1]));
  geometry.setIndex(indices);
  return geometry;
}
