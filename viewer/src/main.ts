// SPDX-License-Identifier: Apache-2.0
// The viewer of a built site: ties scene, cameras, cars and page together, and draws when something has changed.

import './style.css';

import {PCFShadowMap, Scene, type Sphere, Vector2, Vector3, WebGLRenderer} from 'three';

import type {Api} from './api';
import {CameraSet} from './camera_set';
import {type CameraMode, isAtCar} from './cameras';
import {Drive} from './car/drive';
import type {Lap} from './lap';
import {SiteLayers} from './layers/site_layers';
import * as panel from './panel';
import {PictureTime} from './picture_time';
import {loadCar, loadNotes, loadSite, type Site, type SiteCar, type SiteNotes} from './site';
import {Sky} from './sky/sky';
import {sunDirection, zoneHours} from './sky/sun';
import {parseView, type ViewState, writeView} from './view_link';

function makeRenderer(canvas: HTMLCanvasElement): WebGLRenderer {
  try {
    const renderer = new WebGLRenderer({canvas, antialias: true, stencil: true});
    renderer.info.autoReset = false; // it would forget what the shadows took
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = PCFShadowMap;
    return renderer;
  } catch {
    throw new Error(
      'This browser gives no WebGL 2, with which the scene is drawn. Switch on hardware acceleration in its settings, or use another browser.',
    );
  }
}

/** One line of what was clicked on. */
function textOf(what: Record<string, string>): string {
  const {kind, id, name, type, osm_id: osm, lane_id: lane, lane_type: laneType, class: label, role} = what;
  const parts = [
    kind && `${kind}${id ? ` ${id}` : ''}`,
    name,
    type,
    lane && `lane ${lane} (${laneType})`,
    osm && `OSM ${osm}`,
    label && `${label} (${role})`,
  ];
  return parts.filter(Boolean).join(' · ');
}

/**
 * A picture that shows nothing but more detail takes time from loading it: at least so many seconds lie between two, and at
 * least as many as the last one took.
 */
const betweenDetails_s = 0.5;

class Viewer {
  private readonly canvas = document.getElementById('canvas') as HTMLCanvasElement;
  private readonly renderer = makeRenderer(this.canvas);
  private readonly scene = new Scene();
  private readonly sky = new Sky(this.scene);
  private readonly layers: SiteLayers;
  private drive?: Drive;
  private readonly cameras: CameraSet;
  private showMode: (mode: CameraMode) => void = () => {};
  private readonly showDay: (date: string, hour: number) => void;
  private readonly viewport = new Vector2();
  private date = '';
  private hour = 0;
  private toSun = new Vector3();
  private bounds?: Sphere;
  private frame = 0;
  private wasCovered = false; // by tiles, in the last picture
  private isDrawn = () => {};
  readonly firstPicture = new Promise<void>((resolve) => (this.isDrawn = resolve));
  private stale = true; // the picture shows an earlier state
  private coarse = false; // tiles have come or gone since the picture
  private readonly pictureTime = new PictureTime(this.renderer.getContext() as WebGL2RenderingContext);
  private completeBefore = false; // nothing was on its way a moment ago
  private ready = false; // no tile is missing in the picture
  private settled = 0; // pictures in which none was missing
  private hasCar = false; // or it is known that there is none
  private hasAll = false;
  private ghostPending = false;
  private shownFailures = 0;
  private last_ms = performance.now();

  constructor(
    private readonly site: Site,
    private readonly wanted: ViewState,
  ) {
    this.layers = new SiteLayers(this.scene, site, this.sky, this.renderer.capabilities.getMaxAnisotropy(), wanted);
    this.cameras = new CameraSet(this.canvas);
    this.showDay = panel.setUpSun(zoneHours(site.localFromEcef), {setDay: (date, hour) => this.setDay(date, hour)});
    this.layers.onChange = this.cameras.onChange = () => this.invalidate();
    this.layers.onDetail = () => {
      this.coarse = true;
      this.unsettle();
    };
    this.setDay(wanted.date, wanted.hour);
    this.setCamera(wanted.camera);
    this.listen();
    this.resize();
    requestAnimationFrame((now_ms) => this.tick(now_ms));
  }

