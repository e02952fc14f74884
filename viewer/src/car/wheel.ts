// SPDX-License-Identifier: Apache-2.0
// A wheel that stands in the car's frame: axle along y, tyre with round shoulders, rim with spokes on both sides.

import {
  BoxGeometry,
  CylinderGeometry,
  Group,
  LatheGeometry,
  type Material,
  Mesh,
  MeshStandardMaterial,
  type Object3D,
  Vector2,
} from 'three';
import {withSky} from '../sky/sky_light';
import {merged} from './merged';

const halfWidth_m = 0.11;
const roundParts = 48,
  spokes = 7;

/** Of a tyre from bead to bead: shares of the radius, and of half the width. */
const tyreProfile: [number, number][] = [
  [0.66, -0.8],
  [0.7, -0.98],
  [0.8, -1],
  [0.91, -0.98],
  [0.97, -0.86],
  [0.995, -0.65],
  [1, -0.3],
  [1, 0.3],
  [0.995, 0.65],
  [0.97, 0.86],
  [0.91, 0.98],
  [0.8, 1],
  [0.7, 0.98],
  [0.66, 0.8],
];
/** Of the rim's well, which is open to both sides, with a lip that catches light. */
const rimProfile: [number, number][] = [
  [0.68, -0.84],
  [0.68, -0.9],
  [0.645, -0.9],
  [0.615, -0.6],
  [0.6, 0],
  [0.615, 0.6],
  [0.645, 0.9],
  [0.68, 0.9],
  [0.68, 0.84],
];

export interface WheelMaterials {
  rubber: Material;
  metal: Material;
  dark: Material;
}

export function wheelMaterials(): WheelMaterials {
  const made = (color: number, roughness: number, metalness: number) =>
    withSky(new MeshStandardMaterial({color, roughness, metalness}));
  return {rubber: made(0x121314, 0.92, 0), metal: made(0xc3c8ce, 0.32, 0.8), dark: made(0x3a3e42, 0.6, 0.3)};
}

function turned(profile: [number, number][], radius_m: number, material: Material): Mesh {
  return new Mesh(
    new LatheGeometry(
      profile.map(([r, y]) => new Vector2(r * radius_m, y * halfWidth_m)),
      roundParts,
    ),
    material,
  );
}

/** Turn it about y to roll it. */
export function makeWheel(radius_m: number, {rubber, metal, dark}: WheelMaterials): Group {
  const wheel = new Group();
  const rim = turned(rimProfile, radius_m, metal);
  const disc = new Mesh(new CylinderGeometry(0.5 * radius_m, 0.5 * radius_m, 0.03, roundParts), dark);
  const hub = new Mesh(new CylinderGeometry(0.13 * radius_m, 0.13 * radius_m, 1.62 * halfWidth_m, 24), metal);
  wheel.add(...merged([turned(tyreProfile, radius_m, rubber), rim, disc, hub, ...spokesOf(radius_m, metal)]));
  return wheel;
}

/** On both faces, a little behind the lips. */
function spokesOf(radius_m: number, metal: Material): Object3D[] {
  const [inner_m, outer_m] = [0.08 * radius_m, 0.635 * radius_m];
  const bar = new BoxGeometry(outer_m - inner_m, 0.025, 0.13 * radius_m);
  bar.translate(0.5 * (outer_m + inner_m), 0, 0);
  return [-1, 1].flatMap((side) =>
    Array.from({length: spokes}, (_, i) => {
      const spoke = new Mesh(bar, metal);
      spoke.position.y = side * 0.68 * halfWidth_m;
      spoke.rotation.y = (2 * Math.PI * i) / spokes;
      return spoke;
    }),
  );
}
