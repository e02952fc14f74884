// SPDX-License-Identifier: Apache-2.0
// Keys, a gamepad and the touch pads of the page as steering wheel and pedals.

import type {Controls} from './driving';

const most_rad = 0.6; // of the front wheels
const wheelbase_m = 2.6;
const handiest_mps2 = 9; // what full lock asks for at speed, so that keys can steer a fast car
const turn_1ps = 2.2,
  back_1ps = 4,
  pedal_1ps = 3; // shares of the whole way a second

type Pedal = 'left' | 'right' | 'up' | 'down';
const keys: Record<string, Pedal> = {
  ArrowLeft: 'left',
  KeyA: 'left',
  ArrowRight: 'right',
  KeyD: 'right',
  ArrowUp: 'up',
  KeyW: 'up',
  ArrowDown: 'down',
  KeyS: 'down',
};

const towards = (from: number, to: number, step: number) => from + Math.max(-step, Math.min(step, to - from));

export class DriverInput {
  private readonly pressed = new Set<Pedal>();
  private wheel = 0; // -1 right to 1 left
  private up = 0;
  private down = 0;
  private backwards = false;

  constructor() {
    window.addEventListener('blur', () => this.pressed.clear());
    for (const pad of document.querySelectorAll<HTMLElement>('#pads [data-pedal]')) {
      const pedal = pad.dataset.pedal as Pedal;
      pad.onpointerdown = (event) => {
        pad.setPointerCapture(event.pointerId);
        this.pressed.add(pedal);
      };
      pad.onpointerup = pad.onpointercancel = () => this.pressed.delete(pedal);
    }
  }

  /** Whether the key is one of the car's. */
  key(code: string, isDown: boolean): boolean {
    const pedal = keys[code];
    if (pedal && isDown) this.pressed.add(pedal);
    else if (pedal) this.pressed.delete(pedal);
    return pedal !== undefined;
  }

  reset(): void {
    this.pressed.clear();
    this.wheel = this.up = this.down = 0;
    this.backwards = false;
  }

  /** The brake's key drives backwards once the car stands, and the other way round. */
  controls(speed_mps: number, elapsed_s: number): Controls {
    const share = (pedal: Pedal) => (this.pressed.has(pedal) ? 1 : 0);
    const pad = navigator.getGamepads().find((one) => one !== null && one.mapping === 'standard');
    const side = share('left') - share('right');
    this.wheel = towards(this.wheel, side, (side === 0 ? back_1ps : turn_1ps) * elapsed_s);
    this.up = towards(this.up, share('up'), pedal_1ps * elapsed_s);
    this.down = towards(this.down, share('down'), pedal_1ps * elapsed_s);
    let {wheel, up, down} = this;
    if (pad) {
      const stick = pad.axes[0];
      const dead = 0.08;
      if (Math.abs(stick) > dead) wheel = -(stick - Math.sign(stick) * dead) / (1 - dead);
      up = Math.max(up, pad.buttons[7].value);
      down = Math.max(down, pad.buttons[6].value);
    }
    const nearlyStill_mps = 0.5;
    if (down > 0.1 && up < 0.1 && speed_mps < nearlyStill_mps) this.backwards = true;
    if (up > 0.1 && speed_mps > -nearlyStill_mps) this.backwards = false;
    const lock_rad = Math.min(
      most_rad,
      Math.atan((wheelbase_m * handiest_mps2) / Math.max(1, speed_mps * speed_mps)) + 0.02,
    );
    const steering_rad = wheel * lock_rad;
    return this.backwards
      ? {steering_rad, throttle: down, brake: up, gear: -1}
      : {steering_rad, throttle: up, brake: down, gear: 1};
  }
}
