#!/usr/bin/env node
// Measures the road refinement: all methods on synthetic and real sites, for the tables of docs/refinement.md, which it writes.
// Usage: tools/refinement_numbers.mjs [--only village,circuit,junction,ring,kvarnbyn,pardubice] [--methods none,default,...]
//        [--out FOLDER] [--tool PROGRAM] [--table]   (--table: write the page from what was measured before)
// Whole, with both MRF polygons and three NLO weight sets, it takes three quarters of an hour on two cores; the default alone three minutes.
// What is not measured in this run keeps its last values from bench/results/refinement.json.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { cpus } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
// A copy may be given, so that building can go on.
const argument = (name, fallback) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? fallback : process.argv[at + 1];
};
const tool = argument('--tool', join(root, 'build/release/orthodrive'));
const out = argument('--out', join(root, 'out/refinement'));
const data = join(root, '../shared/data');
const only = argument('--only', 'village,circuit,junction,ring,kvarnbyn,pardubice').split(',');
const methods = argument('--methods', 'none,mrf-dp,mrf-smooth,nlo-1,nlo-2,nlo-1+2,default').split(',');
const store = join(root, 'bench/results/refinement.json');
const numbers = existsSync(store) ? JSON.parse(readFileSync(store, 'utf8')) : { rows: {} };
mkdirSync(out, { recursive: true });

const orthodrive = (...args) => execFileSync(tool, ['--quiet', ...args], { encoding: 'utf8', maxBuffer: 1 << 26, stdio: ['ignore', 'pipe', 'inherit'] });
const git = (...args) => execFileSync('git', ['-C', root, ...args], { encoding: 'utf8' }).trim();
const commit = git('rev-parse', '--short', 'HEAD') + (git('status', '--porcelain', '--untracked-files=no', '--', '.', ':!bench/results', ':!docs') ? ' + changes' : '');
const save = () => writeFileSync(store, JSON.stringify(numbers, null, 1) + '\n');
const make = (path, command) => {
  if (!existsSync(path)) command();
  return path;
};

// OSM moved by a smooth field of 1 to 4 m whose direction turns once in 1.7 km.
function disturb(from, to) {
  const text = readFileSync(from, 'utf8');
  const nodes = [...text.matchAll(/<node [^>]*lat="([-\d.]+)" lon="([-\d.]+)"/g)];
  const lat0 = nodes.reduce((sum, m) => sum + +m[1], 0) / nodes.length, lon0 = nodes.reduce((sum, m) => sum + +m[2], 0) / nodes.length;
  const north = 111320, east = 111320 * Math.cos((lat0 * Math.PI) / 180);
  writeFileSync(to, text.replace(/lat="([-\d.]+)" lon="([-\d.]+)"/g, (_, lat, lon) => {
    const x = (lon - lon0) * east, y = (lat - lat0) * north;
    const size = 2.5 + 1.5 * Math.sin(x / 230 + y / 310 + 1), direction = 2 * Math.PI * (x / 1700 + 0.3 * Math.sin(y / 500));
    return `lat="${(+lat + (size * Math.sin(direction)) / north).toFixed(8)}" lon="${(+lon + (size * Math.cos(direction)) / east).toFixed(8)}"`;
  }));
}

const synthetic = {
  village: ['--preset', 'village', '--seed', '99'],
  circuit: ['--preset', 'circuit'],
  junction: ['--preset', 'junction'],
  ring: ['--from-track', join(data, 'spielberg/spielberg_utm33.csv'), '--track-osm', join(data, 'spielberg/osm_way_red_bull_ring.osm'),
    '--track-heights', join(data, 'spielberg/elevation_zaggyai.csv')],
};
const photos = { kvarnbyn: join(data, 'kvarnbyn/ortho.jpg'), pardubice: join(data, 'pardubice/ortho.tif') };

function segment(photo, folder) {
  const labels = join(folder, 'labels.tif'), probability = join(folder, 'road_probability.tif');
  if (!existsSync(probability)) orthodrive('segment', photo, '-o', labels, '--road-probability', probability);
  return { labels, probability };
}

