// SPDX-License-Identifier: Apache-2.0
// What a tile takes of the graphics card's memory.

import {
  type BufferAttribute,
  InstancedMesh,
  InterleavedBufferAttribute,
  type Mesh,
  type MeshStandardMaterial,
  type Texture,
  type TypedArray,
} from 'three';

const withSmallerCopies = 4 / 3; // 1 + 1/4 + 1/16 ...

/** Of the meshes as they come from the file: buffers, and pictures with four bytes a pixel. */
export function graphicsBytes(meshes: Mesh[]): number {
  const arrays = new Set<TypedArray>();
  const pictures = new Set<Texture>();
  const add = (attribute: BufferAttribute | InterleavedBufferAttribute | null) => {
    if (attribute) arrays.add(attribute instanceof InterleavedBufferAttribute ? attribute.data.array : attribute.array);
  };
  for (const mesh of meshes) {
    Object.values(mesh.geometry.attributes).forEach((attribute) =>
      add(attribute as BufferAttribute | InterleavedBufferAttribute),
    );
    add(mesh.geometry.index);
    if (mesh instanceof InstancedMesh) add(mesh.instanceMatrix);
    const {map} = mesh.material as MeshStandardMaterial;
    if (map) pictures.add(map);
  }
  let bytes = 0;
  for (const array of arrays) bytes += array.byteLength;
  for (const {image, generateMipmaps} of pictures) {
    const {width, height} = image as {width: number; height: number};
    bytes += 4 * width * height * (generateMipmaps ? withSmallerCopies : 1);
  }
  return bytes;
}
