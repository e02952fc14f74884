// SPDX-License-Identifier: Apache-2.0
// Reads what `orthodrive build` left behind: /site/scene/tileset.json, then run.json, drive/lap.csv and lap.xosc,
// findings.geojson.
// The scene's frame here is the site CRS less the site's origin: x east, y north, z up, metres.

import {Matrix4} from 'three';
import {ordinaryCar, parseVehicleShape, type VehicleShape} from './car/vehicle_shape';
import {Lap} from './lap';

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

/** The car that is driven and its lap, where there is one. */
export interface SiteCar {
  vehicle: VehicleShape;
  lap?: Lap; // as far as it was asked for
  wholeLap(): Promise<Lap | undefined>;
}

/** What is told of the site, and found in it. */
export interface SiteNotes {
  name: string;
  attribution: string[];
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
export async function fetchOptional(url: string, headers: Record<string, string> = {}): Promise<Response | undefined> {
  const response = await fetch(url, {headers});
  if (response.status === 404) return undefined;
  if (!response.ok) throw new Error(`${url}: the server answers ${response.status}`);
  return response;
}

/** Address of a file that somebody named: it must lie in the site's folder. */
export function siteUrl(file: string): string {
  const names = file.split('/');
  if (names.some((name) => name === '' || name.startsWith('.')))
    throw new Error(`${file} is no file in the folder of the site: give its path below that folder.`);
  return `site/${names.map(encodeURIComponent).join('/')}`;
}

export async function loadSite(): Promise<Site> {
  const tilesetResponse = await fetchOptional(tilesetUrl);
  if (!tilesetResponse)
    throw new Error(`${tilesetUrl} is missing: build the site, then open it with "orthodrive view DIR"`);
  const tileset = (await tilesetResponse.json()) as TilesetJson;
  const frame = tileset.asset.extras?.orthodrive;
  if (!frame || !tileset.root.transform)
    throw new Error(`${tilesetUrl} was not written by orthodrive: it names no site CRS`);
  const top = (tileset.root.children ?? [])
    .flatMap(({content}) => content?.uri ?? [])
    .map((uri) => new URL(uri, new URL(tilesetUrl, location.href)).href);
  const coarsest = new Map(top.map((url) => [url, fetch(url)]));
  return {
    crs: frame.crs,
    origin: frame.origin,
    tileset,
    coarsest,
    localFromEcef: new Matrix4().fromArray(tileset.root.transform).invert(),
  };
}

const lapUrl = 'site/drive/lap.csv',
  lapFile = 'drive/lap.csv';
const lapHead_bytes = 1 << 20; // 25 s of a hundred rows a second

/** A lap of 10 km has 13 MB, and only its beginning may be wanted yet: what there is, and the text of the rest where it is left for later. */
async function fetchLap(onlyHead: boolean): Promise<{text: string; rest?: () => Promise<string>} | undefined> {
  const response = await fetchOptional(lapUrl, onlyHead ? {Range: `bytes=0-${lapHead_bytes - 1}`} : {});
  const text = await response?.text();
  if (text === undefined) return undefined;
  const bytes = Number(/\/(\d+)$/.exec(response!.headers.get('Content-Range') ?? '')?.[1] ?? 0); // of all, from servers that send parts
  if (bytes <= lapHead_bytes) return {text};
  return {text, rest: async () => (await fetchOptional(lapUrl, {Range: `bytes=${lapHead_bytes}-`}))!.text()};
}

/** With the lap as far as `t_s` at least; `site` may still be on its way. */
export async function loadCar(site: Promise<Site>, t_s: number): Promise<SiteCar> {
  const [fetched, scenario] = await Promise.all([
    fetchLap(t_s < Infinity),
    fetchOptional('site/drive/lap.xosc').then((response) => response?.text()),
  ] as const);
  const vehicle = (scenario === undefined ? undefined : parseVehicleShape(scenario)) ?? ordinaryCar;
  if (!fetched) return {vehicle, wholeLap: () => Promise.resolve(undefined)};
  const {text, rest} = fetched;
  const {origin} = await site;
  const parse = (csv: string) => Lap.parse(csv, origin, lapFile);
  const wholeLap = async () => (rest ? parse(text + (await rest())) : lap);
  let lap = parse(rest ? text.slice(0, text.lastIndexOf('\n')) : text); // the last row may be half a row
  if (rest && !(t_s >= 0 && t_s < lap.duration_s)) {
    lap = (await wholeLap())!;
    return {vehicle, lap, wholeLap: () => Promise.resolve(lap)};
  }
  return {vehicle, lap, wholeLap};
}

export async function loadNotes(): Promise<SiteNotes> {
  const [runResponse, findingsResponse] = await Promise.all(
    ['site/run.json', 'site/findings.geojson'].map((url) => fetchOptional(url)),
  );
  const run = (await runResponse?.json()) as RunJson | undefined;
  const findings = (await findingsResponse?.json()) as FindingsJson | undefined;
  return {
    name: run?.site?.name ?? '',
    attribution: run?.attribution ?? [],
    findings: (findings?.features ?? []).map((feature) => ({
      ...feature.properties,
      longitudeDeg: feature.geometry.coordinates[0],
      latitudeDeg: feature.geometry.coordinates[1],
    })),
  };
}
