#!/usr/bin/env node
// Measures heights: all methods and samplings of `orthodrive elevate` on Kvarnbyn and on synthetic sites, for the tables and
// pictures of docs/heights.md, which it writes. Some minutes on two cores.
// Usage: tools/heights_numbers.mjs [--only kvarnbyn,pardubice,village,circuit,junction,ring,speed] [--out FOLDER] [--sites FOLDER] [--refined FILE]
//        [--tool PROGRAM] [--table]   (--table: write the page from what was measured before)
// --sites: synthetic sites village-99, circuit, junction, spielberg (the Red Bull Ring, with its surveyed heights) as `orthodrive synth` makes them (made when they lack); --refined: Kvarnbyn's
// refined roads, Pardubice's of the same name beside them (tools/refinement_numbers.mjs leaves both in out/refinement/roads). Synthetic roads are the true lines, so that heights
// alone are measured. Needs python3 to read GeoPackages and gdalwarp for the village's 2 m grid.
// What is not measured in this run keeps its last values from bench/results/heights.json.
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { cpus } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const argument = (name, fallback) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? fallback : process.argv[at + 1];
};
const tool = argument('--tool', join(root, 'build/release/orthodrive'));
const out = argument('--out', join(root, 'out/heights'));
const sites = argument('--sites', join(root, 'out/synth'));
const refined = argument('--refined', join(root, 'out/refinement/roads/kvarnbyn drawn.default.gpkg'));
const only = argument('--only', 'kvarnbyn,pardubice,village,circuit,junction,ring,speed').split(',');
const data = join(root, '../shared/data');
const store = join(root, 'bench/results/heights.json');
const numbers = existsSync(store) ? JSON.parse(readFileSync(store, 'utf8')) : { rows: {}, profiles: {} };
mkdirSync(out, { recursive: true });

const orthodrive = (...args) => execFileSync(tool, ['--quiet', ...args], { encoding: 'utf8', maxBuffer: 1 << 26, stdio: ['ignore', 'pipe', 'inherit'] });
const git = (...args) => execFileSync('git', ['-C', root, ...args], { encoding: 'utf8' }).trim();
const commit = git('rev-parse', '--short', 'HEAD') + (git('status', '--porcelain', '--untracked-files=no', '--', '.', ':!bench/results', ':!docs') ? ' + changes' : '');
// A line a row and a profile.
const lines_of = (table) => `{\n${Object.entries(table).map(([key, value]) => `  ${JSON.stringify(key)}: ${JSON.stringify(value)}`).join(',\n')}\n }`;
const save = () => writeFileSync(store, `{\n "rows": ${lines_of(numbers.rows)},\n "profiles": ${lines_of(numbers.profiles)},\n "speed": ${JSON.stringify(numbers.speed ?? null)}\n}\n`);

const methods = {
  none: ['none', ['--method', 'moving-average', '--window', '1']],
  ma11: ['moving avg. (11)', ['--method', 'moving-average', '--window', '11']],
  ma35: ['moving avg. (35)', ['--method', 'moving-average', '--window', '35']],
  ma67: ['moving avg. (67)', ['--method', 'moving-average', '--window', '67']],
  reference: ['NLO', ['--method', 'reference']],
  default: ['**default**', ['--method', 'default']],
};
const samplings = ['bilinear', 'cubic'];

// Distance, height and gradient of the nodes of one way, 4 m apart: enough for pictures.
const nodes_of = (file, osm_id) => JSON.parse(execFileSync('python3', ['-c', `
import json, sqlite3, sys
rows = sqlite3.connect(sys.argv[1]).execute('select s_m, z_m, gradient from nodes where osm_id = ? and part = 0 order by fid', (int(sys.argv[2]),)).fetchall()
kept = []
for row in rows:
    if not kept or row[0] - kept[-1][0] >= 4.0 or row is rows[-1]:
        kept.append([round(row[0], 2), round(row[1], 3), round(row[2], 5)])
print(json.dumps(kept))`, file, String(osm_id)], { encoding: 'utf8', maxBuffer: 1 << 26 }));
const longest_way = (file) => +execFileSync('python3', ['-c', `
import sqlite3, sys
print(sqlite3.connect(sys.argv[1]).execute('select osm_id from nodes where part = 0 group by osm_id order by max(s_m) desc, osm_id').fetchone()[0])`, file], { encoding: 'utf8' });

