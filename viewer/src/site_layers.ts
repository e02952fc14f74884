// Everything that can be switched on and off: the tiles and what is drawn over them.

import type {Scene} from 'three';

import type {Drive} from './drive';
import {FindingsLayer} from './findings_layer';
import {loadLanes} from './lanes_layer';
import {LateLayer} from './late_layer';
import {LayerSwitches} from './layer_switches';
import {graphColors, loadErrorBars, loadGraph} from './road_graph_layer';
import type {Site} from './site';
import type {Sky} from './sky';
import {TileLayers} from './tile_layers';
import type {Layers} from './tile_looks';

type LateName = 'lanes' | 'map-roads' | 'refined-roads' | 'error-bars';

export class SiteLayers {
  readonly switches = new LayerSwitches();
  readonly tiles: TileLayers;
  readonly findings: FindingsLayer;
  private readonly late: Record<LateName, LateLayer>;

  constructor(scene: Scene, site: Site, private readonly sky: Sky, private readonly drive: Drive | undefined, anisotropy: number) {
    this.tiles = new TileLayers(site.tileset, anisotropy);
    this.findings = new FindingsLayer(site);
    this.late = {
      'lanes': new LateLayer(() => loadLanes(site.origin)),
      'map-roads': new LateLayer(() => loadGraph(site, 'before')),
      'refined-roads': new LateLayer(() => loadGraph(site, 'after')),
      'error-bars': new LateLayer(() => loadErrorBars(site)),
    };
    scene.add(this.tiles.group, this.findings.object, ...Object.values(this.late).map((layer) => layer.object));
    this.addSwitches();
    this.showShadows(true);
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
    const {switches, tiles, late, drive, findings, sky} = this;
    const addTileLayer = (name: keyof Layers, label: string) => switches.add(name, label, tiles.layers[name], (on) => tiles.setLayer(name, on));
    switches.add('photo', 'Orthophoto', true, (on) => (tiles.setLayer('photo', on), sky.setRelief(!on)));
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
      switches.add(name, label, false, (on) => (late[name].visible = on), color === undefined ? undefined : `#${color.toString(16).padStart(6, '0')}`);
    addLate('lanes', 'Lanes');
    addLate('map-roads', 'Roads of the map', graphColors.before);
    addLate('refined-roads', 'Roads as refined', graphColors.after);
    addLate('error-bars', 'Error bars (95 %)', graphColors.bars);
    if (drive) {
      switches.add('route', 'Driven route', true, (on) => (drive.route.visible = on));
      switches.add('ghost', 'Ghost car', true, (on) => (drive.showsGhost = on));
    }
    if (findings.findings.length > 0)
      switches.add('findings', `Findings (${findings.findings.length})`, false, (on) => (findings.object.visible = on));
  }

  private showShadows(on: boolean): void {
    this.sky.setShadows(on);
    if (this.drive) this.drive.car.hasSoftShadow = !on;
  }
}
