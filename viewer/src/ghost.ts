// A second drive beside the first: a car that one sees through, and how far apart in time both are.

import {Scene} from 'three';

import {Car, makeGhost} from './car';
import type {CarState, Lap} from './lap';
import {LapGap} from './lap_gap';
import type {VehicleShape} from './vehicle_shape';

export class Ghost {
  state?: CarState;
  /** The first car was here so much later than the ghost; undefined where the ghost never was. */
  gap_s?: number;
  private readonly car: Car;
  private lap?: Lap;
  private gap?: LapGap;

  constructor(scene: Scene, shape: VehicleShape) {
    this.car = makeGhost(shape);
    this.car.object.visible = this.car.marker.visible = false;
    scene.add(this.car.object, this.car.marker);
  }

  /** Where it is `t_s` after its start, at its end later on, and against the first car there. Undefined: no ghost. */
  show(lap: Lap | undefined, t_s: number, first: CarState, share: number, marked: boolean): void {
    if (lap !== this.lap) [this.lap, this.gap] = [lap, lap && new LapGap(lap)];
    this.car.object.visible = lap !== undefined;
    this.car.marker.visible = lap !== undefined && marked;
    this.state = this.gap_s = undefined;
    if (!lap) return;
    this.state = lap.at(Math.min(Math.max(0, t_s), lap.duration_s - 1e-3));
    this.car.place(this.state);
    const passed_s = this.gap!.timeAt(first, share);
    if (passed_s !== undefined) this.gap_s = t_s - passed_s;
  }
}
