// SPDX-License-Identifier: Apache-2.0
// The parts of a passenger car of given dimensions: bodywork, windows, lamps, mirrors, and what the driver has before him.

import {
  BoxGeometry,
  type BufferGeometry,
  CylinderGeometry,
  Group,
  type Material,
  Mesh,
  type Object3D,
  SphereGeometry,
  TorusGeometry,
  Vector3,
} from 'three';

import {bodySurface, cabin, cabinSurface, capOf, type Patch, patchOf, type Surface} from './car_body';
import type {CarMaterials} from './car_materials';
import {merged} from './merged';
import type {VehicleShape} from './vehicle_shape';

/** Both sides of the car. */
const mirrored = ({u, v, ...rest}: Patch): Patch[] => [
  {u, v, ...rest},
  {u, v: [-v[1], -v[0]], ...rest},
];

/** Where the body ends behind the middle between the axles. */
const rearOf = (shape: VehicleShape) => -0.5 * shape.wheelbase_m - shape.rearOverhang_m;

export function bodyParts(shape: VehicleShape, materials: CarMaterials): Object3D[] {
  const {length_m, wheelbase_m, wheelRadius_m} = shape;
  const rear_m = rearOf(shape);
  const uOf = (x_m: number) => (x_m - rear_m) / length_m;
  const body = bodySurface(shape);
  const arch = (1.14 * wheelRadius_m) / length_m;
  const breaks = [uOf(-0.5 * wheelbase_m), uOf(0.5 * wheelbase_m)].flatMap((axle) =>
    [
      -1.001, -1, -0.995, -0.97, -0.92, -0.85, -0.7, -0.5, -0.25, 0, 0.25, 0.5, 0.7, 0.85, 0.92, 0.97, 0.995, 1, 1.001,
    ].map((share) => axle + share * arch),
  );
  const ends = [0.004, 0.008, 0.014, 0.02, 0.97, 0.98, 0.986, 0.992, 0.996];
  const panel = (patch: Patch, material: Material, on: Surface = body) => new Mesh(patchOf(on, patch), material);
  const line = (u: number, v: [number, number]) =>
    mirrored({u: [u - 6e-4, u + 6e-4], v, off_m: 0.002, columns: 1, rows: 24}).map((p) => panel(p, materials.gap));
  const parts: Object3D[] = [
    ...mirrored({u: [0, 1], v: [0.4, 1], columns: 56, rows: 20, breaks: [...breaks, ...ends]}).map((p) =>
      panel(p, materials.paint),
    ),
    panel({u: [0, cabin.rear + 0.02], v: [-0.4, 0.4], columns: 6, breaks: ends}, materials.paint), // no lid over the seats
    panel({u: [cabin.front - 0.03, 1], v: [-0.4, 0.4], columns: 20, breaks: ends}, materials.paint),
    new Mesh(capOf(body, 0), materials.trim),
    new Mesh(capOf(body, 1), materials.trim),
    ...line(0.7, [0.45, 0.97]),
    ...line(0.452, [0.42, 0.97]),
    ...line(uOf(-0.5 * wheelbase_m) + 1.25 * arch, [0.42, 0.9]),
    ...mirrored({u: [0.74, 0.965], v: [0.38, 0.386], off_m: 0.002, columns: 16, rows: 1}).map((p) =>
      panel(p, materials.gap),
    ),
    panel({u: [0.9655, 0.967], v: [-0.386, 0.386], off_m: 0.002, columns: 1, rows: 24}, materials.gap),
    ...mirrored({u: [0.1, 0.9], v: [0.93, 1], off_m: 0.004, columns: 40, rows: 2, breaks}).map((p) =>
      panel(p, materials.trim),
    ),
    // Lamps reach around the corners; between them the grille and below it an intake.
    ...mirrored({u: [0.932, 0.988], v: [0.44, 0.6], off_m: 0.006}).map((p) => panel(p, materials.headlamp)),
    panel({u: [0.982, 0.999], v: [-0.4, 0.4], off_m: 0.006, rows: 24}, materials.trim),
    panel({u: [0.975, 1], v: [0.9, 1], off_m: 0.006}, materials.trim),
    panel({u: [0.975, 1], v: [-1, -0.9], off_m: 0.006}, materials.trim),
    ...mirrored({u: [0.002, 0.045], v: [0.5, 0.7], off_m: 0.006}).map((p) => panel(p, materials.rearLamp)),
    ...mirrored({u: [0, 0.04], v: [0.9, 1], off_m: 0.006}).map((p) => panel(p, materials.trim)),
  ];
  return [...parts, ...attachedParts(shape, materials, body)];
}

