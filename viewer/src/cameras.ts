// SPDX-License-Identifier: Apache-2.0
// The cameras: fly over the map, look straight down, follow the car, go around it, and sit in it.

import {type Object3D, PerspectiveCamera, type Sphere, Vector3} from 'three';
import {MapControls} from 'three/addons/controls/MapControls.js';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

import type {CarState} from './lap';

export const cameraModes = ['fly', 'top', 'follow', 'orbit', 'driver'] as const;
export type CameraMode = (typeof cameraModes)[number];

export function isAtCar(mode: CameraMode): boolean {
  return mode !== 'fly' && mode !== 'top';
}

/** Where a camera is and what it looks at, in the scene's frame. */
export interface View {
  eye: [number, number, number];
  target: [number, number, number];
}

/** At the car nothing is seen beyond: haze has taken it, and its tiles need not be loaded. */
export const sight_m = 3600;

const keyDirections: Record<string, [number, number, number]> = {
  KeyW: [0, 1, 0],
  KeyS: [0, -1, 0],
  KeyA: [-1, 0, 0],
  KeyD: [1, 0, 0],
  KeyQ: [0, 0, -1],
  KeyE: [0, 0, 1],
};

/** Map controls (left drag moves, right drag turns, wheel zooms) and W A S D Q E. */
export class FlyCamera {
  readonly camera = new PerspectiveCamera(50, 1, 1, 1e5);
  onChange: () => void = () => {};
  private readonly controls: MapControls;
  private readonly pressed = new Set<string>();

  /** `straightDown`: north is up and the view does not turn. */
  constructor(
    element: HTMLElement,
    private readonly straightDown = false,
  ) {
    this.camera.up.set(0, straightDown ? 1 : 0, straightDown ? 0 : 1);
    this.controls = new MapControls(this.camera, element);
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 2;
    if (straightDown) {
      this.controls.enableRotate = false;
      this.controls.screenSpacePanning = true;
    } else {
      this.controls.maxPolarAngle = 0.495 * Math.PI;
    }
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
  get target(): Vector3 {
    return this.controls.target;
  }
  get view(): View {
    return {eye: this.camera.position.toArray(), target: this.controls.target.toArray()};
  }
  set view(view: View) {
    this.camera.position.fromArray(view.eye);
    this.controls.target.fromArray(view.target);
    this.controls.update();
  }

  /** Everything inside the sphere: from the south and obliquely, or from above. */
  frame(bounds: Sphere): void {
    const from = this.straightDown ? new Vector3(0, 0, 1.7) : new Vector3(0.3, -1.0, 0.55).normalize();
    this.controls.target.copy(bounds.center);
    this.camera.position.copy(bounds.center).addScaledVector(from, bounds.radius * 1.45);
    this.controls.maxDistance = bounds.radius * 6;
    this.controls.update();
  }

  /** Returns true while a key moves the camera. */
  update(elapsed_s: number): boolean {
    if (this.pressed.size === 0 || !this.controls.enabled) return false;
    const ahead = this.straightDown
      ? new Vector3(0, 1, 0)
      : new Vector3().subVectors(this.controls.target, this.camera.position);
    const speed_mps = Math.max(15, 0.6 * this.camera.position.distanceTo(this.controls.target));
    ahead.setZ(0).normalize();
    const right = new Vector3(ahead.y, -ahead.x, 0);
    const move = new Vector3();
    for (const key of this.pressed) {
      const [x, y, z] = keyDirections[key];
      move
        .addScaledVector(right, x)
        .addScaledVector(ahead, y)
        .add(new Vector3(0, 0, z));
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

/** Behind and above the car. */
export const followLag_s = 0.35;
export class FollowCamera {
  readonly camera = new PerspectiveCamera(55, 1, 0.4, sight_m);
  private readonly behind_m = 8.5;
  private readonly above_m = 2.5;

  constructor() {
    this.camera.up.set(0, 0, 1);
  }

  /** `heading`: where the car headed followLag_s ago: looks there, as a driver behind it would. */
  update(car: CarState, heading: number): void {
    const ahead = new Vector3(Math.cos(heading), Math.sin(heading), car.gradient);
    const position = new Vector3(car.x_m, car.y_m, car.z_m);
    this.camera.position.copy(position).addScaledVector(ahead, -this.behind_m);
    this.camera.position.z += this.above_m;
    this.camera.lookAt(position.addScaledVector(ahead, 6).add(new Vector3(0, 0, 1.1)));
  }
}

/** Around the car at the distance and from the side that the mouse chose. */
export class OrbitCamera {
  readonly camera = new PerspectiveCamera(50, 1, 0.3, sight_m);
  onChange: () => void = () => {};
  private readonly controls: OrbitControls;
  private placed = false;

  constructor(element: HTMLElement) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enablePan = false;
    this.controls.minDistance = 3;
    this.controls.maxDistance = 200;
    this.controls.maxPolarAngle = 0.49 * Math.PI;
    this.controls.addEventListener('change', () => this.onChange());
  }

  set enabled(on: boolean) {
    this.controls.enabled = on;
  }

  /** Goes along with the car. It begins behind it: over the road, where no house stands. */
  update(car: Object3D): void {
    const middle = car.position.clone().add(new Vector3(0, 0, 0.7));
    if (!this.placed) {
      this.placed = true;
      this.controls.target.set(0, 0, 0);
      this.camera.position.set(-8.5, 2, 3).applyQuaternion(car.quaternion);
    }
    const move = middle.sub(this.controls.target);
    if (move.lengthSq() === 0) return;
    this.controls.target.add(move);
    this.camera.position.add(move);
    this.camera.lookAt(this.controls.target);
  }
}

/** At the driver's eyes: moves with the body. */
export class DriverCamera {
  readonly camera = new PerspectiveCamera(50, 1, 0.25, sight_m);

  /** `eye_m`: ahead, left and up in the car's frame. */
  constructor(private readonly eye_m: readonly [number, number, number]) {
    this.camera.up.set(0, 0, 1);
  }

  update(car: Object3D): void {
    car.updateMatrixWorld();
    const ahead_m = 20; // level: the bonnet takes a fifth of the picture
    const [x, y, z] = this.eye_m;
    this.camera.up.set(0, 0, 1).transformDirection(car.matrixWorld);
    this.camera.position.set(x, y, z).applyMatrix4(car.matrixWorld);
    this.camera.lookAt(new Vector3(x + ahead_m, y, z).applyMatrix4(car.matrixWorld));
  }
}