// The network's labels with the hand-made test pieces of models/truth as their painters see them: what a network without
// errors would leave to do.
function paint(name, site, given) {
  const classes = ['ground', 'road', 'parking', 'building', 'vegetation', 'grass', 'water', 'rail'];
  const labels = join(site, 'painted_labels.tif'), probability = join(site, 'painted_road_probability.tif'), polygons = join(site, 'painted.gpkg');
  if (existsSync(labels) && existsSync(probability)) return { labels, probability };
  const crs = JSON.parse(execFileSync('gdalinfo', ['-json', given.labels], { encoding: 'utf8', maxBuffer: 1 << 26 })).coordinateSystem.wkt;
  rmSync(polygons, { force: true });
  execFileSync('ogr2ogr', [polygons, join(root, 'models/truth/handmade.geojson'), '-nln', 'pieces', '-t_srs', crs, '-where', `piece LIKE '${name[0]}%'`]);
  const draw = (from, to, value) => {  // in the order of the file
    execFileSync('gdal_translate', ['-q', from, to]);
    execFileSync('gdal_rasterize', ['-q', '-dialect', 'sqlite', '-sql', `SELECT ${value} AS v, geom FROM pieces WHERE class <> 'unknown' ORDER BY fid`, '-a', 'v', polygons, to]);
  };
  draw(given.labels, labels, `CASE class ${classes.map((c, i) => `WHEN '${c}' THEN ${i}`).join(' ')} END`);
  draw(given.probability, probability, "CASE class WHEN 'road' THEN 255 ELSE 0 END");
  return { labels, probability };
}

// Runs a method and scores it. `given`: photo, osm, labels, probability (of the default, where there is one).
function measure(name, method, given, truth, more = []) {
  const folder = join(out, 'roads');
  mkdirSync(folder, { recursive: true });
  const file = (m) => join(folder, `${name}.${m}.gpkg`);
  const forests = join(root, `out/forests/forests_${photos[name.split(' ')[0]] ? 'real' : 'villages'}.yml`);
  if (method.startsWith('mrf') && !existsSync(forests)) execFileSync(join(root, 'tools/train_forests'), { stdio: 'inherit' });
  const options = {
    none: ['--method', 'none'],
    'mrf-dp': ['--method', 'mrf', '--photo', given.photo, '--forests', forests, '--polygons', 'dp'],
    'mrf-smooth': ['--method', 'mrf', '--photo', given.photo, '--forests', forests, '--polygons', 'smooth'],
    'nlo-1': ['--method', 'nlo', '--weights', '1'], 'nlo-2': ['--method', 'nlo', '--weights', '2'], 'nlo-1+2': ['--method', 'nlo', '--weights', '1+2'],
    default: given.probability ? ['--road-probability', given.probability] : [],
  };
  const labels = (m) => (m.startsWith('mrf') ? [] : ['--labels', given.labels]);
  const refine = (m) => orthodrive('refine', '--osm', given.osm, ...labels(m), '-o', file(m), ...options[m]);
  if (!existsSync(file('none'))) refine('none');
  const start = Date.now();
  refine(method);
  const seconds = (Date.now() - start) / 1000;
  const scores = JSON.parse(orthodrive('evaluate', 'roads', file(method), truth, '--before', file('none'), ...more, '--json'));
  numbers.rows[`${name} ${method}`] = { name, method, seconds, commit, cores: cpus().length, ...scores };
  save();
  const p = (x) => (x === null || x === undefined ? '-' : x.toFixed(3));
  console.log(`${name} ${method}: IoU ${p(scores.surface_iou)} offset ${p(scores.offset_m.mean_abs)} / ${p(scores.offset_m.p95)} width ${p(scores.width_m.mean_abs)}`
    + ` sigma ${p(scores.sigma_coverage['1'])} away ${p(scores.moved_away?.share_by_more_than_0_3_m)} ${seconds.toFixed(1)} s`);
}

