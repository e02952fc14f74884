// The two cameras: one that flies over the map, one that follows the car.

import {PerspectiveCamera, Sphere, Vector3} from 'three';
import {MapControls} from 'three/addons/controls/MapControls.js';

import type {Lap} from './lap';

const keyDirections: Record<string, [number, number, number]> = {
  KeyW: [0, 1, 0], KeyS: [0, -1, 0], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyQ: [0, 0, -1], KeyE: [0, 0, 1],
};

/** Map controls (left drag moves, right drag turns, wheel zooms) and W A S D Q E. */
export class FlyCamera {
  readonly camera = new PerspectiveCamera(50, 1, 1, 1e5);
  onChange: () => void = () => {};
  private readonly controls: MapControls;
  private readonly pressed = new Set<string>();

  constructor(element: HTMLElement) {
    this.camera.up.set(0, 0, 1);
    this.controls = new MapControls(this.camera, element);
    this.controls.zoomToCursor = true;
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    this.controls.minDistance = 2;
    this.controls.addEventListener('change', () => this.onChange());
    window.addEventListener('keydown', (event) => {
      if (event.code in keyDirections && !event.ctrlKey && !event.metaKey) this.pressed.add(event.code);
    });
    window.addEventListener('keyup', (event) => this.pressed.delete(event.code));
    window.addEventListener('blur', () => this.pressed.clear());
  }

  set enabled(on: boolean) {
    this.controls.enabled = on;
  }

  /** An oblique view from the south of everything inside the sphere. */
  frame(bounds: Sphere): void {
    this.controls.target.copy(bounds.center);
    this.camera.position.copy(bounds.center).addScaledVector(new Vector3(0.3, -1.0, 0.55).normalize(), bounds.radius * 1.45);
    this.controls.maxDistance = bounds.radius * 6;
    this.controls.update();
  }

  /** Returns true while a key moves the camera. */
  update(elapsed_s: number): boolean {
    if (this.pressed.size === 0 || !this.controls.enabled) return false;
    const ahead = new Vector3().subVectors(this.controls.target, this.camera.position);
    const speed_mps = Math.max(15, 0.6 * ahead.length());
    ahead.setZ(0).normalize();
    const right = new Vector3(ahead.y, -ahead.x, 0);
    const move = new Vector3();
    for (const key of this.pressed) {
      const [x, y, z] = keyDirections[key];
      move.addScaledVector(right, x).addScaledVector(ahead, y).add(new Vector3(0, 0, z));
    }
    move.multiplyScalar(speed_mps * elapsed_s);
    this.camera.position.add(move);
    this.controls.target.add(move);
    this.controls.update();
    return true;
  }

  /** Depth has 24 bits: the near plane moves with the distance to what is looked at, or far roads would flicker. */
  fitDepth(bounds: Sphere): void {
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.min(50, Math.max(0.3, distance * 0.02));
    this.camera.far = this.camera.position.distanceTo(bounds.center) + 2 * bounds.radius;
    this.camera.updateProjectionMatrix();
  }
}

/** Behind and above the car. A function of the lap's time alone: the same time gives the same picture. */
export class FollowCamera {
  readonly camera = new PerspectiveCamera(55, 1, 0.4, 6000);
  private readonly behind_m = 8.5;
  private readonly above_m = 2.9;
  private readonly lag_s = 0.35; // looks where the car headed a moment ago, as a driver behind it would

  constructor(private readonly lap: Lap) {
    this.camera.up.set(0, 0, 1);
  }

  update(t_s: number): void {
    const car = this.lap.at(t_s);
    const heading = this.lap.at(t_s - this.lag_s).heading_rad;
    const ahead = new Vector3(Math.cos(heading), Math.sin(heading), car.gradient);
    const position = new Vector3(car.x_m, car.y_m, car.z_m);
    this.camera.position.copy(position).addScaledVector(ahead, -this.behind_m);
    this.camera.position.z += this.above_m;
    this.camera.lookAt(position.addScaledVector(ahead, 6).add(new Vector3(0, 0, 1.1)));
  }
}