// ---- where a bare-earth grid is not the road: 45 m about decks are left out of the comparison, by what the data say and not by any
// of the methods compared. In the roads' CRS.
const around_deck_m = 45;
function write_polygons(name, epsg, places) {
  const file = join(out, `${name}_decks.geojson`);
  const ring = ([x, y]) => Array.from({ length: 17 }, (_, i) => [x + around_deck_m * Math.cos((i % 16) * Math.PI / 8), y + around_deck_m * Math.sin((i % 16) * Math.PI / 8)].map((v) => +v.toFixed(2)));
  writeFileSync(file, JSON.stringify({ type: 'FeatureCollection', crs: { type: 'name', properties: { name: `urn:ogc:def:crs:EPSG::${epsg}` } }, features: places.map((p) => ({ type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [ring(p)] } })) }));
  return file;
}
// Rows of all nodes: way, part, s_m, z_m, is a bridge or tunnel, x, y.
const all_nodes = (file) => JSON.parse(execFileSync('python3', ['-c', `
import json, sqlite3, struct, sys
db = sqlite3.connect(sys.argv[1])
deck = {k[:2]: bool(k[2] or k[3]) for k in db.execute('select osm_id, part, bridge, tunnel from centrelines')}
def place(blob):
    at = 8 + [0, 32, 48, 48, 64][(blob[3] >> 1) & 7] + 5
    return struct.unpack('<dd' if blob[3] & 1 else '>dd', blob[at:at + 16])
print(json.dumps([[i, p, s, z, deck.get((i, p), False), *place(g)] for i, p, s, z, g in db.execute('select osm_id, part, s_m, z_m, geom from nodes order by fid')]))`, file], { encoding: 'utf8', maxBuffer: 1 << 28 }));
const synthetic_decks = (name, truth) => write_polygons(name, 32633, all_nodes(truth).filter((n) => n[4]).map((n) => [n[5], n[6]]));
// Kvarnbyn's map has no tags of bridges: where roads cross water, where the terrain shows that one crosses another (findings
// elevate.assumed_bridge), and abutments: the 2 m grid rises along a road by more than any street of the world does (35 %).
function kvarnbyn_decks(truth_dtm, dtm) {
  const lines = (g) => (g.type === 'LineString' ? [g.coordinates] : g.type === 'Polygon' || g.type === 'MultiLineString' ? g.coordinates : g.type === 'MultiPolygon' ? g.coordinates.flat() : []);
  const water = JSON.parse(readFileSync(join(data, 'kvarnbyn/osm_water.geojson'), 'utf8')).features.flatMap((f) => lines(f.geometry));
  const wet = water.map((line) => line.map(utm33));
  const file = join(out, 'kvarnbyn_2m_terrain.gpkg');
  orthodrive('elevate', '--roads', refined, '--dtm', truth_dtm, '--dtm', dtm, '--method', 'moving-average', '--window', '1', '-o', file);
  const nodes = all_nodes(file), places = untagged_bridges.map(utm33);
  const crosses = (a, b, c, d) => {
    const det = (b[0] - a[0]) * (d[1] - c[1]) - (b[1] - a[1]) * (d[0] - c[0]);
    const u = ((c[0] - a[0]) * (d[1] - c[1]) - (c[1] - a[1]) * (d[0] - c[0])) / det, v = ((c[0] - a[0]) * (b[1] - a[1]) - (c[1] - a[1]) * (b[0] - a[0])) / det;
    return u >= 0 && u < 1 && v >= 0 && v < 1;
  };
  nodes.forEach((n, i) => {
    const next = nodes[i + 1];
    if (!next || next[0] !== n[0] || next[1] !== n[1]) return;
    const a = [n[5], n[6]], b = [next[5], next[6]];
    if (wet.some((line) => line.some((p, k) => k + 1 < line.length && crosses(a, b, p, line[k + 1])))) places.push(a);
    let k = i + 1;
    while (k < nodes.length && nodes[k][0] === n[0] && nodes[k][1] === n[1] && nodes[k][2] - n[2] < 5.9) ++k;
    const far = nodes[k];
    if (far && far[0] === n[0] && far[1] === n[1] && Math.abs(far[3] - n[3]) > 0.35 * (far[2] - n[2])) places.push(a);
  });
  return write_polygons('kvarnbyn', 32633, places);
}
const untagged_bridges = [[12.0341532, 57.6570488], [12.0259758, 57.6592385]];
// UTM zone 33 on WGS 84 by Krueger's series in the third flattening, to a millimetre (Karney, Transverse Mercator, 2011, eq. 35).
function utm33([lon, lat]) {
  const rad = Math.PI / 180, f = 1 / 298.257223563, n = f / (2 - f), e = Math.sqrt(f * (2 - f)), l = (lon - 15) * rad, sine = Math.sin(lat * rad);
  const radius = (6378137 / (1 + n)) * (1 + n ** 2 / 4 + n ** 4 / 64);
  const t = Math.sinh(Math.atanh(sine) - e * Math.atanh(e * sine)), xi = Math.atan2(t, Math.cos(l)), eta = Math.asinh(Math.sin(l) / Math.hypot(t, Math.cos(l)));
  const series = [n / 2 - (2 / 3) * n ** 2 + (5 / 16) * n ** 3, (13 / 48) * n ** 2 - (3 / 5) * n ** 3, (61 / 240) * n ** 3];
  let x = eta, y = xi;
  series.forEach((a, j) => { x += a * Math.cos(2 * (j + 1) * xi) * Math.sinh(2 * (j + 1) * eta), y += a * Math.sin(2 * (j + 1) * xi) * Math.cosh(2 * (j + 1) * eta); });
  return [500000 + 0.9996 * radius * x, 0.9996 * radius * y];
}