function box(size: [number, number, number], at: [number, number, number], material: Material): Mesh {
  const mesh = new Mesh(new BoxGeometry(...size), material);
  mesh.position.set(...at);
  return mesh;
}

/** What is put onto the body: number plates, what is seen of its underside, door handles and mirrors. */
function attachedParts(shape: VehicleShape, materials: CarMaterials, body: Surface): Object3D[] {
  const {length_m, width_m, height_m, wheelbase_m, wheelRadius_m} = shape;
  const rear_m = rearOf(shape);
  const nose_m = rear_m + length_m;
  const parts: Object3D[] = [
    box([0.012, 0.52, 0.11], [nose_m + 0.012, 0, 0.27 * height_m], materials.plate),
    box([0.012, 0.52, 0.11], [rear_m - 0.01, 0, 0.4 * height_m], materials.plate),
    ...wheelHousings(shape, materials.gap),
    box(
      [wheelbase_m + 2 * wheelRadius_m, Math.min(shape.frontTrack_m, shape.rearTrack_m) - 0.4, 0.2 * height_m],
      [0, 0, 0.31 * height_m],
      materials.gap,
    ),
  ];
  for (const side of [-1, 1]) {
    for (const u of [0.47, 0.665]) {
      const at = body(u - 0.03, side * 0.66);
      parts.push(box([0.17, 0.03, 0.025], [at.x, at.y + side * 0.012, at.z - 0.02], materials.paint));
    }
    parts.push(
      ...mirrorParts(
        new Vector3(rear_m + 0.655 * length_m, side * (0.5 * width_m + 0.035), 0.685 * height_m),
        side,
        materials,
      ),
    );
  }
  return parts;
}

/** Dark half tubes over the wheels. */
function wheelHousings(
  {wheelbase_m, frontTrack_m, rearTrack_m, wheelRadius_m}: VehicleShape,
  material: Material,
): Mesh[] {
  const depth_m = 0.3,
    radius_m = 1.15 * wheelRadius_m;
  return [
    [0.5 * wheelbase_m, frontTrack_m],
    [-0.5 * wheelbase_m, rearTrack_m],
  ].flatMap(([x_m, track_m]) =>
    [-1, 1].map((side) => {
      const tube = new CylinderGeometry(radius_m, radius_m, depth_m, 24, 1, true, -0.5 * Math.PI, Math.PI);
      const housing = new Mesh(tube, material);
      housing.position.set(x_m, side * (0.5 * track_m - 0.07), wheelRadius_m);
      return housing;
    }),
  );
}

/** Of which one sees the glass from the driver's seat. */
function mirrorParts(at: Vector3, side: number, {paint, mirror, trim}: CarMaterials): Mesh[] {
  const shell = new Mesh(new SphereGeometry(1, 20, 14), paint);
  shell.scale.set(0.075, 0.105, 0.07);
  shell.position.copy(at).setY(at.y + side * 0.07);
  const foot = new Mesh(new BoxGeometry(0.05, 0.1, 0.025), trim);
  foot.position.copy(at).add(new Vector3(0.02, 0, -0.05));
  const glass = new Mesh(new SphereGeometry(1, 20, 2, 0, 2 * Math.PI, 0, 0.5), mirror);
  glass.rotation.set(0, -0.5 * Math.PI, 0);
  glass.scale.set(0.11, 0.18, 0.02);
  glass.position.copy(shell.position).add(new Vector3(-0.06, 0, 0));
  return [shell, foot, glass];
}

/** Windows, roof and pillars. The glass is dark from outside; from inside one looks through. */
export function cabinParts(shape: VehicleShape, materials: CarMaterials): Object3D[] {
  const surface = cabinSurface(shape);
  const whole: Patch = {u: [cabin.rear, cabin.front], v: [-1, 1], columns: 64, rows: 48};
  const outside: Patch[] = [
    {u: [0.135, 0.565], v: [-0.655, 0.655], off_m: 0.006, columns: 40, rows: 40}, // roof
    ...mirrored({u: [0.56, cabin.front], v: [0.41, 0.655], off_m: 0.006}), // A pillars
    ...mirrored({u: [cabin.rear, 0.14], v: [0.41, 0.655], off_m: 0.006}), // C pillars
    ...mirrored({u: [cabin.rear, 0.2], v: [0.65, 1], off_m: 0.006}),
  ];
  const parts: Mesh[] = [
    new Mesh(patchOf(surface, whole), materials.glass),
    ...outside.map((patch) => new Mesh(patchOf(surface, patch), materials.paint)),
  ];
  for (const patch of mirrored({u: [0.412, 0.436], v: [0.65, 1], off_m: 0.003}))
    parts.push(new Mesh(patchOf(surface, patch), materials.trim));
  // Their linings, as seen from the seats.
  const inside: Patch[] = [
    {u: [0.135, 0.565], v: [-0.655, 0.655], off_m: -0.015, columns: 30, rows: 30},
    ...mirrored({u: [0.55, cabin.front], v: [0.5, 0.6], off_m: -0.015}),
  ];
  return [...parts, ...inside.map((patch) => new Mesh(patchOf(surface, patch), materials.cabin))];
}

