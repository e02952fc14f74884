// SPDX-License-Identifier: Apache-2.0
// A car to drive oneself: the tool's own vehicle on the roads of the site, as WebAssembly (viewer/driving).

import type {CarState} from '../lap';
import {type Exports, roadsModule} from '../roads_module';

/** What the driver does. */
export interface Controls {
  steering_rad: number; // mean of the front wheels, positive to the left
  throttle: number; // 0 to 1
  brake: number; // 0 to 1
  gear: 1 | 0 | -1; // 1: the gearbox chooses
}

/** Of the values that place() points to, in their order. */
const stateNames = [
  'x_m',
  'y_m',
  'z_m',
  'heading_rad',
  'pitch_rad',
  'roll_rad',
  'speed_mps',
  'a_lat_mps2',
  'a_lon_mps2',
  'throttle',
  'gear',
  'engine_rpm',
  'steering_rad',
  'z_fl_m',
  'z_fr_m',
  'z_rl_m',
  'z_rr_m',
  'load_fl_n',
  'load_fr_n',
  'load_rl_n',
  'load_rr_n',
] as const satisfies readonly (keyof CarState)[];
const most_m = 0.5; // of way on one plane beside the roads
const wheelCount = 4; // behind them: whether each wheel is on a road

export class Driving {
  private at = 0;
  private time_s = 0;
  private way_m = 0;

  private constructor(
    private readonly module: Exports,
    private readonly origin: readonly [number, number, number],
  ) {}

  /** `car`: text of a file of models/vehicles; `origin`: of the scene. Throws what is wrong with the roads. */
  static async load(car: string, origin: readonly [number, number, number]): Promise<Driving> {
    const module = await roadsModule();
    const text = new TextEncoder().encode(car),
      at = module.allocate(text.length);
    new Uint8Array(module.memory.buffer, at, text.length).set(text);
    module.set_car(at, text.length);
    return new Driving(module, origin);
  }

  /** Goes on from where that car is. */
  takeOver(car: CarState): void {
    const [x, y, z] = this.origin;
    this.at = this.module.place(car.x_m + x, car.y_m + y, car.heading_rad, car.speed_mps, car.z_m + z);
    this.time_s = this.way_m = 0;
  }

  /** `heightAt`: of what is drawn, at a place of the scene near a height; asked for where a wheel is beside the roads. */
  advance(
    elapsed_s: number,
    controls: Controls,
    heightAt: (x_m: number, y_m: number, z_m: number) => number | undefined,
  ): void {
    const {steering_rad, throttle, brake, gear} = controls;
    // What lies beside the roads is a plane at a time: where pictures are slow the next one must not come as a step.
    const pieces = Math.max(1, Math.ceil((Math.abs(this.state.speed_mps) * elapsed_s) / most_m));
    for (let i = 0; i < pieces; ++i) {
      if (this.wheelsOnRoad < wheelCount) this.lookBeside(heightAt);
      this.module.advance(elapsed_s / pieces, steering_rad, throttle, brake, gear);
    }
    this.time_s += elapsed_s;
    this.way_m += Math.abs(this.state.speed_mps) * elapsed_s;
    this.brake = brake;
  }
  private brake = 0;

  private lookBeside(heightAt: (x_m: number, y_m: number, z_m: number) => number | undefined): void {
    const {x_m, y_m, z_m} = this.state;
    const apart_m = 2;
    const middle = heightAt(x_m, y_m, z_m),
      east = heightAt(x_m + apart_m, y_m, z_m),
      north = heightAt(x_m, y_m + apart_m, z_m);
    if (middle === undefined || east === undefined || north === undefined) return;
    const [gradientX, gradientY] = [(east - middle) / apart_m, (north - middle) / apart_m];
    const [x, y, z] = this.origin;
    this.module.set_beside(middle + z - gradientX * (x_m + x) - gradientY * (y_m + y), gradientX, gradientY);
  }

  get state(): CarState {
    const values = new Float64Array(this.module.memory.buffer, this.at, stateNames.length);
    const state = {t_s: this.time_s, s_m: this.way_m, brake: this.brake} as CarState;
    stateNames.forEach((name, i) => (state[name] = values[i]));
    const [x, y, z] = this.origin;
    state.x_m -= x;
    state.y_m -= y;
    for (const name of ['z_m', 'z_fl_m', 'z_fr_m', 'z_rl_m', 'z_rr_m'] as const) state[name]! -= z;
    state.gradient = Math.tan(state.pitch_rad);
    return state;
  }

  /** Of the four wheels. */
  get wheelsOnRoad(): number {
    const flags = new Float64Array(this.module.memory.buffer, this.at, stateNames.length + wheelCount).slice(
      stateNames.length,
    );
    return flags.filter((on) => on > 0).length;
  }
}
