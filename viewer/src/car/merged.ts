// SPDX-License-Identifier: Apache-2.0
// Fewer draw calls: parts that never move against each other become one mesh a material.

import {BufferGeometry, type Material, Mesh, type Object3D} from 'three';
import {mergeGeometries} from 'three/addons/utils/BufferGeometryUtils.js';

/** In the frame of the parts' parent. The parts' own geometries are not needed any more. */
export function merged(parts: Object3D[]): Mesh<BufferGeometry, Material>[] {
  const byMaterial = new Map<Material, BufferGeometry[]>();
  for (const part of parts) {
    part.updateMatrixWorld();
    part.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      const source = object.geometry as BufferGeometry,
        geometry = new BufferGeometry();
      for (const name of ['position', 'normal']) geometry.setAttribute(name, source.getAttribute(name).clone());
      geometry.setIndex(source.getIndex());
      geometry.applyMatrix4(object.matrixWorld);
      const material = object.material as Material;
      byMaterial.set(material, [...(byMaterial.get(material) ?? []), geometry]);
    });
  }
  return [...byMaterial].map(([material, geometries]) => new Mesh(mergeGeometries(geometries), material));
}
