// SPDX-License-Identifier: Apache-2.0
// A second drive beside the first: a car that one sees through, and how far apart in time both are.

import type {Scene} from 'three';
import type {CarState, Lap} from '../lap';
import {type Car, makeGhost} from './car';
import {LapGap} from './lap_gap';
import type {VehicleShape} from './vehicle_shape';

export class Ghost {
  state?: CarState;
  /** The first car was here so much later than the ghost; undefined where the ghost never was. */
  gap_s?: number;
  private car?: Car; // made when it is shown
  private lap?: Lap;
  private gap?: LapGap;

  constructor(
    private readonly scene: Scene,
    private readonly shape: VehicleShape,
  ) {}

  /** Where it is `t_s` after its start, at its end later on, and against the first car there. Undefined: no ghost. */
  show(lap: Lap | undefined, t_s: number, first: CarState, share: number, marked: boolean): void {
    if (lap !== this.lap) [this.lap, this.gap] = [lap, lap && new LapGap(lap)];
    this.state = this.gap_s = undefined;
    if (this.car) this.car.object.visible = this.car.marker.visible = false;
    if (!lap) return;
    if (!this.car) {
      this.car = makeGhost(this.shape);
      this.scene.add(this.car.object, this.car.marker);
    }
    this.car.object.visible = true;
    this.car.marker.visible = marked;
    this.state = lap.at(Math.min(Math.max(0, t_s), lap.duration_s - 1e-3));
    this.car.place(this.state);
    const passed_s = this.gap!.timeAt(first, share);
    if (passed_s !== undefined) this.gap_s = t_s - passed_s;
  }
}
