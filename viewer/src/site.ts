// Reads what `orthodrive build` left behind: /site/scene/tileset.json, then run.json, drive/lap.csv and lap.xosc,
// findings.geojson.
// The scene's frame here is the site CRS less the site's origin: x east, y north, z up, metres.

import {Matrix4} from 'three';

import {Lap} from './lap';
import {ordinaryCar, parseVehicleShape, VehicleShape} from './vehicle_shape';

export const tilesetUrl = 'site/scene/tileset.json';

export interface Finding {
  severity: 'info' | 'warning' | 'error';
  code: string;
  message: string;
  longitudeDeg: number;
  latitudeDeg: number;
}

/** What a picture from the air needs. */
export interface Site {
  crs: string;
  origin: [number, number, number]; // of the scene, in the site CRS
  tileset: object; // tileset.json
  coarsest: Map<string, Promise<Response>>; // tiles that any view needs, by address: on their way
  localFromEcef: Matrix4;
}

/** What is on and beside the roads. */
export interface SiteDetails {
  name: string;
  attribution: string[];
  lap?: Lap;
  vehicle: VehicleShape;
  findings: Finding[];
}

interface TilesetJson {
  asset: {extras?: {orthodrive?: {crs: string; origin: [number, number, number]}}};
  root: {transform?: number[]; children?: {content?: {uri: string}}[]};
}

interface RunJson {
  site?: {name?: string};
  attribution?: string[];
}

interface FindingsJson {
  features: {
    geometry: {coordinates: [number, number]};
    properties: {severity: Finding['severity']; code: string; message: string};
  }[];
}

/** Undefined when the server has no such file: a site need not have a lap, findings or a run.json. */
export async function fetchOptional(url: string): Promise<Response | undefined> {
  const response = await fetch(url);
  if (response.status === 404) return undefined;
  if (!response.ok) throw new Error(`${url}: the server answers ${response.status}`);
  return response;
}

export async function loadSite(): Promise<Site> {
  const tilesetResponse = await fetchOptional(tilesetUrl);
  if (!tilesetResponse) throw new Error(`${tilesetUrl} is missing: build the site, then open it with "orthodrive view DIR"`);
  const tileset = (await tilesetResponse.json()) as TilesetJson;
  const frame = tileset.asset.extras?.orthodrive;
  if (!frame || !tileset.root.transform) throw new Error(`${tilesetUrl} was not written by orthodrive: it names no site CRS`);
  const top = (tileset.root.children ?? []).flatMap(({content}) => content?.uri ?? []).map((uri) => new URL(uri, new URL(tilesetUrl, location.href)).href);
  const coarsest = new Map(top.map((url) => [url, fetch(url)]));
  return {crs: frame.crs, origin: frame.origin, tileset, coarsest, localFromEcef: new Matrix4().fromArray(tileset.root.transform).invert()};
}

/** `site` may still be on its way. */
export async function loadDetails(site: Promise<Site>): Promise<SiteDetails> {
  const [runResponse, lapResponse, scenarioResponse, findingsResponse] = await Promise.all(
    ['site/run.json', 'site/drive/lap.csv', 'site/drive/lap.xosc', 'site/findings.geojson'].map(fetchOptional));
  const run = (await runResponse?.json()) as RunJson | undefined;
  const lapText = await lapResponse?.text();
  const scenario = await scenarioResponse?.text();
  const findings = (await findingsResponse?.json()) as FindingsJson | undefined;
  const {origin} = await site;
  return {
    name: run?.site?.name ?? '',
    attribution: run?.attribution ?? [],
    lap: lapText === undefined ? undefined : Lap.parse(lapText, origin, 'drive/lap.csv'),
    vehicle: (scenario === undefined ? undefined : parseVehicleShape(scenario)) ?? ordinaryCar,
    findings: (findings?.features ?? []).map((feature) => ({
      ...feature.properties,
      longitudeDeg: feature.geometry.coordinates[0],
      latitudeDeg: feature.geometry.coordinates[1],
    })),
  };
}
