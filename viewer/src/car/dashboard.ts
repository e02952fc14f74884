// SPDX-License-Identifier: Apache-2.0
// Pedals, gear, the circle of accelerations and the loads of the tyres; what the drive does not have is not shown.

import type {CarState, Lap} from '../lap';

const gravity_mps2 = 9.81;
const wheels = ['load_fl_n', 'load_fr_n', 'load_rl_n', 'load_rr_n'] as const;
const trail = 40; // dots behind the one of the circle

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

export class Dashboard {
  private readonly circle = element<HTMLCanvasElement>('g-circle').getContext('2d')!;
  private readonly most_g: number; // of the circle
  private readonly most_n: number; // of a tyre
  private felt: {t_s: number; left_g: number; ahead_g: number}[] = []; // a moment ago

  constructor(lap: Lap) {
    const states = lap.sampled(0.1);
    const accelerations = states.map((state) => Math.hypot(state.a_lat_mps2, state.a_lon_mps2 ?? 0) / gravity_mps2);
    this.most_g = Math.max(0.5, Math.ceil(4 * Math.max(...accelerations)) / 4);
    this.most_n = Math.max(1, ...states.flatMap((state) => wheels.map((wheel) => state[wheel] ?? 0)));
  }

  show(car: CarState): void {
    this.showShare('throttle', car.throttle);
    this.showShare('brake', car.brake);
    element('gear').textContent = gearName(car.gear);
    element('revs').textContent = car.engine_rpm === undefined ? '' : `${Math.round(car.engine_rpm / 10) * 10} 1/min`;
    element('drive-line').hidden = [car.throttle, car.brake, car.gear, car.engine_rpm].every(
      (value) => value === undefined,
    );
    for (const wheel of wheels) this.showShare(wheel, car[wheel] === undefined ? undefined : car[wheel] / this.most_n);
    element('loads').hidden = wheels.every((wheel) => car[wheel] === undefined);
    element('g-circle').hidden = car.a_lon_mps2 === undefined;
    if (car.a_lon_mps2 !== undefined)
      this.showFelt(car.t_s, car.a_lat_mps2 / gravity_mps2, car.a_lon_mps2 / gravity_mps2);
  }

  private showShare(id: string, share: number | undefined): void {
    element(id).hidden = share === undefined;
    element(id).style.setProperty('--share', String(share ?? 0));
  }

  private showFelt(t_s: number, left_g: number, ahead_g: number): void {
    const last = this.felt[this.felt.length - 1];
    if (last && (t_s < last.t_s || t_s > last.t_s + 1)) this.felt = []; // the drive was wound
    if (this.felt[this.felt.length - 1]?.t_s !== t_s) this.felt.push({t_s, left_g, ahead_g});
    this.felt.splice(0, this.felt.length - trail);
    this.drawCircle();
  }

  /** What is felt: the dot goes outwards in a bend and ahead when braking, as a ball on the bonnet would. */
  private drawCircle(): void {
    const {canvas} = this.circle;
    const [middle, radius] = [0.5 * canvas.width, 0.46 * canvas.width];
    this.circle.clearRect(0, 0, canvas.width, canvas.height);
    this.circle.strokeStyle = 'rgba(16, 32, 43, 0.35)';
    for (const share of [0.5, 1]) {
      this.circle.beginPath();
      this.circle.arc(middle, middle, share * radius, 0, 2 * Math.PI);
      this.circle.stroke();
    }
    this.circle.fillStyle = 'rgba(16, 32, 43, 0.6)';
    this.circle.font = '18px sans-serif';
    this.circle.fillText(`${this.most_g} g`, 2, 18);
    this.felt.forEach(({left_g, ahead_g}, i) => {
      const isNow = i + 1 === this.felt.length;
      this.circle.fillStyle = isNow ? '#d8382c' : `rgba(216, 56, 44, ${(0.4 * i) / this.felt.length})`;
      this.circle.beginPath();
      this.circle.arc(
        middle + (left_g / this.most_g) * radius,
        middle + (ahead_g / this.most_g) * radius,
        isNow ? 9 : 4,
        0,
        2 * Math.PI,
      );
      this.circle.fill();
    });
  }
}

function gearName(gear: number | undefined): string {
  if (gear === undefined) return '';
  return gear === 0 ? 'N' : gear < 0 ? 'R' : String(gear);
}
