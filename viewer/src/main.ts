// The viewer of a built site: scene, cameras, page, and the loop that draws when something has changed.

import './style.css';

import {PCFShadowMap, PerspectiveCamera, Scene, Sphere, Vector2, Vector3, WebGLRenderer} from 'three';

import {Car} from './car';
import {CameraMode, DriverCamera, FlyCamera, FollowCamera, followLag_s, OrbitCamera} from './cameras';
import {Dashboard} from './dashboard';
import {DriverInput} from './driver_input';
import {FindingsLayer} from './findings_layer';
import type {CarState} from './lap';
import {MapInset} from './map_inset';
import * as panel from './panel';
import {routeLine} from './route_line';
import {SelfDrive} from './self_drive';
import {loadSite, Site} from './site';
import {Sky} from './sky';
import {sunDirection, zoneHours} from './sun';
import {Layers, TileLayers} from './tile_layers';
import {parseView, writeView} from './view_link';

type LayerName = keyof Layers | 'shadows' | 'route' | 'findings';

/** What scripts and tests can ask and do: window.orthodrive. */
interface Api {
  readonly ready: boolean; // all tiles of the present view are loaded and drawn
  readonly frame: number; // pictures drawn so far
  readonly tilesLoaded: number;
  readonly tilesVisible: number;
  readonly failures: string[];
  readonly mode: CameraMode;
  readonly car: CarState | undefined; // x, y, z from the site's origin
  readonly driving: boolean; // somebody drives, no lap is shown
  readonly wheelsOnRoad: number; // of the car that somebody drives
  readonly cameraPosition: [number, number, number];
  readonly sun: [number, number, number]; // towards it
  readonly link: string; // address that restores the view
  /** What stands or lies under a place of the picture, -1..1 to the right and up. */
  describe(x: number, y: number): Promise<Record<string, string>>;
  /** Height of the first surface below a place 2 m above z_m: what wheels at z_m should stand on. */
  groundUnder(x_m: number, y_m: number, z_m: number): number | undefined;
  setCamera(mode: CameraMode): void;
  setLayer(layer: LayerName, on: boolean): void;
  setTime(t_s: number): void;
  setPlaying(on: boolean): void;
  /** Takes over the car where it is in the lap, or gives it back. */
  setDriving(on: boolean): Promise<void>;
  /** `date`: YYYY-MM-DD, `hour`: 0 to 24 of the zone's clocks. */
  setDay(date: string, hour: number): void;
}

declare global {
  interface Window {
    orthodrive: Api;
  }
}

function makeRenderer(canvas: HTMLCanvasElement): WebGLRenderer {
  try {
    const renderer = new WebGLRenderer({canvas, antialias: true});
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = PCFShadowMap;
    return renderer;
  } catch {
    throw new Error('This browser gives no WebGL 2, with which the scene is drawn. Switch on hardware acceleration in its settings, or use another browser.');
  }
}

/** One line of what was clicked on. */
function textOf(what: Record<string, string>): string {
  const {kind, id, name, type, osm_id: osm, class: label, role} = what;
  const parts = [kind && `${kind}${id ? ` ${id}` : ''}`, name, type, osm && `OSM ${osm}`, label && `${label} (${role})`];
  return parts.filter(Boolean).join(' · ');
}

