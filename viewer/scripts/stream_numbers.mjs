// SPDX-License-Identifier: Apache-2.0
// What measure_stream.mjs makes of the places of a lap and of what it saw. No browser, no files.

const apart_m = 10; // places of the road ahead that are looked at
const ahead_m = 300;
const most_off_m = 0.3; // heights of the lap and of the mesh differ by less: tyres, 2 cm of the mesh, chords between rows

/** The lap as places: distance from the start, time from the start, position from the site's origin. */
export function lapPlaces(rows, origin) {
  const [t0, s0] = rows[0];
  return rows.map(([t_s, s_m, x_m, y_m, z_m]) => ({
    t_s: t_s - t0,
    s_m: s_m - s0,
    x_m: x_m - origin[0],
    y_m: y_m - origin[1],
    z_m: z_m - origin[2],
  }));
}

/** Linear between rows; the ends beyond them. `places` by s_m. */
export function placeAt(places, s_m) {
  let low = 0,
    high = places.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (places[middle].s_m <= s_m) low = middle;
    else high = middle;
  }
  const [a, b] = [places[low], places[high]];
  const share = Math.min(1, Math.max(0, b.s_m > a.s_m ? (s_m - a.s_m) / (b.s_m - a.s_m) : 0));
  return Object.fromEntries(Object.keys(a).map((name) => [name, a[name] + share * (b[name] - a[name])]));
}

/** Every 10 m of the lap, so that a hole is counted once however often it is seen. */
export function gridPlaces(places) {
  const count = Math.floor(places[places.length - 1].s_m / apart_m);
  return Array.from({length: count + 1}, (_, i) => placeAt(places, i * apart_m));
}

/** Indices of the grid's places that lie up to 300 m ahead of s_m. */
export function indicesAhead(s_m, count) {
  const first = Math.floor(s_m / apart_m) + 1,
    last = Math.min(count - 1, Math.floor((s_m + ahead_m) / apart_m));
  return Array.from({length: Math.max(0, last - first + 1)}, (_, i) => first + i);
}

/** `road`: what is drawn nearest to the place, see api.ts. A coarser tile may differ by its error. */
export function isHole(place, road) {
  return !road || Math.abs(road.z_m - place.z_m) > most_off_m + road.error_m;
}

/** Bytes of files and of the graphics card, of the tiles held at one time. */
export function heldBytes(held, fileBytes) {
  const sum = (values) => values.reduce((a, b) => a + b, 0);
  return {
    tiles: held.length,
    graphics: sum(held.map((tile) => tile.bytes)),
    files: sum(held.map((tile) => fileBytes(tile.file))),
  };
}

/** Largest numbers of a drive's pictures. `pictures`: {t_s, s_m, held, drawn, holes, coarse, visible}. */
export function summary(pictures) {
  const most = (value) => Math.max(...pictures.map(value));
  const holes = new Set(pictures.flatMap((picture) => picture.holes)),
    coarse = new Set(pictures.flatMap((picture) => picture.coarse));
  const last = pictures[pictures.length - 1];
  return {
    pictures: pictures.length,
    driven_m: last.s_m,
    seconds: last.t_s,
    longest_picture_s: most((picture) => picture.t_s - (pictures[pictures.indexOf(picture) - 1]?.t_s ?? 0)),
    graphics_mb: most(({held}) => held.graphics) / 1e6,
    file_mb: most(({held}) => held.files) / 1e6,
    tiles: most(({held}) => held.tiles),
    tiles_visible: most(({visible}) => visible),
    triangles: most(({drawn}) => drawn.triangles),
    calls: most(({drawn}) => drawn.calls),
    holes: holes.size,
    hole_places_m: [...holes]
      .sort((a, b) => a - b)
      .map((i) => i * apart_m)
      .slice(0, 20),
    coarse: coarse.size,
  };
}