  /** The car is known, where there is one, and so is where its cameras are. */
  adoptCar({lap, vehicle}: SiteCar): void {
    const {wanted, cameras} = this;
    this.hasCar = true;
    if (!lap) return;
    this.drive = new Drive(this.scene, this.site, vehicle, lap, wanted.t_s);
    cameras.adoptCar(this.drive.car);
    if (isAtCar(wanted.camera)) this.setCamera(wanted.camera);
  }

  /** The rest: what is drawn of the lap, findings, the page around the picture. */
  adoptRest(lap: Lap | undefined, {name, attribution, findings}: SiteNotes): void {
    if (lap) this.setUpDrive(lap);
    this.layers.adopt(this.drive, findings);
    this.showMode = panel.segments('cameras', this.cameras.modes, (mode) => this.setCamera(mode));
    this.setUpPage(name, attribution);
    this.hasAll = true;
    this.setCamera(this.cameras.mode);
  }

  private invalidate(): void {
    this.stale = true;
    this.unsettle();
  }
  private unsettle(): void {
    this.ready = false;
    this.settled = 0;
  }

  private setUpPage(name: string, attribution: string[]): void {
    const ofCar = this.drive
      ? ['C camera', 'Space play', 'arrows or gamepad drive', 'drop a lap.csv to drive against it']
      : [];
    const keys = ['W A S D Q E fly', 'left drag move', 'right drag turn', 'wheel zoom', ...ofCar];
    panel.showTexts(name, attribution, keys.join(' · '));
    panel.setUpButtons(() => navigator.clipboard.writeText(this.link));
  }

  private setUpDrive(lap: Lap): void {
    const {wanted} = this;
    const drive = this.drive!;
    drive.adoptLap(lap);
    drive.onChange = () => this.invalidate();
    drive.onDriving = () => {
      if (drive.driving && !this.cameras.atCar) this.setCamera('driver');
    };
    panel.setUpDriving(() => void drive.setDriving(!drive.driving));
    panel.setUpTimeline(lap, {
      seek: (t_s) => (drive.t_s = t_s),
      togglePlay: () => (drive.playing = !drive.playing),
      setRate: (factor) => (drive.rate = factor),
    });
    panel.setUpGhost({open: (name, csv) => drive.setGhost(csv, name), remove: () => drive.removeGhost()});
    drive.playing = new URLSearchParams(location.search).get('play') !== '0';
    if (!wanted.ghost) return;
    this.ghostPending = true;
    void drive.loadGhost(wanted.ghost).then(() => (this.ghostPending = false));
  }

  private setCamera(mode: CameraMode): void {
    this.cameras.mode = mode;
    this.showMode(this.cameras.mode);
    this.invalidate();
  }

  private setDay(date: string, hour: number): void {
    [this.date, this.hour] = [date, hour];
    this.toSun = sunDirection(this.site.localFromEcef, date, hour);
    this.sky.setSun(this.toSun);
    this.showDay(date, hour);
    this.invalidate();
  }