export interface Cockpit {
  parts: Object3D[];
  column: Object3D; // holds the steering wheel
  wheel: Object3D; // turns about its own x
}

/** Dashboard, steering wheel and mirror before the driver's eyes. */
export function cockpit(
  shape: VehicleShape,
  eye_m: readonly [number, number, number],
  materials: CarMaterials,
): Cockpit {
  const {length_m, width_m, height_m, wheelbase_m, rearOverhang_m} = shape;
  const front_m = -0.5 * wheelbase_m - rearOverhang_m + cabin.front * length_m;
  const [eyeX_m, eyeY_m, eyeZ_m] = eye_m;
  const top_m = 0.615 * height_m;
  const edge_m = eyeX_m + 0.62; // of the dashboard, towards the driver
  const dashboard = new Mesh(dashGeometry(edge_m, front_m - 0.02, 0.86 * width_m, top_m), materials.cabin);
  const cowl = new Mesh(new BoxGeometry(0.25, 0.6 * width_m, 0.08), materials.cabin); // closes the gap below the bonnet
  cowl.position.set(front_m + 0.06, 0, top_m - 0.075);
  const binnacle = new Mesh(new SphereGeometry(1, 24, 12), materials.cabin);
  binnacle.scale.set(0.13, 0.19, 0.07);
  binnacle.position.set(edge_m + 0.08, eyeY_m, top_m - 0.015);
  const wheel = new Group();
  const rim_m = 0.185;
  wheel.add(...merged([rimOf(rim_m, materials)]));
  const column = new Group();
  column.position.set(eyeX_m + 0.44, eyeY_m, eyeZ_m - 0.375);
  column.rotation.y = 0.42; // the wheel leans towards the driver
  column.add(wheel);
  const mirror = new Group();
  const back = new Mesh(new BoxGeometry(0.03, 0.25, 0.065), materials.trim),
    glass = new Mesh(new BoxGeometry(0.004, 0.235, 0.052), materials.mirror);
  glass.position.x = -0.017;
  mirror.add(back, glass);
  mirror.position.set(eyeX_m + 0.34, 0, Math.min(eyeZ_m + 0.12, 0.9 * height_m));
  mirror.rotation.z = 0.35;
  return {parts: [dashboard, cowl, binnacle, mirror], column, wheel};
}

/** A rim of leather with three spokes, in the plane across x. */
function rimOf(radius_m: number, {trim, cabin: lining, metal}: CarMaterials): Object3D {
  const group = new Group();
  const rim = new Mesh(new TorusGeometry(radius_m, 0.0165, 12, 48), trim);
  rim.rotation.y = Math.PI / 2;
  const hub = new Mesh(new SphereGeometry(1, 20, 12), lining);
  hub.scale.set(0.035, 0.075, 0.06);
  group.add(rim, hub);
  for (const angle of [0, Math.PI, 1.5 * Math.PI]) {
    const spoke = new Mesh(new BoxGeometry(0.014, radius_m, 0.035), angle > 4 ? metal : lining);
    spoke.geometry.translate(0, 0.5 * radius_m, 0);
    spoke.rotation.x = angle;
    group.add(spoke);
  }
  return group;
}

/** Rounded towards the driver, falling a little to the windscreen. */
function dashGeometry(edge_m: number, front_m: number, width_m: number, top_m: number): BufferGeometry {
  const profile: [number, number][] = [
    [edge_m + 0.05, top_m - 0.4],
    [edge_m - 0.03, top_m - 0.16],
    [edge_m - 0.02, top_m - 0.07],
    [edge_m, top_m - 0.03],
    [edge_m + 0.04, top_m - 0.008],
    [edge_m + 0.12, top_m],
    [front_m, top_m - 0.025],
  ];
  const columns = 24;
  const geometry = new CylinderGeometry(1, 1, 1, profile.length - 1, columns, true);
  const position = geometry.getAttribute('position');
  for (let row = 0; row <= columns; ++row)
    profile.forEach(([x, z], i) => {
      const across = 1 - (2 * row) / columns;
      const bow = 0.1 * across * across; // nearer to the windscreen's bow in the middle
      position.setXYZ(row * profile.length + i, x - bow * (x > edge_m + 0.1 ? 1 : 0.2), 0.5 * width_m * across, z);
    });
  geometry.computeVertexNormals();
  return geometry;
}
