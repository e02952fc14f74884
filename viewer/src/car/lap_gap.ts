// SPDX-License-Identifier: Apache-2.0
// When another lap passed the place where a car is: the time gap of two drives side by side.

import type {CarState, Lap} from '../lap';

const step_s = 0.05;
const most_m = 25; // apart: farther away the other lap did not pass here
/** Of a road that is driven twice the pass counts that is as far along its lap: a metre beside for 20 m along. */
const alongWeight = 0.05;

export class LapGap {
  private readonly states: CarState[];
  private readonly length_m: number;

  constructor(private readonly ghost: Lap) {
    this.states = ghost.sampled(step_s);
    this.length_m = this.states[this.states.length - 1].s_m - this.states[0].s_m;
  }

  /** Seconds into the other lap when it was beside that car and headed the same way; undefined where it never was. */
  timeAt(car: CarState, share: number): number | undefined {
    let best: CarState | undefined,
      least = Infinity;
    for (const state of this.states) {
      const distance_m = Math.hypot(state.x_m - car.x_m, state.y_m - car.y_m);
      if (distance_m > most_m || Math.cos(state.heading_rad - car.heading_rad) < 0.3) continue;
      const along_m = state.s_m - this.states[0].s_m - share * this.length_m;
      const cost = distance_m ** 2 + (alongWeight * along_m) ** 2;
      if (cost < least) [best, least] = [state, cost];
    }
    return best && this.refined(best, car);
  }

  /** Between the samples: where the other car is exactly abreast. */
  private refined(near: CarState, car: CarState): number {
    const ahead_m =
      Math.cos(near.heading_rad) * (car.x_m - near.x_m) + Math.sin(near.heading_rad) * (car.y_m - near.y_m);
    const shift_s = near.speed_mps > 1 ? ahead_m / near.speed_mps : 0;
    return Math.min(this.ghost.duration_s, Math.max(0, near.t_s + Math.max(-step_s, Math.min(step_s, shift_s))));
  }
}
