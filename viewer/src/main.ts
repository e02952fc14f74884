// The viewer of a built site: scene, cameras, page, and the loop that draws when something has changed.

import './style.css';

import {PerspectiveCamera, Scene, Sphere, Vector2, WebGLRenderer} from 'three';

import {Car} from './car';
import {FlyCamera, FollowCamera} from './cameras';
import {FindingsLayer} from './findings_layer';
import type {CarState} from './lap';
import * as panel from './panel';
import {routeLine} from './route_line';
import {loadSite, Site} from './site';
import {Sky} from './sky';
import {Layers, TileLayers} from './tile_layers';

type CameraMode = 'fly' | 'follow';
type LayerName = keyof Layers | 'route' | 'findings';

/** What scripts and tests can ask and do: window.orthodrive. */
interface Api {
  readonly ready: boolean; // all tiles of the present view are loaded and drawn
  readonly frame: number; // pictures drawn so far
  readonly tilesLoaded: number;
  readonly tilesVisible: number;
  readonly failures: string[];
  readonly mode: CameraMode;
  readonly car: CarState | undefined; // x, y, z from the site's origin
  readonly cameraPosition: [number, number, number];
  /** Height of the first surface below a place 2 m above z_m: what wheels at z_m should stand on. */
  groundUnder(x_m: number, y_m: number, z_m: number): number | undefined;
  setCamera(mode: CameraMode): void;
  setLayer(layer: LayerName, on: boolean): void;
  setTime(t_s: number): void;
  setPlaying(on: boolean): void;
}

declare global {
  interface Window {
    orthodrive: Api;
  }
}