// ---- the reference's own setting: the Red Bull Ring, nodes 4 m apart, and a terrain model with one gross error
// The ways of `file` with a node every 4 m or so (all that are shared, first and last ones are kept).
function thinned(file, target) {
  copyFileSync(file, target);
  execFileSync('python3', ['-c', `
import itertools, sqlite3, sys
db = sqlite3.connect(sys.argv[1])
for (name,) in db.execute("select name from sqlite_master where type = 'trigger'").fetchall():
    db.execute(f'drop trigger "{name}"')  # those of the spatial index call functions that only GDAL has
gone = []
for _, nodes in itertools.groupby(db.execute('select osm_id, part, fid, s_m, osm_node from nodes order by osm_id, part, fid').fetchall(), key=lambda row: row[:2]):
    nodes, last_m = list(nodes), float('-inf')
    for node in nodes:
        if node is nodes[-1] or (node[4] or 0) > 0 or node[3] - last_m >= 4.0:
            last_m = node[3]
        else:
            gone.append((node[2],))
db.executemany('delete from nodes where fid = ?', gone)
db.commit()`, target]);
  return target;
}
// A dent of 6 m depth and 20 m radius (a raised cosine) at [x, y].
function dented(dtm, [x, y], target) {
  const raw = target.replace('.tif', '.bin');
  execFileSync('gdal_translate', ['-q', '-of', 'ENVI', '-ot', 'Float32', dtm, raw]);
  const { size: [columns], geoTransform: [west, gsd_x, , north, , gsd_y] } = JSON.parse(execFileSync('gdalinfo', ['-json', raw], { encoding: 'utf8' }));
  const bytes = readFileSync(raw), z = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  z.forEach((value, i) => {
    const r = Math.hypot(west + ((i % columns) + 0.5) * gsd_x - x, north + (Math.floor(i / columns) + 0.5) * gsd_y - y);
    if (r < 20) z[i] = value - 3 * (1 + Math.cos((Math.PI * r) / 20));
  });
  writeFileSync(raw, bytes);
  execFileSync('gdal_translate', ['-q', raw, target]);
  return target;
}

