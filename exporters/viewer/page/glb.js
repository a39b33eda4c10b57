// Reads the GLB inside of the page. It is the exporter's own, so this knows only what that writes: attributes
// of any component type, EXT_meshopt_compression, one texture, one node a level of detail.
//
// meshoptimizer's decoder in plain JavaScript is taken, not the one in WebAssembly: it takes 20 ms for 100,000
// triangles, and the page's policy need not allow code to be compiled.
import { MeshoptDecoder } from 'meshoptimizer/meshopt_decoder_reference.js';

const kArrays = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const kComponents = { SCALAR: 1, VEC2: 2, VEC3: 3 };
const kLargest = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };

// The bytes of a buffer view, decoded where they are compressed, at the start of a buffer of their own.
function viewBytes(json, binary, index) {
  const view = json.bufferViews[index];
  const packed = view.extensions?.EXT_meshopt_compression;
  const { byteOffset = 0, byteLength } = packed ?? view;
  const bytes = binary.slice(byteOffset, byteOffset + byteLength);
  if (!packed) return bytes;
  const decoded = new Uint8Array(packed.count * packed.byteStride);
  MeshoptDecoder.decodeGltfBuffer(decoded, packed.count, packed.byteStride, bytes, packed.mode, packed.filter);
  return decoded;
}

// An accessor as it is stored: `count` elements of `width` components, `step` components apart.
function readStored(json, binary, index) {
  const { bufferView, byteOffset = 0, componentType, count, type } = json.accessors[index];
  const ArrayType = kArrays[componentType];
  const width = kComponents[type];
  const stride = json.bufferViews[bufferView].byteStride ?? width * ArrayType.BYTES_PER_ELEMENT;
  const stored = new ArrayType(viewBytes(json, binary, bufferView).buffer, byteOffset);
  return { stored, width, count, step: stride / ArrayType.BYTES_PER_ELEMENT };
}

// The numbers of _PROVENANCE; null where there are none.
function readProvenance(json, binary, index) {
  if (index === undefined) return null;
  const { stored, count, step } = readStored(json, binary, index);
  return Uint8Array.from({ length: count }, (_, i) => stored[i * step]);
}

function readIndices(json, binary, index) {
  const { stored, count } = readStored(json, binary, index);
  return stored.subarray(0, count);
}

// Components times scale plus offset, in float32; scale and offset have one number a component.
function readScaled(json, binary, index, scale, offset) {
  const { componentType, normalized } = json.accessors[index];
  const { stored, width, count, step } = readStored(json, binary, index);
  const divisor = normalized ? kLargest[componentType] : 1;
  const values = new Float32Array(count * width);
  for (let c = 0; c < width; ++c) {
    const factor = scale[c] / divisor;
    for (let i = 0; i < count; ++i) values[i * width + c] = stored[i * step + c] * factor + offset[c];
  }
  return values;
}

// {levels: [{positions, texcoords, provenance (null: none), indices}], fine to coarse, image: Blob or null, json: the document,
// picture: bytes of the image}
export function readGlb(bytes) {
  const header = new DataView(bytes.buffer, bytes.byteOffset);
  const jsonBytes = header.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + jsonBytes)));
  const binary = bytes.subarray(28 + jsonBytes);
  const transform = json.materials[0].pbrMetallicRoughness?.baseColorTexture?.extensions?.KHR_texture_transform;
  const levels = json.nodes
    .filter((node) => node.mesh !== undefined)
    .map(({ mesh, scale = [1, 1, 1], translation = [0, 0, 0] }) => {
      const { attributes, indices } = json.meshes[mesh].primitives[0];
      const texcoords = attributes.TEXCOORD_0;
      return {
        positions: readScaled(json, binary, attributes.POSITION, scale, translation),
        texcoords: texcoords === undefined ? null : readScaled(json, binary, texcoords, transform?.scale ?? [1, 1], [0, 0]),
        provenance: readProvenance(json, binary, attributes._PROVENANCE),
        indices: readIndices(json, binary, indices),
      };
    });
  const image = json.images?.[0];
  const picture = image && viewBytes(json, binary, image.bufferView);
  return { levels, image: picture ? new Blob([picture], { type: image.mimeType }) : null, json, picture };
}