function start(site: Site): Api {
  const wanted = parseView(location.search);
  const canvas = document.getElementById('canvas') as HTMLCanvasElement;
  const renderer = makeRenderer(canvas);
  const scene = new Scene();
  const sky = new Sky(scene);
  const tiles = new TileLayers(renderer.capabilities.getMaxAnisotropy());
  const findings = new FindingsLayer(site);
  const fly = new FlyCamera(canvas), top = new FlyCamera(canvas, true);
  scene.add(tiles.group, findings.object);

  const lap = site.lap;
  const follow = lap && new FollowCamera();
  const car = lap && new Car(site.vehicle);
  if (car) car.place(lap.at(wanted.t_s));
  const orbit = car && new OrbitCamera(canvas, car.object);
  const driver = car && new DriverCamera(car.eye_m);
  const dashboard = lap && new Dashboard(lap);
  const map = lap && new MapInset(lap);
  const route = lap && routeLine(lap);
  if (car && route) scene.add(car.object, car.marker, route);

  const input = new DriverInput();
  let self: SelfDrive | undefined; // loaded once asked for
  let driving = false;

  let mode: CameraMode = 'fly';
  let time_s = wanted.t_s;
  let {date, hour} = wanted;
  let toSun = new Vector3();
  let rate = 1;
  let playing = lap !== undefined && new URLSearchParams(location.search).get('play') !== '0';
  let bounds: Sphere | undefined;
  let frame = 0;
  let stale = true; // the picture shows an earlier state
  let ready = false; // no tile is missing in the picture
  let settled = 0; // pictures in which none was missing
  const invalidate = () => {
    stale = true;
    ready = false, settled = 0;
  };
  tiles.onChange = fly.onChange = top.onChange = invalidate;
  if (orbit) orbit.onChange = invalidate;

  const modes: Partial<Record<CameraMode, string>> =
    {fly: 'Fly', top: 'Top', ...(lap ? {follow: 'Follow', orbit: 'Orbit', driver: 'Driver'} : {})};
  const showMode = panel.segments('cameras', modes, setCamera);
  function setCamera(chosen: CameraMode): void {
    mode = chosen in modes ? chosen : 'fly';
    fly.enabled = mode === 'fly';
    top.enabled = mode === 'top';
    if (orbit) orbit.enabled = mode === 'orbit';
    if (car) car.marker.visible = mode === 'fly' || mode === 'top';
    showMode(mode);
    invalidate();
  }
  const showDay = panel.setUpSun(zoneHours(site.localFromEcef), {setDay});
  function setDay(newDate: string, newHour: number): void {
    [date, hour] = [newDate, newHour];
    toSun = sunDirection(site.localFromEcef, date, hour);
    sky.setSun(toSun);
    showDay(date, hour);
    invalidate();
  }
  function setPlaying(on: boolean): void {
    if (on && driving) void setDriving(false);
    playing = on && lap !== undefined;
    panel.showPlaying(playing);
  }
  async function setDriving(on: boolean): Promise<void> {
    if (!lap) return;
    if (on) {
      setPlaying(false);
      try {
        self ??= await SelfDrive.load(site.origin);
        self.takeOver(lap.at(time_s));
      } catch (error) {
        panel.showMessage((error as Error).message, true);
        on = false;
      }
      input.reset();
    }
    driving = on;
    panel.showDriving(driving);
    if (driving && !atCar()) setCamera('driver');
    invalidate();
  }
  const groundUnder = (x_m: number, y_m: number, z_m: number) => tiles.heightAt(x_m, y_m, z_m + 2);
  /** Of the car that is shown, now or somewhat before. */
  const carNow = () => (driving ? self!.state : lap!.at(time_s));
  const headingBefore = () => (driving ? self!.headingBefore : lap!.at(time_s - followLag_s).heading_rad);

  function setTime(t_s: number): void {
    if (driving) void setDriving(false);
    time_s = t_s;
    invalidate();
  }

  function showShadows(on: boolean): void {
    sky.setShadows(on);
    if (car) car.hasSoftShadow = !on;
  }

  const switches = new Map<LayerName, HTMLInputElement>();
  const usually = new Map<LayerName, boolean>();
  function setLayer(layer: LayerName, on: boolean): void {
    switches.get(layer)!.checked = on;
    if (layer === 'route') route!.visible = on;
    else if (layer === 'findings') findings.object.visible = on;
    else if (layer === 'shadows') showShadows(on);
    else tiles.setLayer(layer, on);
    if (layer === 'photo') sky.setRelief(!on);
    invalidate();
  }
  const addLayer = (layer: LayerName, label: string, on: boolean) => {
    usually.set(layer, on);
    switches.set(layer, panel.addSwitch(layer, label, on, (checked) => setLayer(layer, checked)));
  };
  addLayer('photo', 'Orthophoto', true);
  addLayer('materials', 'Road materials', true);
  addLayer('terrain', 'Terrain', true);
  addLayer('roads', 'Roads', true);
  addLayer('buildings', 'Buildings', true);
  addLayer('trees', 'Trees', true);
  addLayer('shadows', 'Shadows', true);
  addLayer('wireframe', 'Wireframe', false);
  if (lap) addLayer('route', 'Driven route', true);
  if (findings.findings.length > 0) addLayer('findings', `Findings (${findings.findings.length})`, false);

  const keys = ['W A S D Q E fly', 'left drag move', 'right drag turn', 'wheel zoom', ...(lap ? ['C camera', 'Space play', 'arrows or gamepad drive'] : [])];
  panel.showTexts(site.name, site.attribution, keys.join(' · '));
  if (lap) panel.setUpDriving(() => void setDriving(!driving));
  if (lap) panel.setUpTimeline(lap, {seek: setTime, togglePlay: () => setPlaying(!playing), setRate: (factor) => (rate = factor)});
  panel.setUpButtons(() => navigator.clipboard.writeText(link()));
  showShadows(true);
  setDay(date, hour);
  for (const layer of usually.keys()) {
    if (wanted.off.includes(layer)) setLayer(layer, false);
    if (wanted.on.includes(layer)) setLayer(layer, true);
  }
  setCamera(wanted.camera);
  setPlaying(playing);

  const viewport = new Vector2();
  function resize(): void {
    viewport.set(window.innerWidth, window.innerHeight);
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    renderer.setSize(viewport.x, viewport.y, false);
    for (const view of [fly.camera, top.camera, follow?.camera, orbit?.camera, driver?.camera]) {
      if (!view) continue;
      view.aspect = viewport.x / viewport.y;
      view.updateProjectionMatrix();
    }
    invalidate();
  }
  window.addEventListener('resize', resize);
  window.addEventListener('keydown', (event) => {
    if (!lap || event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
    if (driving && atCar() && input.key(event.code, true)) {
      event.preventDefault();
      return;
    }
    const names = Object.keys(modes) as CameraMode[];
    if (event.code === 'KeyC') setCamera(names[(names.indexOf(mode) + 1) % names.length]);
    if (event.code === 'Space') setPlaying(!playing), event.preventDefault();
  });
  window.addEventListener('keyup', (event) => input.key(event.code, false));
  canvas.addEventListener('click', (event) => {
    const place = new Vector2((2 * event.clientX) / viewport.x - 1, 1 - (2 * event.clientY) / viewport.y);
    const finding = findings.at(place, activeCamera(), viewport);
    if (finding) panel.showMessage(`${finding.code}: ${finding.message}`, false);
    else void tiles.describe(place, activeCamera()).then((what) => panel.showMessage(textOf(what), false));
  });

  const cameras: Record<CameraMode, () => PerspectiveCamera> = {
    fly: () => fly.camera, top: () => top.camera, follow: () => follow!.camera, orbit: () => orbit!.camera, driver: () => driver!.camera,
  };
  function activeCamera(): PerspectiveCamera {
    return cameras[mode]();
  }
  const atCar = () => mode !== 'fly' && mode !== 'top';

  /** Address of the page that shows this view again. */
  function link(): string {
    const changed = (on: boolean) => [...usually].filter(([layer, usual]) => usual !== on && switches.get(layer)!.checked === on).map(([layer]) => layer);
    const view = mode === 'fly' ? fly.view : mode === 'top' ? top.view : undefined;
    const search = writeView({camera: mode, view, t_s: time_s, date, hour, off: changed(false), on: changed(true)});
    return `${location.origin}${location.pathname}${search}`;
  }

  /** The tileset is there: look at all of it, or where the address says, and let the haze begin where the site ends. */
  function adoptBounds(): void {
    bounds = tiles.bounds();
    if (!bounds) return;
    fly.frame(bounds);
    top.frame(bounds);
    if (wanted.view) (wanted.camera === 'top' ? top : fly).view = wanted.view;
  }

  function placeCar(): void {
    if (!lap || !car) return;
    const state = carNow();
    car.place(state);
    follow!.update(state, headingBefore());
    orbit!.update(car.object);
    driver!.update(car.object);
    panel.showDashboard(state, lap.originHeight_m);
    dashboard!.show(state);
    const camera = activeCamera();
    map!.show(state, camera.position, camera.getWorldDirection(new Vector3()).add(camera.position));
  }

  /** What shadows are drawn around: the road ahead of the car, or what the camera looks at. */
  function aimSun(): void {
    const camera = activeCamera();
    const ahead = camera.getWorldDirection(new Vector3());
    if (atCar() && car) {
      sky.focus(car.object.position.clone().addScaledVector(ahead, 60), 110);
    } else {
      const {target} = mode === 'top' ? top : fly;
      sky.focus(target, Math.min(1500, Math.max(40, 0.8 * camera.position.distanceTo(target))));
    }
  }

  function draw(): void {
    if (bounds) {
      fly.fitDepth(bounds);
      top.fitDepth(bounds);
      const reach_m = atCar() ? 1200 : activeCamera().position.distanceTo(bounds.center);
      sky.setHazeRange(0.5 * reach_m, (atCar() ? 3 : 4) * reach_m);
    }
    aimSun();
    renderer.render(scene, activeCamera());
    ++frame;
  }

  let shownFailures = 0;
  let last_ms = performance.now();
  function tick(now_ms: number): void {
    const elapsed_s = Math.min(0.25, (now_ms - last_ms) / 1000); // a hidden page stands still
    last_ms = now_ms;
    if (!bounds) adoptBounds();
    if (fly.update(elapsed_s) || top.update(elapsed_s)) invalidate();
    if (playing) {
      time_s += rate * elapsed_s;
      stale = true;
    }
    if (driving) {
      self!.advance(elapsed_s, input.controls(self!.state.speed_mps, elapsed_s), groundUnder);
      stale = true;
    }
    if (findings.dropOnto(tiles)) stale = true;
    if (stale || !ready) {
      placeCar();
      activeCamera().updateMatrixWorld();
      tiles.update(activeCamera(), renderer); // tells of new tiles through onChange
      if (stale) draw();
      stale = false;
      settled = tiles.complete && tiles.visible > 0 ? settled + 1 : 0;
      ready = settled >= 3; // a tile that has come asks for finer ones with the next picture
    }
    if (tiles.failures.length > shownFailures) panel.showMessage(tiles.failures[shownFailures++], true);
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
    get car() { return lap && carNow(); },
    get driving() { return driving; },
    get wheelsOnRoad() { return driving ? self!.wheelsOnRoad : 4; },
    get cameraPosition() { return activeCamera().position.toArray() as [number, number, number]; },
    get sun() { return toSun.toArray() as [number, number, number]; },
    get link() { return link(); },
    describe: (x, y) => tiles.describe(new Vector2(x, y), activeCamera()),
    groundUnder,
    setCamera, setLayer, setTime, setPlaying, setDriving, setDay,
  };
}

try {
  window.orthodrive = start(await loadSite());
} catch (error) {
  panel.showMessage((error as Error).message, true);
  throw error;
}
