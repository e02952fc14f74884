// A passenger car of the driven vehicle's dimensions, drawn where the lap says: its wheels turn, steer and follow the
// road. Its frame: x ahead, y left, z up, origin on the road under the middle of the wheelbase.

import {
  BoxGeometry, ExtrudeGeometry, Group, Material, Mesh, MeshBasicMaterial, MeshLambertMaterial, Object3D, PlaneGeometry,
  Shape, Sprite, SpriteMaterial, Texture,
} from 'three';

import type {CarState} from './lap';
import {radialTexture} from './radial_texture';
import type {VehicleShape} from './vehicle_shape';
import {makeWheel, wheelMaterials} from './wheel';

const maxTravel_m = 0.2; // of a wheel against the body
const ghostOpacity = 0.4;

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

  constructor(private readonly shape: VehicleShape, colors: {paint: number; dot: string} = {paint: 0xd8382c, dot: '#e23b2e'}) {
    const {length_m, width_m, height_m, wheelbase_m, rearOverhang_m} = shape;
    const rear = -0.5 * wheelbase_m - rearOverhang_m;
    // Side view: shares of the length from the rear, and of the height.
    const outline = (points: [number, number][]) => side(points.map(([x, z]) => [rear + x * length_m, z * height_m]));
    const paint = new MeshLambertMaterial({color: colors.paint});
    const glass = new MeshLambertMaterial({color: 0x1d2730});
    const cabin = outline([[0.06, 0.64], [0.21, 0.965], [0.45, 1], [0.57, 0.95], [0.755, 0.59]]);
    const roof = outline([[0.2, 0.945], [0.21, 0.972], [0.45, 1.008], [0.565, 0.96], [0.56, 0.94], [0.45, 0.985]]);
    this.object.add(extruded(bodyOf(shape), 0.97 * width_m, paint), innerOf(shape), extruded(cabin, 0.84 * width_m, glass), extruded(roof, 0.78 * width_m, paint),
                    ...rearLights(rear, width_m, height_m), this.patch);
    this.patch.scale.set(1.2 * length_m, 1.5 * width_m, 1);
    this.patch.position.x = rear + 0.5 * length_m;
    this.eye_m = [0.03 * wheelbase_m, 0.2 * width_m, 0.84 * height_m];
    this.wheels = this.makeWheels();
    this.object.rotation.order = 'ZYX'; // heading about up, then pitch about left, then roll about ahead
    this.object.traverse((part) => (part.castShadow = part !== this.patch));
    this.marker = new Sprite(new SpriteMaterial({map: dotTexture(colors.dot), sizeAttenuation: false, depthTest: false, fog: false}));
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
      wheel.holder.rotation.z = wheel.isFront ? state.steering_rad ?? 0 : 0;
      wheel.spinning.rotation.y = state.s_m / this.shape.wheelRadius_m;
    }
    this.marker.position.copy(this.object.position);
  }

  private makeWheels(): Wheel[] {
    const {wheelbase_m, frontTrack_m, rearTrack_m, wheelRadius_m} = this.shape;
    const materials = wheelMaterials();
    const wheels: Wheel[] = [];
    for (const isFront of [true, false])
      for (const isLeft of [true, false]) {
        const wheel: Wheel = {
          holder: new Group(), spinning: makeWheel(wheelRadius_m, materials), isFront,
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

/** Side view of the body, with openings above the wheels that show how far these have moved. */
function bodyOf({length_m, height_m, wheelbase_m, wheelRadius_m, rearOverhang_m}: VehicleShape): Shape {
  const axle_m = 0.5 * wheelbase_m, rear = -axle_m - rearOverhang_m;
  const arch_m = 1.16 * wheelRadius_m, lower_m = 0.17 * height_m;
  const below_rad = Math.asin(Math.max(0, wheelRadius_m - lower_m) / arch_m); // the openings' ends are below the axles
  const beside_m = axle_m + arch_m + 0.02;
  const points: [number, number][] = [[0.014, 0.26], [0, 0.52], [0.045, 0.655], [0.29, 0.67], [0.72, 0.605], [0.95, 0.47], [1, 0.35], [0.99, 0.22]];
  const body = side([[Math.min(rear + 0.1 * length_m, -beside_m), lower_m], ...points.map(([x, z]): [number, number] => [rear + x * length_m, z * height_m])]);
  body.lineTo(Math.max(rear + 0.9 * length_m, beside_m), lower_m);
  for (const x_m of [axle_m, -axle_m]) body.absarc(x_m, wheelRadius_m, arch_m, -below_rad, Math.PI + below_rad, false);
  return body;
}

/** What is seen through the openings, between the wheels. */
function innerOf({height_m, wheelbase_m, frontTrack_m, rearTrack_m, wheelRadius_m}: VehicleShape): Mesh {
  const [bottom_m, top_m] = [0.2 * height_m, 0.42 * height_m];
  const box = new BoxGeometry(wheelbase_m + 2 * wheelRadius_m, Math.min(frontTrack_m, rearTrack_m) - 0.34, top_m - bottom_m);
  const inner = new Mesh(box, new MeshLambertMaterial({color: 0x0c0d0e}));
  inner.position.z = 0.5 * (bottom_m + top_m);
  return inner;
}

function side(points: [number, number][]): Shape {
  const shape = new Shape();
  shape.moveTo(...points[0]);
  for (const point of points.slice(1)) shape.lineTo(...point);
  return shape;
}

/** A side view (x ahead, y up) drawn out to the given width, symmetric about the car's middle plane. */
function extruded(shape: Shape, width_m: number, material: MeshLambertMaterial): Mesh {
  const bevel = 0.07;
  const geometry = new ExtrudeGeometry(shape, {
    curveSegments: 24, depth: width_m - 2 * bevel, bevelEnabled: true, bevelSize: bevel, bevelThickness: bevel, bevelSegments: 2,
    bevelOffset: -bevel,
  });
  geometry.translate(0, 0, -(width_m / 2 - bevel));
  geometry.rotateX(Math.PI / 2);
  return new Mesh(geometry, material);
}

function rearLights(rear: number, width_m: number, height_m: number): Object3D[] {
  const red = new MeshBasicMaterial({color: 0xff5a4a});
  const plate = new MeshBasicMaterial({color: 0xe8ebee});
  const place = (material: MeshBasicMaterial, lightWidth_m: number, lightHeight_m: number, y: number, z: number) => {
    const mesh = new Mesh(new BoxGeometry(0.06, lightHeight_m, lightWidth_m), material);
    mesh.rotation.x = Math.PI / 2;
    mesh.position.set(rear + 0.02, y, z);
    return mesh;
  };
  const [y, z] = [0.37 * width_m, 0.5 * height_m];
  return [place(red, 0.32, 0.13, y, z), place(red, 0.32, 0.13, -y, z), place(plate, 0.5, 0.11, 0, 0.345 * height_m)];
}

function shadow(): Mesh {
  const texture = radialTexture([[0, 'rgba(0,0,0,0.75)'], [0.55, 'rgba(0,0,0,0.55)'], [1, 'rgba(0,0,0,0)']]);
  const material = new MeshBasicMaterial({map: texture, transparent: true, depthWrite: false, polygonOffset: true,
                                          polygonOffsetFactor: -4, polygonOffsetUnits: -4});
  const patch = new Mesh(new PlaneGeometry(1, 1), material);
  patch.position.z = 0.04;
  return patch;
}

function dotTexture(color: string): Texture {
  return radialTexture([[0, color], [0.6, color], [0.66, '#fff'], [0.9, '#fff'], [1, 'rgba(255,255,255,0)']]);
}
