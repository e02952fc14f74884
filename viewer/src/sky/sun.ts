// SPDX-License-Identifier: Apache-2.0
// Where the sun stands, in the scene's frame.
// Low-precision formulae of the Astronomical Almanac (U.S. Naval Observatory), sec. C: within 0.01 degrees from 1950 to 2050.

import {type Matrix4, Vector3} from 'three';

const degree = Math.PI / 180;
const j2000_ms = Date.UTC(2000, 0, 1, 12);

/** Unit vector from the centre of the Earth towards the sun, in the frame that turns with the Earth (ECEF). */
function sunInEcef(time_ms: number): Vector3 {
  const days = (time_ms - j2000_ms) / 86_400_000;
  const meanLongitude = (280.46 + 0.9856474 * days) * degree;
  const anomaly = (357.528 + 0.9856003 * days) * degree;
  const longitude = meanLongitude + (1.915 * Math.sin(anomaly) + 0.02 * Math.sin(2 * anomaly)) * degree;
  const obliquity = (23.439 - 4e-7 * days) * degree;
  const equatorial = new Vector3(
    Math.cos(longitude),
    Math.cos(obliquity) * Math.sin(longitude),
    Math.sin(obliquity) * Math.sin(longitude),
  );
  const siderealAngle = (280.46061837 + 360.98564736629 * days) * degree;
  return equatorial.applyAxisAngle(new Vector3(0, 0, 1), -siderealAngle);
}

/** Longitude of the scene's origin in degrees, on the ellipsoid or a sphere alike. */
export function longitudeOf(localFromEcef: Matrix4): number {
  const origin = new Vector3().setFromMatrixPosition(localFromEcef.clone().invert());
  return Math.atan2(origin.y, origin.x) / degree;
}

/** Hours that clocks are ahead of UTC there, without summer time and borders: one every 15 degrees. */
export function zoneHours(localFromEcef: Matrix4): number {
  return Math.round(longitudeOf(localFromEcef) / 15);
}

/** Unit vector towards the sun in the scene's frame. `date`: YYYY-MM-DD and `hour` (0 to 24) of the zone's clocks. */
export function sunDirection(localFromEcef: Matrix4, date: string, hour: number): Vector3 {
  const time_ms = Date.parse(`${date}T00:00:00Z`) + (hour - zoneHours(localFromEcef)) * 3_600_000;
  return sunInEcef(time_ms).transformDirection(localFromEcef);
}
