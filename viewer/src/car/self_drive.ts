// SPDX-License-Identifier: Apache-2.0
// The car that somebody drives.

import carText from '../../../models/vehicles/family_car.toml?raw';
import {followLag_s} from '../cameras';
import type {CarState} from '../lap';
import {type Controls, Driving} from './driving';

export class SelfDrive {
  private headings: {t_s: number; heading_rad: number}[] = [];

  private constructor(private readonly car: Driving) {}

  static async load(origin: readonly [number, number, number]): Promise<SelfDrive> {
    return new SelfDrive(await Driving.load(carText, origin));
  }

  takeOver(car: CarState): void {
    this.car.takeOver(car);
    this.headings = [];
  }

  advance(
    elapsed_s: number,
    controls: Controls,
    heightAt: (x_m: number, y_m: number, z_m: number) => number | undefined,
  ): void {
    this.car.advance(elapsed_s, controls, heightAt);
    const {t_s, heading_rad} = this.car.state;
    this.headings.push({t_s, heading_rad});
    while (this.headings.length > 1 && this.headings[1].t_s <= t_s - followLag_s) this.headings.shift();
  }

  get state(): CarState {
    return this.car.state;
  }
  get wheelsOnRoad(): number {
    return this.car.wheelsOnRoad;
  }
  /** Where the car headed a moment ago. */
  get headingBefore(): number {
    return this.headings[0]?.heading_rad ?? this.car.state.heading_rad;
  }
}