if (!process.argv.includes('--table')) {
  for (const [name, options] of Object.entries(synthetic)) {
    if (!only.includes(name)) continue;
    const site = join(out, name);
    make(join(site, 'ortho.tif'), () => orthodrive('synth', ...options, '--gsd', '0.2', '-o', site));
    const given = { photo: join(site, 'ortho.tif'), osm: join(site, 'roads.osm') }, truth = join(site, 'truth');
    for (const method of methods) {
      if (!method.startsWith('mrf')) measure(`${name} true`, method, { ...given, labels: join(truth, 'labels.tif') }, truth);  // it reads the photo
      measure(`${name} predicted`, method, { ...given, ...segment(given.photo, site) }, truth);
    }
  }
  for (const [name, photo] of Object.entries(photos)) {
    if (!only.includes(name)) continue;
    const site = join(out, name);
    mkdirSync(site, { recursive: true });
    const given = { photo, ...segment(photo, site), osm: join(data, name, 'roads.osm') };
    const drawn = Object.fromEntries(['', '_area', '_unmapped'].map((part) => {
      const all = JSON.parse(readFileSync(join(root, `models/truth/carriageways${part}.geojson`), 'utf8'));
      const path = join(site, `carriageways${part}.geojson`);
      const features = all.features.filter((f) => (f.properties.piece ?? f.properties.id ?? f.properties.of).startsWith(name[0]));
      writeFileSync(path, JSON.stringify({ type: 'FeatureCollection', features }));
      return [part, path];
    }));
    const disturbed = join(site, 'disturbed.osm');
    disturb(given.osm, disturbed);
    for (const method of methods) {
      measure(`${name} drawn`, method, given, drawn[''], ['--area', drawn._area, '--ignore', drawn._unmapped]);
      if (method === 'default') measure(`${name} painted`, method, { ...given, ...paint(name, site, given) }, drawn[''], ['--area', drawn._area, '--ignore', drawn._unmapped]);
      measure(`${name} disturbed`, method, { ...given, osm: disturbed }, join(out, 'roads', `${name} drawn.none.gpkg`));
    }
  }
}

if (only.includes('speed') && !process.argv.includes('--table')) {
  const lines = execFileSync(join(root, 'build/release/bench/speed/bench_refine'), { encoding: 'utf8' }).trim().split('\n').slice(1);
  numbers.speed = { commit, cores: cpus().length, cases: lines.map((line) => {
    const [nodes, km, seconds, , gb] = line.match(/[\d.]+/g).map(Number);
    return { nodes, km, seconds, gb };
  }) };
  save();
}

