// SPDX-License-Identifier: Apache-2.0
// The driven lap as a line on the map, coloured by speed.

import {Color} from 'three';
import {Line2} from 'three/addons/lines/Line2.js';
import {LineGeometry} from 'three/addons/lines/LineGeometry.js';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';

import type {Lap} from '../lap';

const slow = new Color(0xe2543b),
  middle = new Color(0xf6c945),
  fast = new Color(0x2fb673);

export function speedColor(share: number): Color {
  return share < 0.5 ? slow.clone().lerp(middle, 2 * share) : middle.clone().lerp(fast, 2 * share - 1);
}

export function routeLine(lap: Lap): Line2 {
  const states = lap.sampled(0.25);
  states.push({...states[0]}); // closed
  const top_mps = Math.max(...states.map((state) => state.speed_mps));
  const geometry = new LineGeometry();
  geometry.setPositions(states.flatMap((state) => [state.x_m, state.y_m, state.z_m + 0.25]));
  geometry.setColors(states.flatMap((state) => speedColor(state.speed_mps / top_mps).toArray()));
  return new Line2(
    geometry,
    new LineMaterial({linewidth: 3, vertexColors: true, fog: true, transparent: true, opacity: 0.9}),
  );
}
