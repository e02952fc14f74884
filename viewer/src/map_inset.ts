// SPDX-License-Identifier: Apache-2.0
// A small map with north up: the driven lap by speed, the findings that are shown, where the car and the camera are.

import type {Vector3} from 'three';

import type {CarState, Lap} from './lap';
import {speedColor} from './layers/route_line';

const margin_px = 12;

export class MapInset {
  private readonly canvas = document.getElementById('map') as HTMLCanvasElement;
  private readonly context = this.canvas.getContext('2d')!;
  private readonly route: ImageBitmap | HTMLCanvasElement;
  private readonly toMap: (x_m: number, y_m: number) => [number, number];

  constructor(lap: Lap) {
    const states = lap.sampled(0.5);
    const xs = states.map((state) => state.x_m),
      ys = states.map((state) => state.y_m);
    const [west, south] = [Math.min(...xs), Math.min(...ys)];
    const [width_m, height_m] = [Math.max(...xs) - west, Math.max(...ys) - south];
    const size = this.canvas.width - 2 * margin_px;
    const scale = size / Math.max(width_m, height_m, 1);
    this.toMap = (x_m, y_m) => [
      margin_px + 0.5 * (size - scale * width_m) + scale * (x_m - west),
      this.canvas.height - margin_px - 0.5 * (size - scale * height_m) - scale * (y_m - south),
    ];
    this.route = this.drawRoute(states);
    this.canvas.hidden = false;
  }

  show(car: CarState, ghost: CarState | undefined, eye: Vector3, target: Vector3): void {
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.drawImage(this.route, 0, 0);
    this.arrow(eye.x, eye.y, Math.atan2(target.y - eye.y, target.x - eye.x), '#5b6b76', 8);
    if (ghost) this.arrow(ghost.x_m, ghost.y_m, ghost.heading_rad, '#2f6fb3', 10);
    this.arrow(car.x_m, car.y_m, car.heading_rad, '#d8382c', 11);
  }

  private drawRoute(states: CarState[]): HTMLCanvasElement {
    const layer = document.createElement('canvas');
    [layer.width, layer.height] = [this.canvas.width, this.canvas.height];
    const context = layer.getContext('2d')!;
    const top_mps = Math.max(...states.map((state) => state.speed_mps));
    context.lineWidth = 4;
    context.lineCap = 'round';
    states.forEach((state, i) => {
      const next = states[(i + 1) % states.length];
      if (i + 1 === states.length && Math.hypot(next.x_m - state.x_m, next.y_m - state.y_m) > 30) return; // an open lap
      context.strokeStyle = `#${speedColor(state.speed_mps / top_mps).getHexString()}`;
      context.beginPath();
      context.moveTo(...this.toMap(state.x_m, state.y_m));
      context.lineTo(...this.toMap(next.x_m, next.y_m));
      context.stroke();
    });
    return layer;
  }

  /** Beyond the map's edge it stays at the edge. */
  private arrow(x_m: number, y_m: number, heading_rad: number, color: string, size: number): void {
    const [x, y] = this.toMap(x_m, y_m).map((v) => Math.max(size, Math.min(this.canvas.width - size, v)));
    this.context.save();
    this.context.translate(x, y);
    this.context.rotate(-heading_rad);
    this.context.fillStyle = color;
    this.context.strokeStyle = '#fff';
    this.context.lineWidth = 2;
    this.context.beginPath();
    this.context.moveTo(size, 0);
    this.context.lineTo(-0.7 * size, 0.65 * size);
    this.context.lineTo(-0.35 * size, 0);
    this.context.lineTo(-0.7 * size, -0.65 * size);
    this.context.closePath();
    this.context.stroke();
    this.context.fill();
    this.context.restore();
  }
}
