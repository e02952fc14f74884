// SPDX-License-Identifier: Apache-2.0
// Everything that can be switched on and off: the tiles and what is drawn over them.

import type {Scene} from 'three';

import type {Drive} from '../car/drive';
import type {Finding, Site} from '../site';
import type {Sky} from '../sky/sky';
import {TileLayers} from '../tiles/tile_layers';
import type {Layers} from '../tiles/tile_looks';
import {FindingsLayer} from './findings_layer';
import {loadLanes} from './lanes_layer';
import {LateLayer} from './late_layer';
import {LayerSwitches} from './layer_switches';
import {graphColors, loadErrorBars, loadGraph} from './road_graph_layer';

type LateName = 'lanes' | 'map-roads' | 'refined-roads' | 'error-bars';

export class SiteLayers {
  readonly switches: LayerSwitches;
  readonly tiles: TileLayers;
  findings?: FindingsLayer;
  private drive?: Drive;
  private readonly late: Record<LateName, LateLayer>;

  /** `wanted`: layers that an address switches on and off. */
  constructor(
    private readonly scene: Scene,
    private readonly site: Site,
    private readonly sky: Sky,
    anisotropy: number,
    wanted: {on: string[]; off: string[]},
  ) {
    this.switches = new LayerSwitches(wanted);
    this.tiles = new TileLayers(site, anisotropy);
    this.late = {
      lanes: new LateLayer(() => loadLanes(site.origin)),
      'map-roads': new LateLayer(() => loadGraph(site, 'before')),
      'refined-roads': new LateLayer(() => loadGraph(site, 'after')),
      'error-bars': new LateLayer(() => loadErrorBars(site)),
    };
    scene.add(this.tiles.group, ...Object.values(this.late).map((layer) => layer.object));
    this.showShadows(true);
    this.addSwitches();
  }

  /** What has come after the ground. */
  adopt(drive: Drive | undefined, allFindings: Finding[]): void {
    const {switches} = this;
    const findings = new FindingsLayer(this.site, allFindings);
    this.findings = findings;
    this.scene.add(findings.object);
    this.drive = drive;
    if (drive) {
      this.showShadows(switches.shown.shadows);
      switches.add('route', 'Driven route', true, (on) => (drive.route!.visible = on));
      switches.add('ghost', 'Ghost car', true, (on) => (drive.showsGhost = on));
    }
    if (findings.findings.length > 0)
      switches.add('findings', `Findings (${findings.findings.length})`, false, (on) => (findings.object.visible = on));
  }

  set onChange(onChange: () => void) {
    for (const part of [this.switches, ...Object.values(this.late)]) part.onChange = onChange;
  }

  /** A tile or a picture has come or gone. */
  set onDetail(onDetail: () => void) {
    this.tiles.onChange = onDetail;
  }

  /** Nothing more to load for the present view. */
  get complete(): boolean {
    return this.tiles.complete && this.tiles.visible > 0 && !Object.values(this.late).some((layer) => layer.pending);
  }

  private addSwitches(): void {
    const {switches, tiles, late, sky} = this;
    const addTileLayer = (name: keyof Layers, label: string) =>
      switches.add(name, label, tiles.layers[name], (on) => tiles.setLayer(name, on));
    switches.add('photo', 'Orthophoto', true, (on) => {
      tiles.setLayer('photo', on);
      sky.setRelief(!on);
    });
    addTileLayer('labels', 'Classes seen in it');
    addTileLayer('normals', 'Normals');
    addTileLayer('materials', 'Road materials');
    addTileLayer('terrain', 'Terrain');
    addTileLayer('roads', 'Roads');
    addTileLayer('buildings', 'Buildings');
    addTileLayer('trees', 'Trees');
    switches.add('shadows', 'Shadows', true, (on) => this.showShadows(on));
    addTileLayer('wireframe', 'Wireframe');
    const addLate = (name: LateName, label: string, color?: number) =>
      switches.add(
        name,
        label,
        false,
        (on) => (late[name].visible = on),
        color === undefined ? undefined : `#${color.toString(16).padStart(6, '0')}`,
      );
    addLate('lanes', 'Lanes');
    addLate('map-roads', 'Roads of the map', graphColors.before);
    addLate('refined-roads', 'Roads as refined', graphColors.after);
    addLate('error-bars', 'Error bars (95 %)', graphColors.bars);
  }

  private showShadows(on: boolean): void {
    this.sky.setShadows(on);
    if (this.drive) this.drive.car.hasSoftShadow = !on;
  }
}
