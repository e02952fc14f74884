// Pedals, gear, the circle of accelerations and the loads of the tyres, where the drive has them.

import type {CarState, Lap} from './lap';

const gravity_mps2 = 9.81;
const wheels = ['load_fl_n', 'load_fr_n', 'load_rl_n', 'load_rr_n'] as const;

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

export class Dashboard {
  private readonly circle = element<HTMLCanvasElement>('g-circle').getContext('2d')!;
  private readonly most_g: number; // of the circle
  private readonly most_n: number; // of a tyre

  constructor(lap: Lap) {
    const states = lap.sampled(0.1);
    const accelerations = states.map((state) => Math.hypot(state.a_lat_mps2, state.a_lon_mps2 ?? 0) / gravity_mps2);
    this.most_g = Math.max(0.5, Math.ceil(4 * Math.max(...accelerations)) / 4);
    this.most_n = Math.max(1, ...states.flatMap((state) => wheels.map((wheel) => state[wheel] ?? 0)));
    const has = (name: keyof CarState) => states[0][name] !== undefined;
    element('drive-line').hidden = !has('throttle');
    element('g-circle').hidden = !has('a_lon_mps2');
    element('loads').hidden = !has('load_fl_n');
  }

  show(car: CarState): void {
    element('throttle').style.setProperty('--share', String(car.throttle ?? 0));
    element('brake').style.setProperty('--share', String(car.brake ?? 0));
    element('gear').textContent = car.gear === undefined ? '' : car.gear === 0 ? 'N' : String(car.gear);
    element('revs').textContent = car.engine_rpm === undefined ? '' : `${Math.round(car.engine_rpm / 10) * 10} 1/min`;
    wheels.forEach((wheel) => element(wheel).style.setProperty('--share', String((car[wheel] ?? 0) / this.most_n)));
    this.drawCircle(car.a_lat_mps2 / gravity_mps2, (car.a_lon_mps2 ?? 0) / gravity_mps2);
  }

  /** What is felt: the dot goes outwards in a bend and ahead when braking, as a ball on the bonnet would. */
  private drawCircle(left_g: number, ahead_g: number): void {
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
    this.circle.fillStyle = '#d8382c';
    this.circle.beginPath();
    this.circle.arc(middle + (left_g / this.most_g) * radius, middle + (ahead_g / this.most_g) * radius, 9, 0, 2 * Math.PI);
    this.circle.fill();
  }
}
