// SPDX-License-Identifier: Apache-2.0
// What measure_stream.mjs counts, on laps that can be drawn: node viewer/test/stream_numbers_test.mjs

import assert from 'node:assert/strict';
import test from 'node:test';

import {gridPlaces, heldBytes, indicesAhead, isHole, lapPlaces, placeAt, summary} from '../scripts/stream_numbers.mjs';

/** 1 km straight to the east at 20 m/s, rising by a tenth; times and distances do not begin at 0. */
const rows = Array.from({length: 51}, (_, i) => [100 + i, 5 + 20 * i, 4000 + 20 * i, 7000, 300 + 2 * i]);
const places = lapPlaces(rows, [4000, 7000, 300]);

test('places count from the start and from the origin', () => {
  assert.deepEqual(places[0], {t_s: 0, s_m: 0, x_m: 0, y_m: 0, z_m: 0});
  assert.deepEqual(places[50], {t_s: 50, s_m: 1000, x_m: 1000, y_m: 0, z_m: 100});
});

test('between rows all is linear, beyond the ends it stays', () => {
  assert.deepEqual(placeAt(places, 30), {t_s: 1.5, s_m: 30, x_m: 30, y_m: 0, z_m: 3});
  assert.deepEqual(placeAt(places, 2000), places[50]);
  assert.deepEqual(placeAt(places, -1), places[0]);
});

test('a car that stands has one place', () => {
  const standing = lapPlaces(
    [
      [0, 0, 1, 2, 3],
      [1, 0, 1, 2, 3],
      [2, 10, 11, 2, 3],
    ],
    [0, 0, 0],
  );
  assert.equal(placeAt(standing, 0).x_m, 1);
  assert.equal(placeAt(standing, 5).x_m, 6);
});

test('300 m ahead are 30 places of the lap, fewer at its end', () => {
  const grid = gridPlaces(places);
  assert.equal(grid.length, 101);
  assert.equal(grid[100].x_m, 1000);
  const ahead = indicesAhead(195, grid.length);
  assert.deepEqual([ahead[0], ahead[ahead.length - 1], ahead.length], [20, 49, 30]);
  assert.deepEqual(indicesAhead(200, grid.length)[0], 21, 'the place under the car is not ahead');
  assert.deepEqual(indicesAhead(985, grid.length), [99, 100]);
  assert.deepEqual(indicesAhead(1000, grid.length), []);
});

test('a hole has no road, or one at another height than its tile may have', () => {
  const place = {z_m: 10};
  assert.ok(isHole(place, undefined));
  assert.ok(isHole(place, null));
  assert.ok(!isHole(place, {z_m: 10.02, error_m: 0}));
  assert.ok(isHole(place, {z_m: 10.5, error_m: 0}));
  assert.ok(!isHole(place, {z_m: 9, error_m: 1}), 'a coarser level may be off by its error');
  assert.ok(isHole(place, {z_m: 4, error_m: 1}), 'the road under a bridge is not the one on it');
});

test('bytes are summed over tiles, of files and of the graphics card', () => {
  const held = [
    {file: 'a', bytes: 10},
    {file: 'b', bytes: 5},
  ];
  assert.deepEqual(
    heldBytes(held, (file) => ({a: 1, b: 2})[file]),
    {tiles: 2, graphics: 15, files: 3},
  );
  assert.deepEqual(
    heldBytes([], () => assert.fail()),
    {tiles: 0, graphics: 0, files: 0},
  );
});

test('of a drive the largest numbers are told, and every hole once', () => {
  const picture = (t_s, more) => ({
    t_s,
    s_m: 50 * t_s,
    held: {tiles: 1, graphics: 1e6, files: 1e5},
    drawn: {triangles: 1, calls: 1},
    visible: 1,
    holes: [],
    coarse: [],
    ...more,
  });
  const told = summary([
    picture(0.1, {holes: [3, 4], drawn: {triangles: 9, calls: 2}}),
    picture(0.3, {holes: [4]}),
    picture(1.3, {coarse: [7], held: {tiles: 2, graphics: 3e6, files: 2e5}}),
  ]);
  assert.deepEqual(told, {
    pictures: 3,
    driven_m: 65,
    seconds: 1.3,
    longest_picture_s: 1,
    graphics_mb: 3,
    file_mb: 0.2,
    tiles: 2,
    tiles_visible: 1,
    triangles: 9,
    calls: 2,
    holes: 2,
    hole_places_m: [30, 40],
    coarse: 1,
  });
});
