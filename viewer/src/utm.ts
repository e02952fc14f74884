// SPDX-License-Identifier: Apache-2.0
// WGS84 longitude and latitude to UTM, for what is given as GeoJSON.
// Krueger's series to the third order in n, good to a millimetre within 3000 km of the central meridian:
// Karney, Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85 (2011), eq. 7-9 and 35.

const flattening = 1 / 298.257223563;
const n = flattening / (2 - flattening);
const rectifyingRadius_m = (6378137 / (1 + n)) * (1 + n ** 2 / 4 + n ** 4 / 64);
const alpha = [
  n / 2 - (2 / 3) * n ** 2 + (5 / 16) * n ** 3,
  (13 / 48) * n ** 2 - (3 / 5) * n ** 3,
  (61 / 240) * n ** 3,
];
const scale = 0.9996;

export interface UtmZone {
  centralMeridianDeg: number;
  falseNorthing_m: number;
}

/** "EPSG:32633" and the like; undefined for any other CRS. */
export function utmZone(crs: string): UtmZone | undefined {
  const match = /^EPSG:32([67])(\d\d)$/.exec(crs);
  if (!match) return undefined;
  return {centralMeridianDeg: Number(match[2]) * 6 - 183, falseNorthing_m: match[1] === '7' ? 1e7 : 0};
}

export function utmFromGeographic(zone: UtmZone, longitudeDeg: number, latitudeDeg: number): [number, number] {
  const latitude = (latitudeDeg * Math.PI) / 180;
  const longitude = ((longitudeDeg - zone.centralMeridianDeg) * Math.PI) / 180;
  const e = Math.sqrt(flattening * (2 - flattening));
  const t = Math.sinh(Math.atanh(Math.sin(latitude)) - e * Math.atanh(e * Math.sin(latitude)));
  const xi = Math.atan2(t, Math.cos(longitude));
  const eta = Math.asinh(Math.sin(longitude) / Math.hypot(t, Math.cos(longitude)));
  let x = eta,
    y = xi;
  alpha.forEach((a, i) => {
    const k = 2 * (i + 1);
    x += a * Math.cos(k * xi) * Math.sinh(k * eta);
    y += a * Math.sin(k * xi) * Math.cosh(k * eta);
  });
  return [500000 + scale * rectifyingRadius_m * x, zone.falseNorthing_m + scale * rectifyingRadius_m * y];
}