// truth: decks left out; with_decks: everywhere; dtm: against the grid that was used.
function measure(name, roads, dtm, truth, way, ignore) {
  const truths = { dtm: [dtm, []], truth: [truth, ignore ? ['--ignore', ignore] : []], with_decks: [truth, []] };
  for (const sampling of samplings)
    for (const [method, [, options]] of Object.entries(methods)) {
      const file = join(out, `${name}.${sampling}.${method}.gpkg`.replaceAll(' ', '_'));
      const start = Date.now();
      orthodrive('elevate', '--roads', roads, '--dtm', dtm, '--sampling', sampling, ...options, '-o', file);
      const row = { name, sampling, method, seconds: (Date.now() - start) / 1000, commit, cores: cpus().length };
      for (const [kind, [against, options]] of Object.entries(truths)) row[kind] = JSON.parse(orthodrive('evaluate', 'heights', file, against, ...options, '--json'));
      numbers.rows[`${name} ${sampling} ${method}`] = row;
      if (way && sampling === 'bilinear' && ['none', 'ma35', 'reference', 'default'].includes(method)) (numbers.profiles[name] ??= { way })[method] = nodes_of(file, way);
      const t = row.truth;
      console.log(`${name} ${sampling} ${method}: E_RG ${(1e4 * t.gradient_energy).toFixed(2)} E_h ${t.height_error_energy.toFixed(4)} z ${t.z_m.mean_abs.toFixed(3)} / ${t.z_m.p95.toFixed(3)}`
        + ` kink ${t.largest_kink.size.toExponential(1)} ${t.largest_junction_kink.size.toExponential(1)} sigma ${t.sigma_coverage['1']} clearance ${t.min_clearance_m} ${row.seconds.toFixed(1)} s`);
      save();
    }
}

if (!process.argv.includes('--table')) {
  if (only.includes('kvarnbyn')) {
    const dtm = join(data, 'kvarnbyn/dtm_10m_utm33.tif'), fine = join(data, 'kvarnbyn/dtm_2m_west.tif');
    measure('kvarnbyn 10 m', refined, dtm, fine, longest_way(refined), kvarnbyn_decks(fine, dtm));
  }
  if (only.includes('pardubice')) {  // no truth: what a town of bridges says of itself
    const dtm = join(data, 'pardubice/dtm_20m.tif'), file = join(out, 'pardubice.gpkg'), start = Date.now();
    orthodrive('elevate', '--roads', refined.replace('kvarnbyn', 'pardubice'), '--dtm', dtm, '-o', file);
    const scores = JSON.parse(orthodrive('evaluate', 'heights', file, dtm, '--json'));
    numbers.rows['pardubice 20 m cubic default'] = { name: 'pardubice 20 m', sampling: 'cubic', method: 'default', seconds: (Date.now() - start) / 1000, commit, cores: cpus().length, dtm: scores, truth: scores, with_decks: scores };
    save();
  }
  const synthetic = { village: ['village-99', '--preset', 'village', '--seed', '99'], circuit: ['circuit', '--preset', 'circuit'], junction: ['junction', '--preset', 'junction'] };
  for (const [name, [folder, ...options]] of Object.entries(synthetic)) {
    if (!only.includes(name)) continue;
    const site = join(sites, folder), truth = join(site, 'truth/roads.gpkg');
    if (!existsSync(truth)) orthodrive('synth', ...options, '-o', site);
    const way = longest_way(truth);
    const decks = synthetic_decks(name, truth);
    for (const grid of name === 'village' ? ['10 m', '2 m', '1 m'] : ['10 m', '1 m']) {
      const dtm = grid === '2 m' ? join(out, `${name}_dtm_2m.tif`) : join(site, `dtm_${grid.replace(' ', '')}.tif`);
      if (grid === '2 m') execFileSync('gdalwarp', ['-q', '-overwrite', '-r', 'average', '-tr', '2', '2', join(site, 'dtm_1m.tif'), dtm]);
      measure(`${name} ${grid}`, truth, dtm, truth, grid === '10 m' ? way : 0, decks);
    }
    numbers.profiles[`${name} 10 m`].truth = nodes_of(truth, way);
    save();
  }
  if (only.includes('ring')) {
    const site = join(sites, 'spielberg'), truth = join(site, 'truth/roads.gpkg'), track = join(data, 'spielberg');
    if (!existsSync(truth))
      orthodrive('synth', '--from-track', join(track, 'spielberg_utm33.csv'), '--track-osm', join(track, 'osm_way_red_bull_ring.osm'), '--track-heights', join(track, 'elevation_zaggyai.csv'), '-o', site);
    const roads = thinned(truth, join(out, 'ring.gpkg')), way = longest_way(truth), dtm = join(site, 'dtm_10m.tif');
    const lap = all_nodes(truth).filter((n) => n[0] === way), [, , , , , x, y] = lap[Math.floor(lap.length / 2)];
    measure('ring 10 m', roads, dtm, truth, 0, '');  // no decks
    measure('ring 10 m with an error', roads, dented(dtm, [x, y], join(out, 'ring_dented.tif')), truth, way, '');
    numbers.profiles['ring 10 m with an error'].truth = nodes_of(truth, way);
    save();
  }
  if (only.includes('speed')) {
    const lines = execFileSync(join(root, 'build/release/bench/speed/bench_heights'), { encoding: 'utf8' }).trim().split('\n');
    numbers.speed = { commit, cores: cpus().length, lines };
    save();
  }
}

