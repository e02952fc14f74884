// SPDX-License-Identifier: Apache-2.0
// The driven car where the lap says: its wheels turn, steer and follow the road. Its frame: x ahead, y left, z up, origin
// on the road under the middle of the wheelbase.

import {
  Group,
  type Material,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  PlaneGeometry,
  Sprite,
  SpriteMaterial,
  type Texture,
} from 'three';
import type {CarState} from '../lap';
import {radialTexture} from '../radial_texture';
import {type CarMaterials, carMaterials} from './car_materials';
import {bodyParts, cabinParts, cockpit} from './car_parts';
import {merged} from './merged';
import type {VehicleShape} from './vehicle_shape';
import {makeWheel, wheelMaterials} from './wheel';

const maxTravel_m = 0.2; // of a wheel against the body
const ghostOpacity = 0.4;
const steeringRatio = 14; // of the steering wheel to the wheels

/** A wheel: steered as a whole, turned about its own axle. */
interface Wheel {
  holder: Group;
  spinning: Group;
  x_m: number;
  y_m: number;
  height: 'z_fl_m' | 'z_fr_m' | 'z_rl_m' | 'z_rr_m';
  isFront: boolean;
}

export class Car {
  readonly object = new Group();
  /** A dot of constant size on the screen, to find the car from far away. */
  readonly marker: Sprite;
  /** Of the driver, in the car's frame: left seat, in the middle of the cabin. */
  readonly eye_m: readonly [number, number, number];
  private readonly wheels: Wheel[];
  private readonly patch = shadow();
  private readonly materials: CarMaterials;
  private readonly steeringWheel: Object3D;

  constructor(
    private readonly shape: VehicleShape,
    colors: {paint: number; dot: string} = {paint: 0x9a120c, dot: '#e23b2e'},
  ) {
    const {length_m, width_m, height_m, wheelbase_m, rearOverhang_m} = shape;
    this.materials = carMaterials(colors.paint);
    this.eye_m = [0.015 * wheelbase_m, 0.2 * width_m, 0.83 * height_m];
    const {parts, column, wheel} = cockpit(shape, this.eye_m, this.materials);
    this.steeringWheel = wheel;
    this.object.add(
      ...merged([...bodyParts(shape, this.materials), ...cabinParts(shape, this.materials), ...parts]),
      column,
      this.patch,
    );
    this.patch.scale.set(1.2 * length_m, 1.5 * width_m, 1);
    this.patch.position.x = 0.5 * length_m - 0.5 * wheelbase_m - rearOverhang_m;
    this.wheels = this.makeWheels();
    this.object.rotation.order = 'ZYX'; // heading about up, then pitch about left, then roll about ahead
    this.object.traverse(
      (part) => (part.castShadow = part !== this.patch && (part as Mesh).material !== this.materials.glass),
    );
    this.marker = new Sprite(
      new SpriteMaterial({map: dotTexture(colors.dot), sizeAttenuation: false, depthTest: false, fog: false}),
    );
    this.marker.scale.setScalar(0.028);
    this.marker.renderOrder = 2;
  }

  /** A soft patch under the car where the sun casts no shadows. */
  set hasSoftShadow(on: boolean) {
    this.patch.visible = on;
  }

  place(state: CarState): void {
    this.object.position.set(state.x_m, state.y_m, state.z_m);
    this.object.rotation.set(state.roll_rad, -state.pitch_rad, state.heading_rad);
    for (const wheel of this.wheels) {
      const plane_m = state.z_m + wheel.x_m * Math.sin(state.pitch_rad) + wheel.y_m * Math.sin(state.roll_rad);
      const road_m = state[wheel.height] ?? plane_m;
      const travel_m = Math.max(-maxTravel_m, Math.min(maxTravel_m, road_m - plane_m));
      wheel.holder.position.z = this.shape.wheelRadius_m + travel_m;
      wheel.holder.rotation.z = wheel.isFront ? (state.steering_rad ?? 0) : 0;
      wheel.spinning.rotation.y = state.s_m / this.shape.wheelRadius_m;
    }
    this.steeringWheel.rotation.x = -steeringRatio * (state.steering_rad ?? 0);
    this.materials.rearLamp.emissiveIntensity = (state.brake ?? 0) > 0.02 ? 1.2 : 0.25;
    this.marker.position.copy(this.object.position);
  }

  private makeWheels(): Wheel[] {
    const {wheelbase_m, frontTrack_m, rearTrack_m, wheelRadius_m} = this.shape;
    const materials = wheelMaterials();
    const wheels: Wheel[] = [];
    for (const isFront of [true, false])
      for (const isLeft of [true, false]) {
        const wheel: Wheel = {
          holder: new Group(),
          spinning: makeWheel(wheelRadius_m, materials),
          isFront,
          x_m: (isFront ? 0.5 : -0.5) * wheelbase_m,
          y_m: (isLeft ? 0.5 : -0.5) * (isFront ? frontTrack_m : rearTrack_m),
          height: `z_${isFront ? 'f' : 'r'}${isLeft ? 'l' : 'r'}_m`,
        };
        wheel.holder.add(wheel.spinning);
        wheel.holder.position.set(wheel.x_m, wheel.y_m, wheelRadius_m);
        this.object.add(wheel.holder);
        wheels.push(wheel);
      }
    return wheels;
  }
}

/** A car that one sees through, in another colour. */
export function makeGhost(shape: VehicleShape): Car {
  const ghost = new Car(shape, {paint: 0x2f6fb3, dot: '#2f6fb3'});
  ghost.hasSoftShadow = false;
  ghost.object.traverse((part) => {
    if (!(part instanceof Mesh)) return;
    Object.assign(part.material as Material, {transparent: true, opacity: ghostOpacity});
    part.castShadow = false;
  });
  return ghost;
}

function shadow(): Mesh {
  const texture = radialTexture([
    [0, 'rgba(0,0,0,0.75)'],
    [0.55, 'rgba(0,0,0,0.55)'],
    [1, 'rgba(0,0,0,0)'],
  ]);
  const material = new MeshBasicMaterial({
    map: texture,
    transparent: true,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -4,
    polygonOffsetUnits: -4,
  });
  const patch = new Mesh(new PlaneGeometry(1, 1), material);
  patch.position.z = 0.04;
  return patch;
}

function dotTexture(color: string): Texture {
  return radialTexture([
    [0, color],
    [0.6, color],
    [0.66, '#fff'],
    [0.9, '#fff'],
    [1, 'rgba(255,255,255,0)'],
  ]);
}
