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

// An accessor's components, one after the other, as stored.
function readAccessor(json, binary, index) {
  const { bufferView, byteOffset = 0, componentType, count, type } = json.accessors[index];
  const bytes = viewBytes(json, binary, bufferView);
  const ArrayType = kArrays[componentType];
  const components = kComponents[type];
  const stored = new ArrayType(bytes.buffer, byteOffset);
  const stride = (json.bufferViews[bufferView].byteStride ?? components * ArrayType.BYTES_PER_ELEMENT) / ArrayType.BYTES_PER_ELEMENT;
  if (stride === components) return stored.subarray(0, count * components);
  const values = new ArrayType(count * components);
  for (let i = 0; i < count; ++i)
    for (let c = 0; c < components; ++c) values[i * components + c] = stored[i * stride + c];
  return values;
}

// Stored components times scale plus offset, in float32; scale and offset have one number a component.
function readScaled(json, binary, index, scale, offset) {
  const { componentType, normalized } = json.accessors[index];
  const divisor = normalized ? kLargest[componentType] : 1;
  const stored = readAccessor(json, binary, index);
  return Float32Array.from(stored, (value, i) => (value / divisor) * scale[i % scale.length] + offset[i % scale.length]);
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
        indices: readAccessor(json, binary, indices),
      };
    });
  const image = json.images?.[0];
  const picture = image && new Blob([viewBytes(json, binary, image.bufferView)], { type: image.mimeType });
  return { levels, image: picture ?? null };
}