// ---- pictures, as the reference's figures 3.9 and 3.10
const colors = { none: '#8a8f98', ma11: '#c7a008', ma35: '#d9820f', ma67: '#b34a1f', reference: '#2f6fde', default: '#0f9d58', truth: '#111111' };
const titles = { none: 'terrain as sampled', ma11: 'moving average (11)', ma35: 'moving average (35)', ma67: 'moving average (67)', reference: 'NLO (reference)', default: 'default', truth: 'true road' };
const ticks = (low, high, count) => {
  const raw = (high - low) / count || 1, power = 10 ** Math.floor(Math.log10(raw)), step = power * [1, 2, 5, 10].find((m) => m * power >= raw);
  const all = [];
  for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + 1e-9 * step; v += step) all.push(+v.toPrecision(12));
  return all;
};
function plot({ x, y, w, h, x_range, y_range, x_label, y_label, body }) {
  const px = (v) => x + ((v - x_range[0]) / (x_range[1] - x_range[0])) * w, py = (v) => y + h - ((v - y_range[0]) / (y_range[1] - y_range[0])) * h;
  let svg = `<rect x="${x}" y="${y}" width="${w}" height="${h}" fill="none" stroke="#999"/>`;
  for (const v of ticks(...x_range, 6)) svg += `<path d="M${px(v).toFixed(1)} ${y + h}v4" stroke="#999"/><text x="${px(v).toFixed(1)}" y="${y + h + 16}" text-anchor="middle">${v}</text>`;
  for (const v of ticks(...y_range, 5)) svg += `<path d="M${x - 4} ${py(v).toFixed(1)}h${w + 4}" stroke="#ddd"/><text x="${x - 7}" y="${(py(v) + 4).toFixed(1)}" text-anchor="end">${v}</text>`;
  svg += `<text x="${x + w / 2}" y="${y + h + 33}" text-anchor="middle">${x_label}</text><text transform="translate(${x - 48} ${y + h / 2}) rotate(-90)" text-anchor="middle">${y_label}</text>`;
  return svg + body(px, py);
}
const page_svg = (w, h, body) => `<svg xmlns="http://www.w3.org/2000/svg" width="${w}" height="${h}" viewBox="0 0 ${w} ${h}" font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="white"/>${body}</svg>\n`;
const range = (values, share = 0.06) => {
  const low = Math.min(...values), high = Math.max(...values), more = (high - low || 1) * share;
  return [low - more, high + more];
};
const row = (name, sampling, method) => numbers.rows[`${name} ${sampling} ${method}`];