function start(site: Site): Api {
  const parameters = new URLSearchParams(location.search);
  const canvas = document.getElementById('canvas') as HTMLCanvasElement;
  const renderer = new WebGLRenderer({canvas, antialias: true});
  const scene = new Scene();
  const sky = new Sky(scene);
  const tiles = new TileLayers(site.localFromEcef, renderer.capabilities.getMaxAnisotropy());
  const findings = new FindingsLayer(site);
  const fly = new FlyCamera(canvas);
  scene.add(tiles.group, findings.object);

  const lap = site.lap;
  const follow = lap && new FollowCamera(lap);
  const car = lap && new Car();
  const route = lap && routeLine(lap);
  if (car && route) scene.add(car.object, car.marker, route);

  let mode: CameraMode = 'fly';
  let time_s = Number(parameters.get('t') ?? 0);
  let rate = 1;
  let playing = lap !== undefined && parameters.get('play') !== '0';
  let bounds: Sphere | undefined;
  let frame = 0;
  let stale = true; // the picture shows an earlier state
  let ready = false; // no tile is missing in the picture
  const invalidate = () => {
    stale = true;
    ready = false;
  };
  tiles.onChange = fly.onChange = invalidate;

  const modes: Partial<Record<CameraMode, string>> = lap ? {fly: 'Fly', follow: 'Follow car'} : {fly: 'Fly'};
  const showMode = panel.segments('cameras', modes, setCamera);
  function setCamera(wanted: CameraMode): void {
    mode = follow ? wanted : 'fly';
    fly.enabled = mode === 'fly';
    if (car) car.marker.visible = mode === 'fly';
    showMode(mode);
    invalidate();
  }
  function setPlaying(on: boolean): void {
    playing = on && lap !== undefined;
    panel.showPlaying(playing);
  }
  function setTime(t_s: number): void {
    time_s = t_s;
    invalidate();
  }

  const switches = new Map<LayerName, HTMLInputElement>();
  function setLayer(layer: LayerName, on: boolean): void {
    switches.get(layer)!.checked = on;
    if (layer === 'route') route!.visible = on;
    else if (layer === 'findings') findings.object.visible = on;
    else tiles.setLayer(layer, on);
    if (layer === 'photo') sky.setRelief(!on);
    invalidate();
  }
  const addLayer = (layer: LayerName, label: string, on: boolean) =>
    switches.set(layer, panel.addSwitch(layer, label, on, (checked) => setLayer(layer, checked)));
  addLayer('photo', 'Orthophoto', true);
  addLayer('materials', 'Road materials', true);
  addLayer('terrain', 'Terrain', true);
  addLayer('roads', 'Roads', true);
  addLayer('buildings', 'Buildings', true);
  addLayer('trees', 'Trees', true);
  addLayer('wireframe', 'Wireframe', false);
  if (lap) addLayer('route', 'Driven route', true);
  if (findings.findings.length > 0) addLayer('findings', `Findings (${findings.findings.length})`, false);

  const keys = ['W A S D Q E fly', 'left drag move', 'right drag turn', 'wheel zoom', ...(lap ? ['C camera', 'Space play'] : [])];
  panel.showTexts(site.name, site.attribution, keys.join(' · '));
  if (lap) panel.setUpTimeline(lap, {seek: setTime, togglePlay: () => setPlaying(!playing), setRate: (factor) => (rate = factor)});
  setCamera(parameters.get('camera') === 'follow' ? 'follow' : 'fly');
  setPlaying(playing);

  const viewport = new Vector2();
  function resize(): void {
    viewport.set(window.innerWidth, window.innerHeight);
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    renderer.setSize(viewport.x, viewport.y, false);
    for (const view of [fly.camera, follow?.camera]) {
      if (!view) continue;
      view.aspect = viewport.x / viewport.y;
      view.updateProjectionMatrix();
    }
    invalidate();
  }
  window.addEventListener('resize', resize);
  window.addEventListener('keydown', (event) => {
    if (!lap || event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
    if (event.code === 'KeyC') setCamera(mode === 'fly' ? 'follow' : 'fly');
    if (event.code === 'Space') setPlaying(!playing), event.preventDefault();
  });
  canvas.addEventListener('click', (event) => {
    const place = new Vector2((2 * event.clientX) / viewport.x - 1, 1 - (2 * event.clientY) / viewport.y);
    const finding = findings.at(place, activeCamera(), viewport);
    panel.showMessage(finding ? `${finding.code}: ${finding.message}` : '', false);
  });

  function activeCamera(): PerspectiveCamera {
    return mode === 'follow' ? follow!.camera : fly.camera;
  }

  /** The tileset is there: look at all of it, and let the haze begin where the site ends. */
  function adoptBounds(): void {
    bounds = tiles.bounds();
    if (bounds) fly.frame(bounds);
  }

  function placeCar(): void {
    if (!lap || !car || !follow) return;
    const state = lap.at(time_s);
    car.place(state);
    follow.update(time_s);
    panel.showDashboard(state, lap.originHeight_m);
  }

  function draw(): void {
    if (bounds) {
      fly.fitDepth(bounds);
      const reach_m = mode === 'follow' ? 1200 : activeCamera().position.distanceTo(bounds.center);
      sky.setHazeRange(0.5 * reach_m, (mode === 'follow' ? 3 : 4) * reach_m);
    }
    renderer.render(scene, activeCamera());
    ++frame;
  }

  let last_ms = performance.now();
  function tick(now_ms: number): void {
    const elapsed_s = Math.min(0.25, (now_ms - last_ms) / 1000); // a hidden page stands still
    last_ms = now_ms;
    if (!bounds) adoptBounds();
    if (fly.update(elapsed_s)) invalidate();
    if (playing) {
      time_s += rate * elapsed_s;
      stale = true;
    }
    if (findings.dropOnto(tiles)) stale = true;
    if (stale || !ready) {
      placeCar();
      activeCamera().updateMatrixWorld();
      tiles.update(activeCamera(), renderer); // tells of new tiles through onChange
      if (stale) draw();
      stale = false;
      ready = tiles.complete && tiles.visible > 0;
    }
    if (tiles.failures.length > 0) panel.showMessage(tiles.failures[0], true);
    requestAnimationFrame(tick);
  }
  resize();
  requestAnimationFrame(tick);

  return {
    get ready() { return ready; },
    get frame() { return frame; },
    get tilesLoaded() { return tiles.loaded; },
    get tilesVisible() { return tiles.visible; },
    get failures() { return tiles.failures; },
    get mode() { return mode; },
    get car() { return lap?.at(time_s); },
    get cameraPosition() { return activeCamera().position.toArray() as [number, number, number]; },
    groundUnder: (x_m, y_m, z_m) => tiles.heightAt(x_m, y_m, z_m + 2),
    setCamera, setLayer, setTime, setPlaying,
  };
}

try {
  window.orthodrive = start(await loadSite());
} catch (error) {
  panel.showMessage((error as Error).message, true);
  throw error;
}