// The page: tables between the markers of docs/refinement.md.
const row = (name, method) => numbers.rows[`${name} ${method}`];
const percent = (x) => (x === null || x === undefined ? '-' : (100 * x).toFixed(1));
const metres = (x) => (x === null || x === undefined ? '-' : x.toFixed(2));
const titles = { none: 'raw OSM', 'mrf-dp': 'MRF, Douglas-Peucker', 'mrf-smooth': 'MRF, smooth', 'nlo-1': 'NLO set 1', 'nlo-2': 'NLO set 2', 'nlo-1+2': 'NLO set 1+2', default: '**default**' };
const all = Object.keys(titles);
titles.painted = 'default, the pieces\' labels painted by hand';
const header = (cells) => `| ${cells.join(' | ')} |\n|${cells.map(() => '---').join('|')}|\n`;
function table(name, known) {
  const rows = all.map((m) => row(name, m)).filter(Boolean);
  const painted = row(name.replace('drawn', 'painted'), 'default');
  if (known && painted) rows.push({ ...painted, method: 'painted' });
  if (rows.length === 0) return 'Not measured.\n';
  return header(['method', 'surface IoU %', ...(known ? ['of known ways %'] : []), 'offset bias / mean / p95 m', 'width bias / mean / p95 m', 'width variance m2', 'largest jump of curvature 1/m', 'within 1 / 2 sigma: offset, width %', 'moved away by > 0.3 m %', 's'])
    + rows.map((r) => {
      const o = r.offset_m, w = r.width_m, s = r.sigma_coverage, sigma = s['1'] === null ? '-' : `${percent(s['1'])} / ${percent(s['2'])}, ${percent(s.width?.['1'])} / ${percent(s.width?.['2'])}`;
      return `| ${titles[r.method]} | ${percent(r.surface_iou)} | ${known ? `${percent(r.surface_iou_of_known_ways)} | ` : ''}${metres(o.bias)} / ${metres(o.mean_abs)} / ${metres(o.p95)} | ${metres(w.bias)} / ${metres(w.mean_abs)} / ${metres(w.p95)}`
        + ` | ${metres(r.width_variance_m2)} | ${metres(r.largest_curvature_jump.per_m)} | ${sigma} | ${r.method === 'none' ? '-' : percent(r.moved_away?.share_by_more_than_0_3_m)} | ${r.seconds.toFixed(1)} |\n`;
    }).join('');
}
function disturbedTable(name) {
  const rows = all.map((m) => row(name, m)).filter(Boolean);
  return header(['method', 'distance to the undisturbed line: mean / p95 m', 'matched %', 's'])
    + rows.map((r) => `| ${titles[r.method]} | ${metres(r.offset_m.mean_abs)} / ${metres(r.offset_m.p95)} | ${percent(r.matched_share)} | ${r.seconds.toFixed(1)} |\n`).join('');
}
const reached = (good) => (good ? '' : ' **missed**');
function summary() {
  const lines = [];
  const add = (what, asked, value, good) => lines.push(`| ${what} | ${asked} | ${value}${reached(good)} |\n`);
  for (const name of ['village', 'circuit', 'junction']) {
    const d = row(`${name} predicted`, 'default'), n = row(`${name} predicted`, 'nlo-1+2');
    if (!d) continue;
    add(`${name}, predicted labels: surface IoU`, '>= 90 %', `${percent(d.surface_iou)} %`, d.surface_iou >= 0.9);
    if (n) add(`${name}: above NLO 1+2`, '>= 3 points', `${percent(d.surface_iou - n.surface_iou)} points`, d.surface_iou - n.surface_iou >= 0.03);
    const m = [row(`${name} predicted`, 'mrf-dp'), row(`${name} predicted`, 'mrf-smooth')].filter(Boolean);
    if (m.length) {
      const above = d.surface_iou - Math.max(...m.map((r) => r.surface_iou));
      add(`${name}: above MRF, the better of both polygons`, '> 0', `${percent(above)} points`, above > 0);
    }
    add(`${name}: offset mean, p95`, '<= 0.20, 0.60 m', `${metres(d.offset_m.mean_abs)}, ${metres(d.offset_m.p95)} m`, d.offset_m.mean_abs <= 0.2 && d.offset_m.p95 <= 0.6);
    add(`${name}: width mean error`, '<= 0.35 m', `${metres(d.width_m.mean_abs)} m`, d.width_m.mean_abs <= 0.35);
    add(`${name}: within one sigma (offset, width)`, '55-80 %', `${percent(d.sigma_coverage['1'])}, ${percent(d.sigma_coverage.width['1'])} %`, [d.sigma_coverage['1'], d.sigma_coverage.width['1']].every((x) => x >= 0.55 && x <= 0.8));
  }
  for (const name of ['kvarnbyn', 'pardubice']) {
    const d = row(`${name} disturbed`, 'default'), h = row(`${name} drawn`, 'default');
    if (d) add(`${name} disturbed by 1-4 m: mean distance to the undisturbed line`, '<= 0.9 m', `${metres(d.offset_m.mean_abs)} m`, d.offset_m.mean_abs <= 0.9);
    if (!h) continue;
    add(`${name}, drawn carriageways: surface IoU (of ways the painters know)`, '>= 80 %', `${percent(h.surface_iou)} (${percent(h.surface_iou_of_known_ways)}) %`, h.surface_iou >= 0.8);
    add(`${name}: offset mean`, '<= 0.5 m', `${metres(h.offset_m.mean_abs)} m`, h.offset_m.mean_abs <= 0.5);
    add(`${name}: width mean error`, '<= 0.8 m', `${metres(h.width_m.mean_abs)} m`, h.width_m.mean_abs <= 0.8);
    add(`${name}: moved away by more than 0.3 m`, '<= 10 %', `${percent(h.moved_away.share_by_more_than_0_3_m)} %`, h.moved_away.share_by_more_than_0_3_m <= 0.1);
    add(`${name}: within one sigma (offset, width)`, '55-80 %', `${percent(h.sigma_coverage['1'])}, ${percent(h.sigma_coverage.width['1'])} %`, [h.sigma_coverage['1'], h.sigma_coverage.width['1']].every((x) => x >= 0.55 && x <= 0.8));
    if (name === 'pardubice') add('Pardubice, 245 km: time of `refine`', '<= 60 s', `${h.seconds.toFixed(0)} s`, h.seconds <= 60);
  }
  const ring = row('ring predicted', 'default');
  if (ring) {
    add('Red Bull Ring, predicted labels: lap length', '4318 m +- 0.2 %', `${ring.length_m.toFixed(0)} m (${percent(ring.length_m / 4318 - 1)} %)`, Math.abs(ring.length_m / 4318 - 1) <= 0.002);
    add('Red Bull Ring: edges, mean', '<= 0.5 m', `${metres(ring.edge_m.mean_abs)} m`, ring.edge_m.mean_abs <= 0.5);
  }
  const speed = numbers.speed?.cases.find((c) => c.nodes >= 17714);
  if (speed) add(`${speed.nodes} nodes over 400 Mpx`, '<= 20 s, 3 GB', `${speed.seconds.toFixed(1)} s, ${speed.gb.toFixed(1)} GB`, speed.seconds <= 20 && speed.gb <= 3);
  return header(['number', 'asked', 'reached']) + lines.join('');
}
const page = join(root, 'docs/refinement.md');
const commits = [...new Set(Object.values(numbers.rows).map((r) => r.commit))].join(', ');
let text = `Written by \`tools/refinement_numbers.mjs\` from \`bench/results/refinement.json\` (measured on ${commits}; two shared cores).\n\n### Asked and reached\n\n${summary()}`;
for (const [name, title] of [['village', 'Village (seed 99, unseen by the network)'], ['circuit', 'Circuit'], ['junction', 'Motorway junction'], ['ring', 'Red Bull Ring']])
  for (const labels of ['predicted', 'true']) if (row(`${name} ${labels}`, 'default')) text += `\n### ${title}, ${labels} labels\n\n${table(`${name} ${labels}`)}`;
for (const [name, title] of [['kvarnbyn', 'Kvarnbyn'], ['pardubice', 'Pardubice']]) {
  if (row(`${name} drawn`, 'default')) text += `\n### ${title}, hand-drawn carriageways\n\n${table(`${name} drawn`, true)}`;
  if (row(`${name} disturbed`, 'default')) text += `\n### ${title}, OSM disturbed by a smooth field of 1 to 4 m\n\n${disturbedTable(`${name} disturbed`)}`;
}
if (numbers.speed) {
  text += `\n### Cost against road length (${numbers.speed.commit}, 400 Mpx of labels, \`bench_refine\`)\n\n` + header(['nodes', 'km', 's', 'nodes a second', 'peak GB'])
    + numbers.speed.cases.map((c) => `| ${c.nodes} | ${c.km.toFixed(1)} | ${c.seconds.toFixed(2)} | ${(c.nodes / c.seconds).toFixed(0)} | ${c.gb.toFixed(2)} |\n`).join('');
}
const [before, after] = ['<!-- numbers -->', '<!-- end of numbers -->'];
const old = readFileSync(page, 'utf8');
writeFileSync(page, `${old.slice(0, old.indexOf(before) + before.length)}\n\n${text}\n${old.slice(old.indexOf(after))}`);