  private listen(): void {
    const {cameras, canvas, viewport} = this;
    window.addEventListener('resize', () => this.resize());
    window.addEventListener('keydown', (event) => {
      const {drive} = this;
      if (!drive || event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
      if (drive.driving && cameras.atCar && drive.input.key(event.code, true)) {
        event.preventDefault();
        return;
      }
      if (event.code === 'KeyC') this.setCamera(cameras.next);
      if (event.code === 'Space') {
        drive.playing = !drive.playing;
        event.preventDefault();
      }
    });
    window.addEventListener('keyup', (event) => this.drive?.input.key(event.code, false));
    canvas.addEventListener('click', (event) => {
      const place = new Vector2((2 * event.clientX) / viewport.x - 1, 1 - (2 * event.clientY) / viewport.y);
      const finding = this.layers.findings?.at(place, cameras.active, viewport);
      if (finding) panel.showMessage(`${finding.code}: ${finding.message}`, false);
      else
        void this.layers.tiles.describe(place, cameras.active).then((what) => panel.showMessage(textOf(what), false));
    });
  }

  private resize(): void {
    this.viewport.set(window.innerWidth, window.innerHeight);
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.setSize(this.viewport.x, this.viewport.y, false);
    this.cameras.resize(this.viewport.x / this.viewport.y);
    this.invalidate();
  }

  /** Address of the page that shows this view again. */
  private get link(): string {
    const {cameras, drive, date, hour} = this;
    const {switches} = this.layers;
    const search = writeView({
      camera: cameras.mode,
      view: cameras.view,
      t_s: drive?.t_s ?? 0,
      date,
      hour,
      off: switches.changedTo(false),
      on: switches.changedTo(true),
      ghost: drive?.ghostFile,
    });
    return `${location.origin}${location.pathname}${search}`;
  }

  private draw(): void {
    const {cameras, sky} = this;
    cameras.fitDepth();
    if (this.bounds) sky.setHazeRange(...cameras.haze_m);
    sky.focus(cameras.focus.middle, cameras.focus.radius_m);
    this.renderer.info.reset();
    if (this.frame === 0) this.renderer.compile(this.scene, cameras.active); // all shaders side by side
    this.renderer.render(this.scene, cameras.active);
    this.drive?.tell(cameras.active); // with the picture: what changes on the page makes the browser put it together anew
    if (++this.frame === 1) {
      this.layers.tiles.allowFine();
      this.isDrawn();
    }
    this.pictureTime.asked(this.last_ms);
    this.wasCovered = this.layers.tiles.covered;
    this.stale = this.coarse = false;
  }

  /** The tileset is there: its size is known. */
  private adoptBounds(): void {
    this.bounds = this.layers.tiles.bounds();
    if (this.bounds) this.cameras.adoptBounds(this.bounds, this.wanted.view);
  }

  private readonly groundUnder = (x_m: number, y_m: number, z_m: number) =>
    this.layers.tiles.heightAt(x_m, y_m, z_m + 2);

  private placeCars(): void {
    const {drive, cameras} = this;
    if (!drive) return;
    drive.place(!cameras.atCar);
    cameras.goWith(drive.state, drive.headingBefore);
  }

  /** What is wanted of a view comes at once, but not before there is something; more detail comes in steps. */
  private get isDue(): boolean {
    if (!this.bounds || (isAtCar(this.wanted.camera) && !this.hasCar)) return false; // nobody knows where to look from
    const {complete, covered} = this.layers.tiles;
    if (this.stale) return covered || complete;
    if (!this.coarse) return false;
    const {pictureTime} = this;
    const since_ms = pictureTime.since(this.last_ms);
    const isAll = complete && this.completeBefore; // a tile that has come asks for finer ones a moment later
    return since_ms >= 0 && (isAll || since_ms > Math.max(1000 * betweenDetails_s, pictureTime.last_ms));
  }

  private tick(now_ms: number): void {
    const elapsed_s = Math.min(0.25, (now_ms - this.last_ms) / 1000); // a hidden page stands still
    this.last_ms = now_ms;
    if (!this.bounds) this.adoptBounds();
    if (this.cameras.update(elapsed_s)) this.invalidate();
    if (this.drive?.advance(elapsed_s, this.groundUnder)) this.stale = true;
    if (this.layers.findings?.dropOnto(this.layers.tiles)) this.stale = true;
    if (this.stale || !this.ready) {
      this.placeCars();
      this.cameras.active.updateMatrixWorld();
      this.layers.tiles.update(this.cameras.active, this.renderer); // tells of new tiles through onChange
      if (this.isDue) this.draw();
      this.completeBefore = this.layers.tiles.complete;
      const isDrawn = !this.stale && !this.coarse;
      this.settled = isDrawn && this.layers.complete && this.hasAll && !this.ghostPending ? this.settled + 1 : 0;
      this.ready = this.settled >= 3; // a tile that has come asks for finer ones with the next picture
    }
    if (this.layers.tiles.failures.length > this.shownFailures)
      panel.showMessage(this.layers.tiles.failures[this.shownFailures++], true);
    requestAnimationFrame((later_ms) => this.tick(later_ms));
  }

  // Over 60 lines by layout only: a table of members, each of which says one thing.
  get api(): Api {
    const viewer = this;
    const {cameras, renderer} = this;
    const {tiles, switches} = this.layers;
    return {
      get ready() {
        return viewer.ready;
      },
      get frame() {
        return viewer.frame;
      },
      get tilesLoaded() {
        return tiles.loaded;
      },
      get tilesVisible() {
        return tiles.visible;
      },
      get covered() {
        return viewer.wasCovered && tiles.covered;
      },
      get held() {
        return tiles.held;
      },
      get drawn() {
        return {triangles: renderer.info.render.triangles, calls: renderer.info.render.calls};
      },
      get failures() {
        return tiles.failures;
      },
      get mode() {
        return cameras.mode;
      },
      get car() {
        return viewer.drive?.state;
      },
      get ghost() {
        return viewer.drive?.ghostState;
      },
      get gap_s() {
        return viewer.drive?.gap_s;
      },
      get driving() {
        return viewer.drive?.driving ?? false;
      },
      get wheelsOnRoad() {
        return viewer.drive?.wheelsOnRoad ?? 0;
      },
      get cameraPosition() {
        return cameras.active.position.toArray() as [number, number, number];
      },
      get sun() {
        return viewer.toSun.toArray() as [number, number, number];
      },
      get link() {
        return viewer.link;
      },
      get layers() {
        return switches.shown;
      },
      describe: (x, y) => tiles.describe(new Vector2(x, y), cameras.active),
      groundUnder: this.groundUnder,
      roadNear: (x_m, y_m, z_m) => tiles.roadNear(x_m, y_m, z_m),
      pictured: (x_m, y_m, z_m) =>
        new Vector3(x_m, y_m, z_m).project(cameras.active).toArray() as [number, number, number],
      setCamera: (mode) => this.setCamera(mode),
      setView: (view) => {
        this.setCamera('fly');
        cameras.view = view;
      },
      setLayer: (layer, on) => switches.set(layer, on),
      setTime: (t_s) => {
        if (this.drive) this.drive.t_s = t_s;
      },
      setPlaying: (on) => {
        if (this.drive) this.drive.playing = on;
      },
      setDriving: async (on) => this.drive?.setDriving(on),
      setDay: (date, hour) => this.setDay(date, hour),
    };
  }
}

/** Two of the browser's pictures later: what was drawn before is to be seen. */
function shown(): Promise<void> {
  return new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve())));
}

/** First the ground, then the rest of the site and of the page: whoever waits sees something. */
async function start(): Promise<void> {
  const wanted = parseView(location.search);
  const site = loadSite();
  const early = isAtCar(wanted.camera) ? loadCar(site, wanted.t_s) : undefined; // without it nobody knows where the camera is
  const viewer = new Viewer(await site, wanted);
  window.orthodrive = viewer.api;
  if (early) viewer.adoptCar(await early);
  await viewer.firstPicture;
  await shown();
  const car = await (early ?? loadCar(site, Infinity));
  if (!early) viewer.adoptCar(car);
  const [lap, notes] = await Promise.all([car.wholeLap(), loadNotes()]);
  viewer.adoptRest(lap, notes);
  document.body.classList.remove('early');
}

try {
  await start();
} catch (error) {
  panel.showMessage((error as Error).message, true);
  throw error;
}