// E_RG against E_h to the truth, a panel a site (10 m grid), bilinear as rings and cubic as discs.
function energies() {
  const sites_shown = ['kvarnbyn 10 m', 'village 10 m', 'circuit 10 m', 'junction 10 m'].filter((name) => row(name, 'cubic', 'default'));
  let body = '';
  sites_shown.forEach((name, i) => {
    const points = samplings.flatMap((sampling) => Object.keys(methods).map((method) => ({ sampling, method, r: row(name, sampling, method) }))).filter((p) => p.r);
    const xs = points.map((p) => 1e4 * p.r.truth.gradient_energy), ys = points.map((p) => p.r.truth.height_error_energy);
    const truth = 1e4 * points[0].r.truth.true_gradient_energy;
    body += `<text x="${70 + (i % 2) * 440}" y="${24 + Math.floor(i / 2) * 330}" font-weight="bold">${name.replace(' 10 m', '')}, 10 m grid</text>`
      + plot({ x: 70 + (i % 2) * 440, y: 34 + Math.floor(i / 2) * 330, w: 340, h: 230, x_range: range([...xs, truth]), y_range: [0, 1.08 * Math.max(...ys)], x_label: 'E_RG, 1e-4 (dashed: of the truth)', y_label: 'E_h against the truth, m2',
        body: (px, py) => `<path d="M${px(truth).toFixed(1)} ${py(0).toFixed(1)}V${py(1.08 * Math.max(...ys)).toFixed(1)}" stroke="#111" stroke-dasharray="4 3"/>`
          + points.map((p, k) => `<circle cx="${px(xs[k]).toFixed(1)}" cy="${py(ys[k]).toFixed(1)}" r="5" stroke="${colors[p.method]}" stroke-width="2" fill="${p.sampling === 'cubic' ? colors[p.method] : 'white'}"/>`).join('') });
  });
  const legend = Object.keys(methods).map((m, k) => `<circle cx="${70 + k * 148}" cy="690" r="5" fill="${colors[m]}"/><text x="${80 + k * 148}" y="694">${titles[m]}</text>`).join('');
  return page_svg(900, 710, body + legend);
}
// Height and gradient over the distance along one way.
function profile(name) {
  const p = numbers.profiles[name], kinds = ['none', 'ma35', 'reference', 'default', 'truth'].filter((k) => p[k]);
  const line = (kind, column, px, py) => `<polyline fill="none" stroke="${colors[kind]}" stroke-width="${kind === 'truth' ? 1 : 1.6}"${kind === 'truth' ? ' stroke-dasharray="5 3"' : ''} points="${p[kind].map((v) => `${px(v[0]).toFixed(1)},${py(column === 2 ? 100 * v[2] : v[column]).toFixed(1)}`).join(' ')}"/>`;
  const all = kinds.flatMap((k) => p[k]), length = Math.max(...all.map((v) => v[0]));
  const steep = range(kinds.filter((k) => k !== 'none').flatMap((k) => p[k].map((v) => 100 * v[2])), 0.3);
  const body = `<text x="70" y="22" font-weight="bold">${name}: way ${p.way}, bilinear sampling</text>`
    + plot({ x: 70, y: 34, w: 800, h: 220, x_range: [0, length], y_range: range(all.map((v) => v[1])), x_label: '', y_label: 'height, m', body: (px, py) => kinds.map((k) => line(k, 1, px, py)).join('') })
    + `<clipPath id="c"><rect x="70" y="300" width="800" height="220"/></clipPath>`
    + plot({ x: 70, y: 300, w: 800, h: 220, x_range: [0, length], y_range: steep, x_label: 'distance along the way, m', y_label: 'gradient, %', body: (px, py) => `<g clip-path="url(#c)">${kinds.map((k) => line(k, 2, px, py)).join('')}</g>` })
    + kinds.map((k, i) => `<path d="M${70 + i * 170} 572h24" stroke="${colors[k]}" stroke-width="2"/><text x="${100 + i * 170}" y="576">${titles[k]}</text>`).join('');
  return page_svg(900, 590, body);
}
const images = join(root, 'docs/images');
const pictures = [];
if (Object.keys(numbers.rows).length) writeFileSync(join(images, 'heights_energies.svg'), energies());
for (const name of Object.keys(numbers.profiles)) {
  const file = `heights_profile_${name.split(' ')[0]}.svg`;
  writeFileSync(join(images, file), profile(name));
  pictures.push(`![Height and gradient along a way of ${name.split(' ')[0]}](images/${file})\n`);
}

