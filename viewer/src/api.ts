// SPDX-License-Identifier: Apache-2.0
// What scripts and tests can ask and do: window.orthodrive.

import type {CameraMode, View} from './cameras';
import type {CarState} from './lap';
import type {LayerName} from './layers/layer_switches';
import type {HeldTile} from './tiles/tile_layers';

export interface Api {
  readonly ready: boolean; // all tiles and layers of the present view are loaded and drawn
  readonly frame: number; // pictures drawn so far
  readonly tilesLoaded: number;
  readonly tilesVisible: number;
  readonly covered: boolean; // the picture shows tiles, coarse ones perhaps, wherever the present view shows the site
  readonly held: HeldTile[]; // tiles in memory
  readonly drawn: {triangles: number; calls: number}; // by the last picture and its shadows
  readonly failures: string[];
  readonly mode: CameraMode;
  readonly car: CarState | undefined; // x, y, z from the site's origin
  readonly ghost: CarState | undefined; // the other car
  readonly gap_s: number | undefined; // the car passed here so much later than the ghost
  readonly driving: boolean; // somebody drives, no lap is shown
  readonly wheelsOnRoad: number; // of the car that somebody drives
  readonly cameraPosition: [number, number, number];
  readonly sun: [number, number, number]; // towards it
  readonly link: string; // address that restores the view
  readonly layers: Record<string, boolean>; // that can be shown, and whether they are
  /** What stands or lies under a place of the picture, -1..1 to the right and up. */
  describe(x: number, y: number): Promise<Record<string, string>>;
  /** Height of the first surface below a place 2 m above z_m: what wheels at z_m should stand on. */
  groundUnder(x_m: number, y_m: number, z_m: number): number | undefined;
  /** The road drawn nearest to a place, and the error of its tile. */
  roadNear(x_m: number, y_m: number, z_m: number): {z_m: number; error_m: number} | undefined;
  /** A place in the picture: -1..1 to the right and up, and up to 1 ahead. */
  pictured(x_m: number, y_m: number, z_m: number): [number, number, number];
  setCamera(mode: CameraMode): void;
  /** Flies to a view, from the site's origin. */
  setView(view: View): void;
  setLayer(layer: LayerName, on: boolean): void;
  setTime(t_s: number): void;
  setPlaying(on: boolean): void;
  /** Takes over the car where it is in the lap, or gives it back. */
  setDriving(on: boolean): Promise<void>;
  /** `date`: YYYY-MM-DD, `hour`: 0 to 24 of the zone's clocks. */
  setDay(date: string, hour: number): void;
}

declare global {
  interface Window {
    orthodrive: Api;
  }
}
