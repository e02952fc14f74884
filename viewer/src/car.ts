// A plain passenger car, 4.3 x 1.8 x 1.45 m, drawn where the lap says. Its frame: x ahead, y left, z up, origin on
// the road under the middle of the wheelbase.

import {
  BoxGeometry, CylinderGeometry, ExtrudeGeometry, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, Object3D,
  PlaneGeometry, Shape, Sprite, SpriteMaterial, Texture,
} from 'three';

import type {CarState} from './lap';
import {radialTexture} from './radial_texture';

const wheelRadius_m = 0.33;
const wheelbase_m = 2.6;
const track_m = 1.56;

export class Car {
  readonly object = new Group();
  /** A dot of constant size on the screen, to find the car from far away. */
  readonly marker = new Sprite(new SpriteMaterial({map: dotTexture(), sizeAttenuation: false, depthTest: false, fog: false}));
  private readonly wheels: Object3D[] = [];

  constructor() {
    const paint = new MeshLambertMaterial({color: 0xd8382c});
    const glass = new MeshLambertMaterial({color: 0x1d2730});
    const body = side([[-2.1, 0.3], [-2.15, 0.75], [-1.95, 0.95], [-0.9, 0.98], [0.95, 0.92], [1.95, 0.75], [2.15, 0.55],
                       [2.12, 0.25]]);
    const cabin = side([[-1.9, 0.93], [-1.25, 1.4], [-0.2, 1.45], [0.3, 1.38], [1.1, 0.9]]);
    this.object.add(extruded(body, 1.74, paint), extruded(cabin, 1.5, glass), extruded(roof(), 1.4, paint), shadow(), ...rearLights());
    const tyre = new CylinderGeometry(wheelRadius_m, wheelRadius_m, 0.22, 20);
    const black = new MeshLambertMaterial({color: 0x17191b});
    const rim = new CylinderGeometry(0.2, 0.2, 0.23, 5);
    const silver = new MeshLambertMaterial({color: 0xb9bec4});
    for (const x of [-wheelbase_m / 2, wheelbase_m / 2])
      for (const y of [-track_m / 2, track_m / 2]) {
        const wheel = new Group();
        wheel.add(new Mesh(tyre, black), new Mesh(rim, silver));
        wheel.position.set(x, y, wheelRadius_m);
        this.wheels.push(wheel);
        this.object.add(wheel);
      }
    this.object.rotation.order = 'ZYX'; // heading about up, then pitch about left, then roll about ahead
    this.marker.scale.setScalar(0.028);
    this.marker.renderOrder = 2;
  }

  place(state: CarState): void {
    this.object.position.set(state.x_m, state.y_m, state.z_m);
    this.object.rotation.set(state.roll_rad, -state.pitch_rad, state.heading_rad);
    for (const wheel of this.wheels) wheel.rotation.y = state.s_m / wheelRadius_m;
    this.marker.position.copy(this.object.position);
  }
}

function side(points: [number, number][]): Shape {
  const shape = new Shape();
  shape.moveTo(...points[0]);
  for (const point of points.slice(1)) shape.lineTo(...point);
  return shape;
}

function roof(): Shape {
  return side([[-1.3, 1.4], [-0.3, 1.48], [0.25, 1.42], [0.2, 1.38], [-0.3, 1.43], [-1.28, 1.36]]);
}

/** A side view (x ahead, y up) drawn out to the given width, symmetric about the car's middle plane. */
function extruded(shape: Shape, width_m: number, material: MeshLambertMaterial): Mesh {
  const bevel = 0.07;
  const geometry = new ExtrudeGeometry(shape, {
    depth: width_m - 2 * bevel, bevelEnabled: true, bevelSize: bevel, bevelThickness: bevel, bevelSegments: 2,
    bevelOffset: -bevel,
  });
  geometry.translate(0, 0, -(width_m / 2 - bevel));
  geometry.rotateX(Math.PI / 2);
  return new Mesh(geometry, material);
}

function rearLights(): Mesh[] {
  const red = new MeshBasicMaterial({color: 0xff5a4a});
  const plate = new MeshBasicMaterial({color: 0xe8ebee});
  const place = (material: MeshBasicMaterial, width_m: number, height_m: number, y: number, z: number) => {
    const mesh = new Mesh(new BoxGeometry(0.06, height_m, width_m), material);
    mesh.rotation.x = Math.PI / 2;
    mesh.position.set(-2.12, y, z);
    return mesh;
  };
  return [place(red, 0.32, 0.13, 0.66, 0.72), place(red, 0.32, 0.13, -0.66, 0.72), place(plate, 0.5, 0.11, 0, 0.5)];
}

/** A soft dark patch on the road; real shadow maps are not worth their price here. */
function shadow(): Mesh {
  const texture = radialTexture([[0, 'rgba(0,0,0,0.75)'], [0.55, 'rgba(0,0,0,0.55)'], [1, 'rgba(0,0,0,0)']]);
  const material = new MeshBasicMaterial({map: texture, transparent: true, depthWrite: false, polygonOffset: true,
                                          polygonOffsetFactor: -4, polygonOffsetUnits: -4});
  const patch = new Mesh(new PlaneGeometry(5.2, 2.7), material);
  patch.position.z = 0.04;
  return patch;
}

function dotTexture(): Texture {
  return radialTexture([[0, '#e23b2e'], [0.6, '#e23b2e'], [0.66, '#fff'], [0.9, '#fff'], [1, 'rgba(255,255,255,0)']]);
}
