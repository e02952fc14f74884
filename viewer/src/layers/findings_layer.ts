// SPDX-License-Identifier: Apache-2.0
// Findings (odd but not fatal) as dots on the ground; a click on one shows its message.

import {
  BufferAttribute,
  BufferGeometry,
  type Camera,
  Color,
  Points,
  PointsMaterial,
  type Vector2,
  Vector3,
} from 'three';

import {radialTexture} from '../radial_texture';
import type {Finding, Site} from '../site';
import type {TileLayers} from '../tiles/tile_layers';
import {utmFromGeographic, utmZone} from '../utm';

const colors: Record<Finding['severity'], Color> = {
  info: new Color(0x3c8edb),
  warning: new Color(0xf2a31b),
  error: new Color(0xd6302b),
};

export class FindingsLayer {
  readonly object: Points;
  readonly findings: Finding[];
  private readonly positions: BufferAttribute;
  private grounded = 0;

  constructor(site: Site, findings: Finding[]) {
    const zone = utmZone(site.crs);
    this.findings = zone ? findings : [];
    this.positions = new BufferAttribute(new Float32Array(3 * this.findings.length), 3);
    const tints = new BufferAttribute(new Float32Array(3 * this.findings.length), 3);
    this.findings.forEach((finding, i) => {
      const [x, y] = utmFromGeographic(zone!, finding.longitudeDeg, finding.latitudeDeg);
      this.positions.setXYZ(i, x - site.origin[0], y - site.origin[1], 0);
      const known = Object.hasOwn(colors, finding.severity) ? finding.severity : 'warning';
      colors[known].toArray(tints.array, 3 * i);
    });
    const geometry = new BufferGeometry().setAttribute('position', this.positions).setAttribute('color', tints);
    const material = new PointsMaterial({
      size: 11,
      sizeAttenuation: false,
      vertexColors: true,
      depthTest: false,
      fog: false,
      transparent: true,
      map: radialTexture([
        [0, '#fff'],
        [0.8, '#fff'],
        [1, 'rgba(255,255,255,0)'],
      ]),
    });
    this.object = new Points(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = 1;
    this.object.visible = false;
  }

  /** Findings carry no height: drops a few of them a frame onto the ground. Returns true while some are left. */
  dropOnto(ground: TileLayers): boolean {
    if (!this.object.visible || this.grounded === this.findings.length) return false;
    const end = Math.min(this.grounded + 10, this.findings.length);
    for (; this.grounded < end; ++this.grounded) {
      const z_m = ground.heightAt(this.positions.getX(this.grounded), this.positions.getY(this.grounded), 1e4);
      if (z_m !== undefined) this.positions.setZ(this.grounded, z_m + 1);
    }
    this.positions.needsUpdate = true;
    return true;
  }

  /** The finding within 12 px of a place on the screen (normalised device coordinates). */
  at(place: Vector2, camera: Camera, viewport: Vector2): Finding | undefined {
    if (!this.object.visible) return undefined;
    let nearest: Finding | undefined,
      nearest_px = 12;
    this.findings.forEach((finding, i) => {
      const p = new Vector3().fromBufferAttribute(this.positions, i).project(camera);
      const distance_px = Math.hypot(((p.x - place.x) * viewport.x) / 2, ((p.y - place.y) * viewport.y) / 2);
      if (Math.abs(p.z) < 1 && distance_px < nearest_px) [nearest, nearest_px] = [finding, distance_px];
    });
    return nearest;
  }
}