// Ends each second texture coordinate with a provenance, as the exporter does.
function endWithProvenance(texcoords, provenance) {
  const bits = new Uint32Array(texcoords.buffer), one = 0x3f800000;
  provenance.forEach((value, i) => {
    const near = (bits[2 * i + 1] + 0x7f - value & ~0xff) + value;
    bits[2 * i + 1] = near > one ? near - 0x100 : near;
  });
}

// The finest level as a GLB without extensions that a reader must know, as the exporter writes it: floats, the same material and
// picture.
export function writePlainGlb(bytes) {
  const { levels: [{ positions, texcoords, provenance, indices }], image, json: from, picture } = readGlb(bytes);
  const parts = [];
  let length = 0;
  const bufferViews = [];
  const addView = (array, more = {}) => {
    bufferViews.push({ buffer: 0, byteOffset: length, byteLength: array.byteLength, ...more });
    const padding = (4 - (array.byteLength % 4)) % 4;
    parts.push(new Uint8Array(array.buffer, array.byteOffset, array.byteLength), new Uint8Array(padding));
    length += array.byteLength + padding;
    return bufferViews.length - 1;
  };
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  positions.forEach((value, i) => {
    low[i % 3] = Math.min(low[i % 3], value);
    high[i % 3] = Math.max(high[i % 3], value);
  });
  const count = positions.length / 3;
  const [componentType, IndexArray] = count <= 65535 ? [5123, Uint16Array] : [5125, Uint32Array];
  const indexView = addView(IndexArray.from(indices), { target: 34963 });
  const accessors = [
    { bufferView: addView(positions, { target: 34962 }), componentType: 5126, count, type: 'VEC3', min: low, max: high },
    { bufferView: indexView, componentType, count: indices.length, type: 'SCALAR' },
  ];
  const attributes = { POSITION: 0 };
  if (texcoords) {
    if (provenance) endWithProvenance(texcoords, provenance);
    attributes.TEXCOORD_0 = accessors.length;
    accessors.push({ bufferView: addView(texcoords, { target: 34962, byteStride: 8 }), componentType: 5126, count, type: 'VEC2' });
  }
  if (provenance) {
    // Without texture coordinates each begins at a multiple of 4.
    const bufferView = texcoords ? accessors[attributes.TEXCOORD_0].bufferView
      : addView(Uint32Array.from(provenance), { target: 34962, byteStride: 4 });
    attributes._PROVENANCE = accessors.length;
    const { extras } = from.accessors[from.meshes[0].primitives[0].attributes._PROVENANCE];
    accessors.push({ bufferView, byteOffset: texcoords ? 4 : 0, componentType: 5121, count, type: 'SCALAR', extras });
  }
  const extensionsUsed = (from.extensionsUsed ?? []).filter((name) => name === 'KHR_materials_unlit' || name === 'EXT_texture_webp');
  const material = structuredClone(from.materials[0]);
  const base = material.pbrMetallicRoughness?.baseColorTexture;
  if (base) delete base.extensions; // texture coordinates are scaled already
  const nodes = [{ name: 'relief', mesh: 0 }, ...from.nodes.filter((node) => node.camera !== undefined)];
  const json = {
    asset: from.asset, scene: 0, scenes: [{ nodes: [...nodes.keys()] }], nodes, cameras: from.cameras,
    meshes: [{ name: 'relief', primitives: [{ attributes, indices: 1, material: 0 }] }], materials: [material],
    accessors, bufferViews,
    ...(extensionsUsed.length > 0 && { extensionsUsed }),
    ...(from.extensionsRequired?.includes('EXT_texture_webp') && { extensionsRequired: ['EXT_texture_webp'] }),
  };
  if (image) {
    const { textures, samplers } = from;
    Object.assign(json, { textures, samplers, images: [{ bufferView: addView(picture), mimeType: image.type }] });
  }
  json.buffers = [{ byteLength: length }];
  const text = new TextEncoder().encode(JSON.stringify(json));
  const textPadding = new Uint8Array((4 - (text.length % 4)) % 4).fill(0x20);
  const textLength = text.length + textPadding.length;
  const head = new Uint32Array([0x46546c67, 2, 28 + textLength + length, textLength, 0x4e4f534a]);
  return new Blob([head, text, textPadding, new Uint32Array([length, 0x004e4942]), ...parts]);
}
