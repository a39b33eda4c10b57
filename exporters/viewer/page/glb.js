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

// {levels: [{positions, texcoords (null: none), indices}], fine to coarse, image: Blob or null}
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
        indices: readIndices(json, binary, indices),
      };
    });
  const image = json.images?.[0];
  const picture = image && new Blob([viewBytes(json, binary, image.bufferView)], { type: image.mimeType });
  return { levels, image: picture ?? null };
}