// ---- the page: tables between the markers of docs/heights.md
const header = (cells) => `| ${cells.join(' | ')} |\n|${cells.map(() => '---').join('|')}|\n`;
const fixed = (x, digits) => (x === null || x === undefined ? '-' : x.toFixed(digits));
const percent = (x, digits = 1) => (x === null || x === undefined ? '-' : (100 * x).toFixed(digits));
function table(name) {
  return header(['sampling', 'smoothing', 'E_RG 1e-4', 'true E_RG 1e-4', 'squared error of the gradient 1e-4', 'E_h to the DTM m2', 'E_h to the truth m2, without and with decks', 'z bias / mean / p95 m', 'gradient mean / p95 %', 'largest kink along, at junctions %', 'within 1 / 2 sigma %', 's'])
    + samplings.flatMap((sampling) => Object.keys(methods).map((method) => row(name, sampling, method)).filter(Boolean)).map((r) => {
      const t = r.truth, sigma = t.sigma_coverage['1'] === null ? '-' : `${percent(t.sigma_coverage['1'], 0)} / ${percent(t.sigma_coverage['2'], 0)}`;
      return `| ${r.sampling} | ${methods[r.method][0]} | ${fixed(1e4 * t.gradient_energy, 2)} | ${fixed(1e4 * t.true_gradient_energy, 2)} | ${fixed(1e4 * t.gradient_error_energy, 3)} | ${fixed(r.dtm.height_error_energy, 4)} | ${fixed(t.height_error_energy, 4)}, ${fixed(r.with_decks.height_error_energy, 4)}`
        + ` | ${fixed(t.z_m.bias, 3)} / ${fixed(t.z_m.mean_abs, 3)} / ${fixed(t.z_m.p95, 3)} | ${percent(t.gradient.mean_abs, 2)} / ${percent(t.gradient.p95, 2)} | ${percent(t.largest_kink.size, 3)}, ${percent(t.largest_junction_kink.size, 3)} | ${sigma} | ${r.seconds.toFixed(1)} |\n`;
    }).join('');
}
function summary() {
  const lines = [];
  const add = (what, asked, value, good) => lines.push(`| ${what} | ${asked} | ${value}${good ? '' : ' **missed**'} |\n`);
  for (const name of ['ring 10 m with an error', 'ring 10 m', 'kvarnbyn 10 m', 'village 10 m', 'circuit 10 m', 'junction 10 m'])
    for (const sampling of samplings) {
      const d = row(name, sampling, 'default')?.truth, n = row(name, sampling, 'reference')?.truth, averages = ['ma11', 'ma35', 'ma67'].map((m) => row(name, sampling, m)?.truth);
      if (!d || !n || averages.some((a) => !a)) continue;
      const truth = d.true_gradient_energy, all = (r) => row(name, sampling, r)?.with_decks.height_error_energy;
      // E_RG is a property of the profile: below that of the truth is as wrong as above.
      const best_of = (value) => Math.min(...averages.map(value));
      const e_rg = (r) => r.gradient_energy, far = (r) => Math.abs(r.gradient_energy - truth), wrong = (r) => r.gradient_error_energy, e_h = (r) => r.height_error_energy;
      const triple = (value, scale, digits) => `${fixed(scale * best_of(value), digits)}, ${fixed(scale * value(n), digits)}, ${fixed(scale * value(d), digits)}`;
      const compare = (what, best, nlo, ours, shown) => {
        add(`${name}, ${sampling}: ${what}`, 'NLO below the best average', shown, nlo < best);
        add(`${name}, ${sampling}: ${what}`, 'default below NLO', shown, ours < nlo);
      };
      add(`${name}, ${sampling}: E_RG of the best average, NLO, default (truth: ${fixed(1e4 * truth, 2)})`, 'NLO below the averages', triple(e_rg, 1e4, 2), e_rg(n) < best_of(e_rg));
      add(`${name}, ${sampling}: distance of E_RG from that of the truth`, 'default nearest', triple(far, 1e4, 2), far(d) < Math.min(best_of(far), far(n)));
      compare('squared error of the gradient', best_of(wrong), wrong(n), wrong(d), triple(wrong, 1e4, 3));
      compare('E_h to the truth, decks left out', best_of(e_h), e_h(n), e_h(d), triple(e_h, 1, 4));
      if (!/kvarnbyn|ring/.test(name)) {
        const average = Math.min(...['ma11', 'ma35', 'ma67'].map(all));
        compare('E_h to the truth, with decks', average, all('reference'), all('default'), `${fixed(average, 4)}, ${fixed(all('reference'), 4)}, ${fixed(all('default'), 4)}`);
      }
    }
  const k = row('kvarnbyn 10 m', 'cubic', 'default')?.truth, v = row('village 2 m', 'cubic', 'default')?.with_decks;
  if (k) add('Kvarnbyn, 10 m grid against the 2 m grid, bridges left out: z mean, p95', '<= 0.30, 1.0 m', `${fixed(k.z_m.mean_abs, 3)}, ${fixed(k.z_m.p95, 3)} m`, k.z_m.mean_abs <= 0.3 && k.z_m.p95 <= 1);
  if (v) add('village, 2 m grid: z mean, banking mean', '<= 0.05 m, 0.3 %', `${fixed(v.z_m.mean_abs, 3)} m, ${percent(v.banking.mean_abs, 2)} %`, v.z_m.mean_abs <= 0.05 && v.banking.mean_abs <= 0.003);
  for (const r of Object.values(numbers.rows)) {
    if (r.method !== 'default' || r.sampling !== 'cubic') continue;
    const t = r.with_decks;
    add(`${r.name}: largest jump of the gradient along roads, at junctions; step`, '<= 0.1 %, 1 mm', `${percent(t.largest_kink.size, 3)}, ${percent(t.largest_junction_kink.size, 4)} %; ${fixed(1000 * t.largest_step_m.size, 3)} mm`, t.largest_kink.size <= 1e-3 && t.largest_junction_kink.size <= 1e-3 && t.largest_step_m.size <= 1e-3);
    if (t.crossings) add(`${r.name}: least clearance at ${t.crossings} crossings of two levels`, '>= 4.7 m', `${fixed(t.min_clearance_m, 2)} m`, t.min_clearance_m >= 4.7);
    if (r.name.startsWith('pardubice')) continue;
    add(`${r.name}: heights within one sigma`, 'about 68 %', `${percent(r.truth.sigma_coverage['1'], 0)} %`, r.truth.sigma_coverage['1'] > 0.55 && r.truth.sigma_coverage['1'] < 0.8);
  }
  const large = numbers.speed?.lines.at(-1)?.match(/^([\d.]+) km.*elevate ([\d.]+) s \(([\d.]+) s CPU\).*network ([\d.]+) s \(([\d.]+) s CPU\).*peak ([\d.]+) GB/);
  if (large) add(`${large[1]} km of road: heights and network`, '<= 60 s, 2 GB', `${large[2]} s and ${large[4]} s (processor: ${large[3]} s and ${large[5]} s), ${large[6]} GB`, +large[3] + +large[5] <= 60 && +large[6] <= 2);
  return header(['number', 'asked', 'reached']) + lines.join('');
}
const page = join(root, 'docs/heights.md');
const commits = [...new Set(Object.values(numbers.rows).map((r) => r.commit))].join(', ');
let text = `Written by \`tools/heights_numbers.mjs\` from \`bench/results/heights.json\` (measured on ${commits}; two shared cores).\n\n### Asked and reached\n\n${summary()}`;
for (const name of ['ring 10 m with an error', 'ring 10 m', 'kvarnbyn 10 m', 'village 10 m', 'village 2 m', 'village 1 m', 'circuit 10 m', 'circuit 1 m', 'junction 10 m', 'junction 1 m'])
  if (row(name, 'cubic', 'default')) text += `\n### ${name[0].toUpperCase()}${name.slice(1)} grid\n\n${table(name)}`;
if (numbers.speed) text += `\n### Cost against road length (${numbers.speed.commit}, \`bench_heights\`)\n\n${numbers.speed.lines.map((l) => `    ${l}\n`).join('')}`;
text += `\n### Pictures\n\n![E_RG against E_h of all methods](images/heights_energies.svg)\n\n${pictures.join('\n')}`;
const [before, after] = ['<!-- numbers -->', '<!-- end of numbers -->'];
const old = readFileSync(page, 'utf8');
writeFileSync(page, `${old.slice(0, old.indexOf(before) + before.length)}\n\n${text}\n${old.slice(old.indexOf(after))}`);
