// SPDX-License-Identifier: Apache-2.0
// The roads before and after they were moved onto the photo, and how sure that is: road_graph.geojson.

import type {Object3D} from 'three';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {LineSegments2} from 'three/addons/lines/LineSegments2.js';
import {LineSegmentsGeometry} from 'three/addons/lines/LineSegmentsGeometry.js';

import {fetchOptional, type Site} from '../site';
import {utmFromGeographic, utmZone} from '../utm';

export const graphColors = {before: 0xf0452f, after: 0x17c3b2, bars: 0xffd23f};
const over_m = 0.35;
const quantile = 1.96; // 95 % of a normal distribution lie within so many sigmas
const barEvery = 5; // nodes, which are 2 m apart

/** A way of the map: before or after. Lists have a number a node. */
interface Way {
  state: 'before' | 'after';
  places: [number, number, number][]; // in the scene's frame
  width_m?: number[];
  sigma_offset_m?: number[];
  sigma_width_m?: number[];
}

interface GraphJson {
  features: {
    geometry: {coordinates: [number, number][]};
    properties: Omit<Way, 'places'> & {z_m: (number | null)[]};
  }[];
}

let loading: Promise<Way[]> | undefined;

async function loadWays(site: Site): Promise<Way[]> {
  const zone = utmZone(site.crs);
  if (!zone) throw new Error(`The roads before and after can be drawn in UTM only, and the site has ${site.crs}.`);
  const response = await fetchOptional('site/road_graph.geojson');
  if (!response) throw new Error('The site has no road_graph.geojson: build it anew with this version of the tool.');
  const {features} = (await response.json()) as GraphJson;
  return features.map(({geometry, properties: {z_m, ...way}}) => ({
    ...way,
    places: geometry.coordinates.map(([longitudeDeg, latitudeDeg], i) => {
      const [x, y] = utmFromGeographic(zone, longitudeDeg, latitudeDeg);
      return [x - site.origin[0], y - site.origin[1], (z_m[i] ?? NaN) - site.origin[2] + over_m];
    }),
  }));
}
const ways = (site: Site) => (loading ??= loadWays(site));

export async function loadGraph(site: Site, state: Way['state']): Promise<Object3D> {
  const segments: number[] = [];
  for (const way of await ways(site))
    if (way.state === state)
      way.places.slice(1).forEach((place, i) => {
        const ends = [...way.places[i], ...place];
        if (ends.every(Number.isFinite)) segments.push(...ends);
      });
  return lines(segments, graphColors[state], 3);
}

/** `segments`: x, y, z of both ends of each. */
function lines(segments: number[], color: number, width_px: number): Object3D {
  const drawn = new LineSegments2(
    new LineSegmentsGeometry().setPositions(segments),
    new LineMaterial({color, linewidth: width_px, fog: true}),
  );
  drawn.frustumCulled = false;
  return drawn;
}

/** Bars across the roads: where the middle and both edges lie with 95 %. */
export async function loadErrorBars(site: Site): Promise<Object3D> {
  const positions: number[] = [];
  for (const way of await ways(site)) if (way.state === 'after') addBars(way, positions);
  return lines(positions, graphColors.bars, 2);
}

function addBars({places, width_m, sigma_offset_m, sigma_width_m}: Way, positions: number[]): void {
  for (let i = 0; i < places.length; i += barEvery) {
    const [before, after] = [places[Math.max(0, i - 1)], places[Math.min(places.length - 1, i + 1)]];
    const length_m = Math.hypot(after[0] - before[0], after[1] - before[1]);
    if (length_m === 0 || !Number.isFinite(places[i][2])) continue;
    const ahead: [number, number] = [(after[0] - before[0]) / length_m, (after[1] - before[1]) / length_m];
    const middle_m = quantile * sigma_offset_m![i],
      edge_m = quantile * Math.hypot(sigma_offset_m![i], 0.5 * sigma_width_m![i]);
    addBar(places[i], ahead, 0, middle_m, positions);
    for (const side of [-1, 1]) addBar(places[i], ahead, 0.5 * side * width_m![i], edge_m, positions);
  }
}

/** From `left_m - reach_m` to `left_m + reach_m` beside the place, with a cap on both ends. */
function addBar(
  [x, y, z]: [number, number, number],
  [ahead_x, ahead_y]: [number, number],
  left_m: number,
  reach_m: number,
  positions: number[],
): void {
  const cap_m = 0.25;
  const at = (left: number, ahead: number) => [
    x - ahead_y * left + ahead_x * ahead,
    y + ahead_x * left + ahead_y * ahead,
    z,
  ];
  positions.push(...at(left_m - reach_m, 0), ...at(left_m + reach_m, 0));
  for (const end of [left_m - reach_m, left_m + reach_m]) positions.push(...at(end, -cap_m), ...at(end, cap_m));
}
