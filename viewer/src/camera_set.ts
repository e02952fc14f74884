// SPDX-License-Identifier: Apache-2.0
// All cameras, and which of them is looked through.

import {type PerspectiveCamera, type Sphere, Vector3} from 'three';
import {
  type CameraMode,
  DriverCamera,
  FlyCamera,
  FollowCamera,
  isAtCar,
  OrbitCamera,
  sight_m,
  type View,
} from './cameras';
import type {Car} from './car/car';
import type {CarState} from './lap';

/** Around which the sun's shadows are drawn. */
export interface Focus {
  middle: Vector3;
  radius_m: number;
}

export class CameraSet {
  onChange: () => void = () => {};
  private chosen: CameraMode = 'fly';
  private readonly fly: FlyCamera;
  private readonly top: FlyCamera;
  private readonly follow = new FollowCamera();
  private car?: Car;
  private orbit?: OrbitCamera;
  private driver?: DriverCamera;
  private bounds?: Sphere;

  /** Without a car only the cameras over the map. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.fly = new FlyCamera(canvas);
    this.top = new FlyCamera(canvas, true);
    this.fly.onChange = this.top.onChange = () => this.onChange();
  }

  adoptCar(car: Car): void {
    this.car = car;
    this.orbit = new OrbitCamera(this.canvas);
    this.orbit.enabled = false;
    this.orbit.onChange = () => this.onChange();
    this.driver = new DriverCamera(car.eye_m);
    this.resize(this.fly.camera.aspect);
  }

  get modes(): Partial<Record<CameraMode, string>> {
    return {fly: 'Fly', top: 'Top', ...(this.car ? {follow: 'Follow', orbit: 'Orbit', driver: 'Driver'} : {})};
  }

  get mode(): CameraMode {
    return this.chosen;
  }
  set mode(mode: CameraMode) {
    this.chosen = mode in this.modes ? mode : 'fly';
    this.fly.enabled = this.chosen === 'fly';
    this.top.enabled = this.chosen === 'top';
    if (this.orbit) this.orbit.enabled = this.chosen === 'orbit';
  }
  get next(): CameraMode {
    const names = Object.keys(this.modes) as CameraMode[];
    return names[(names.indexOf(this.chosen) + 1) % names.length];
  }
  // biome-ignore lint/suspicious/useGetterReturn: tsc sees that every mode has its case.
  get active(): PerspectiveCamera {
    switch (this.chosen) {
      case 'fly':
        return this.fly.camera;
      case 'top':
        return this.top.camera;
      case 'follow':
        return this.follow.camera;
      case 'orbit':
        return this.orbit!.camera;
      case 'driver':
        return this.driver!.camera;
    }
  }
  get atCar(): boolean {
    return isAtCar(this.chosen);
  }
  /** Of the cameras that the mouse moves over the map. */
  get view(): View | undefined {
    return this.atCar ? undefined : this.map.view;
  }
  /** Of the one that is looked through, or that was last. */
  set view(view: View) {
    this.map.view = view;
  }
  private get map(): FlyCamera {
    return this.chosen === 'top' ? this.top : this.fly;
  }

  resize(aspect: number): void {
    for (const camera of [
      this.fly.camera,
      this.top.camera,
      this.follow.camera,
      this.orbit?.camera,
      this.driver?.camera,
    ]) {
      if (!camera) continue;
      camera.aspect = aspect;
      camera.updateProjectionMatrix();
    }
  }

  /** Looks at all of the site, or where `view` says. */
  adoptBounds(bounds: Sphere, view: View | undefined): void {
    this.bounds = bounds;
    this.fly.frame(bounds);
    this.top.frame(bounds);
    if (view) this.map.view = view;
  }

  /** Returns true while keys move a camera. */
  update(elapsed_s: number): boolean {
    return this.fly.update(elapsed_s) || this.top.update(elapsed_s);
  }

  /** Goes along with the car, which headed `headingBefore` a moment ago. */
  goWith(state: CarState, headingBefore: number): void {
    this.follow.update(state, headingBefore);
    this.orbit!.update(this.car!.object);
    this.driver!.update(this.car!.object);
  }

  fitDepth(): void {
    if (!this.bounds) return;
    this.fly.fitDepth(this.bounds);
    this.top.fitDepth(this.bounds);
  }

  /** Where haze begins and where it has taken all. */
  get haze_m(): [number, number] {
    if (this.atCar || !this.bounds) return [sight_m / 6, sight_m];
    const distance_m = this.active.position.distanceTo(this.bounds.center);
    return [0.5 * distance_m, 4 * distance_m];
  }

  /** The road ahead of the car, or what the camera looks at. */
  get focus(): Focus {
    const {active} = this;
    if (this.atCar) {
      const ahead = active.getWorldDirection(new Vector3());
      return {middle: this.car!.object.position.clone().addScaledVector(ahead, 60), radius_m: 110};
    }
    const {target} = this.map;
    return {middle: target, radius_m: Math.min(1500, Math.max(40, 0.8 * active.position.distanceTo(target)))};
  }
}
