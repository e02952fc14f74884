// SPDX-License-Identifier: Apache-2.0
// Dimensions of the driven car: what drive/lap.xosc (OpenSCENARIO) says of it.

export interface VehicleShape {
  name: string;
  length_m: number;
  width_m: number;
  height_m: number;
  wheelbase_m: number;
  frontTrack_m: number;
  rearTrack_m: number;
  wheelRadius_m: number;
  rearOverhang_m: number; // behind the rear axle
}

/** Of an ordinary car, where there is no scenario. */
export const ordinaryCar: VehicleShape = {
  name: 'car',
  length_m: 4.3,
  width_m: 1.8,
  height_m: 1.45,
  wheelbase_m: 2.6,
  frontTrack_m: 1.56,
  rearTrack_m: 1.56,
  wheelRadius_m: 0.33,
  rearOverhang_m: 0.85,
};

/** Undefined when it does not describe a car with two axles. */
export function parseVehicleShape(xosc: string): VehicleShape | undefined {
  const text = /<Vehicle\s.*?<\/Vehicle>/s.exec(xosc)?.[0] ?? ''; // the rest, where it drives, is long
  const vehicle = new DOMParser().parseFromString(text, 'text/xml').querySelector('Vehicle');
  const number = (path: string, attribute: string) =>
    Number(vehicle?.querySelector(path)?.getAttribute(attribute) ?? NaN);
  const length_m = number('BoundingBox > Dimensions', 'length');
  const shape = {
    name: vehicle?.getAttribute('name') ?? '',
    length_m,
    width_m: number('BoundingBox > Dimensions', 'width'),
    height_m: number('BoundingBox > Dimensions', 'height'),
    wheelbase_m: number('FrontAxle', 'positionX') - number('RearAxle', 'positionX'),
    frontTrack_m: number('FrontAxle', 'trackWidth'),
    rearTrack_m: number('RearAxle', 'trackWidth'),
    wheelRadius_m: 0.5 * number('FrontAxle', 'wheelDiameter'),
    rearOverhang_m: 0.5 * length_m - number('BoundingBox > Center', 'x'),
  };
  return Object.values(shape).every((value) => typeof value === 'string' || value > 0) ? shape : undefined;
}
