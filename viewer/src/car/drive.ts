// SPDX-License-Identifier: Apache-2.0
// The cars on the roads: the lap that is replayed or the car that somebody drives, the other lap beside it, and what the
// page tells of them.

import {type PerspectiveCamera, type Scene, Vector3} from 'three';
import {followLag_s} from '../cameras';
import {type CarState, Lap} from '../lap';
import {routeLine} from '../layers/route_line';
import {MapInset} from '../map_inset';
import * as panel from '../panel';
import {fetchOptional, type Site, siteUrl} from '../site';
import {Car} from './car';
import {Dashboard} from './dashboard';
import {DriverInput} from './driver_input';
import {Ghost} from './ghost';
import {SelfDrive} from './self_drive';
import type {VehicleShape} from './vehicle_shape';

type HeightAt = (x_m: number, y_m: number, z_m: number) => number | undefined;

export class Drive {
  readonly car: Car;
  route?: ReturnType<typeof routeLine>;
  readonly input = new DriverInput();
  onChange: () => void = () => {};
  /** Somebody has taken over, or given back. */
  onDriving: () => void = () => {};
  rate = 1;
  showsGhost = true;
  /** Address of the other lap below the site's folder; none of a file of the reader's own. */
  ghostFile?: string;
  private readonly ghost: Ghost;
  private dashboard?: Dashboard;
  private map?: MapInset;
  private other?: Lap;
  private self?: SelfDrive; // loaded once asked for
  private isDriven = false;
  private takenOver = {t_s: 0, share: 0};
  private isPlaying = false;

  /** `lap`: as far as it is needed to place the car. */
  constructor(
    private readonly scene: Scene,
    private readonly site: Site,
    vehicle: VehicleShape,
    private lap: Lap,
    private time_s: number,
  ) {
    this.car = new Car(vehicle);
    this.ghost = new Ghost(scene, vehicle);
    this.car.place(lap.at(time_s));
    scene.add(this.car.object, this.car.marker);
  }

  /** All of the lap is there: what is drawn of it around the car. */
  adoptLap(lap: Lap): void {
    this.lap = lap;
    this.route = routeLine(lap);
    this.scene.add(this.route);
    this.dashboard = new Dashboard(lap);
    this.map = new MapInset(lap);
  }

  /** Of the car that is shown. */
  get state(): CarState {
    return this.isDriven ? this.self!.state : this.lap.at(this.time_s);
  }
  /** Of the ghost, where there is one. */
  get ghostState(): CarState | undefined {
    return this.ghost.state;
  }
  get gap_s(): number | undefined {
    return this.ghost.gap_s;
  }
  get driving(): boolean {
    return this.isDriven;
  }
  get wheelsOnRoad(): number {
    return this.isDriven ? this.self!.wheelsOnRoad : 4;
  }
  get headingBefore(): number {
    return this.isDriven ? this.self!.headingBefore : this.lap.at(Math.max(0, this.time_s - followLag_s)).heading_rad; // nothing was before the start
  }
  get t_s(): number {
    return this.time_s;
  }
  set t_s(t_s: number) {
    if (this.isDriven) void this.setDriving(false);
    this.time_s = t_s;
    this.onChange();
  }
  get playing(): boolean {
    return this.isPlaying;
  }
  set playing(on: boolean) {
    if (on && this.isDriven) void this.setDriving(false);
    this.isPlaying = on;
    panel.showPlaying(on);
  }

  async setDriving(on: boolean): Promise<void> {
    if (on) {
      this.playing = false;
      try {
        this.self ??= await SelfDrive.load(this.site.origin);
        const start = this.lap.at(this.time_s);
        this.takenOver = {t_s: start.t_s, share: this.lap.shareOf(start)};
        this.self.takeOver(start);
      } catch (error) {
        panel.showMessage((error as Error).message, true);
        on = false;
      }
      this.input.reset();
    }
    this.isDriven = on;
    panel.showDriving(on);
    this.onDriving();
    this.onChange();
  }

  /** A lap below the site's folder beside the first. */
  async loadGhost(file: string): Promise<void> {
    try {
      const response = await fetchOptional(siteUrl(file));
      if (!response) throw new Error(`The site has no ${file}, so there is no other lap beside the first.`);
      this.setGhost(await response.text(), file);
      this.ghostFile = file;
    } catch (error) {
      panel.showMessage((error as Error).message, true);
    }
  }
  /** A lap from the text of a CSV file. Throws what is wrong with it. */
  setGhost(csv: string, name: string): void {
    this.other = Lap.parse(csv, this.site.origin, name);
    this.ghostFile = undefined;
    panel.showGhostName(name);
    this.onChange();
  }
  removeGhost(): void {
    this.other = this.ghostFile = undefined;
    panel.showGhostName('');
    this.onChange();
  }

  /** Returns true while something moves. */
  advance(elapsed_s: number, heightAt: HeightAt): boolean {
    if (this.isPlaying) this.time_s += this.rate * elapsed_s;
    if (this.isDriven)
      this.self!.advance(elapsed_s, this.input.controls(this.self!.state.speed_mps, elapsed_s), heightAt);
    return this.isPlaying || this.isDriven;
  }

  /** Puts the cars where they are; `marked`: with dots to be found by from far away. */
  place(marked: boolean): void {
    const {state} = this;
    this.car.place(state);
    this.car.marker.visible = marked;
    this.placeGhost(state, marked);
  }

  /** What the dashboard and the map show of the cars. */
  tell(camera: PerspectiveCamera): void {
    if (!this.dashboard || !this.map) return;
    const {state} = this;
    panel.showDashboard(state, this.lap.originHeight_m);
    panel.showGap(this.ghost.state !== undefined, this.ghost.gap_s);
    this.dashboard.show(state);
    this.map.show(
      state,
      this.ghost.state,
      camera.position,
      camera.getWorldDirection(new Vector3()).add(camera.position),
    );
  }

  private placeGhost(state: CarState, marked: boolean): void {
    const ghost = !this.showsGhost ? undefined : this.isDriven ? this.lap : this.other;
    if (this.isDriven)
      this.ghost.show(
        ghost,
        this.takenOver.t_s + state.t_s,
        state,
        this.takenOver.share + state.s_m / this.lap.length_m,
        marked,
      );
    else this.ghost.show(ghost, state.t_s, state, this.lap.shareOf(state), marked);
  }
}
