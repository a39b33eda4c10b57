// The relief as three.js holds it: levels of detail, wireframe, and the hatched wall behind its holes.
import { BufferAttribute, BufferGeometry, LineSegments, Mesh, Scene, Sphere, Texture, LinearMipmapLinearFilter } from 'three';
import { hatchMaterial, kLooks, makeUniforms, surfaceMaterial, wireMaterial } from './materials.js';

const kNobody = 3; // provenance of what no camera saw

// The photograph on the graphics card; smaller where that takes no such large one.
export async function makeTexture(image, renderer) {
  const options = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
  let bitmap = await createImageBitmap(image, options);
  const most = renderer.capabilities.maxTextureSize;
  const longest = Math.max(bitmap.width, bitmap.height);
  if (longest > most)
    bitmap = await createImageBitmap(image, {
      ...options,
      resizeWidth: Math.floor((bitmap.width * most) / longest),
      resizeHeight: Math.floor((bitmap.height * most) / longest),
    });
  const texture = new Texture(bitmap);
  texture.flipY = false;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.anisotropy = renderer.capabilities.getMaxAnisotropy();
  texture.needsUpdate = true;
  return texture;
}

// Of all vertices, {low, middle, high}: the inverse depths below which half a percent, half, and all but half a
// percent of them lie, so that a few stray vertices do not take all colours.
function inverseDepths(positions) {
  const inverse = new Float32Array(positions.length / 3);
  for (let i = 0; i < inverse.length; ++i) inverse[i] = -1 / positions[3 * i + 2];
  inverse.sort();
  const at = (share) => inverse[Math.round(share * (inverse.length - 1))];
  const [low, middle, high] = [at(0.005), at(0.5), at(0.995)];
  return { low, middle, high: high > low ? high : low * 1.0001 };
}

// A rectangle that fills the photograph's frame at a depth.
function wallGeometry({ focal_px, cx, cy, width, height }, depth) {
  const corner = (x, y) => [((x - cx) * depth) / focal_px, ((cy - y) * depth) / focal_px, -depth];
  const geometry = new BufferGeometry();
  const corners = [corner(0, 0), corner(0, height), corner(width, 0), corner(width, height)];
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(corners.flat()), 3));
  geometry.setIndex([0, 1, 2, 2, 1, 3]);
  return geometry;
}

// At each vertex the mean, over its triangles, of their shortest sides in the photograph, in focal lengths.
function shortSides(corners, positions) {
  const sums = new Float32Array(positions.length / 3);
  const counts = new Uint32Array(sums.length);
  const seen = (i, axis) => positions[i + axis] / positions[i + 2];
  const length = (i, j) => Math.hypot(seen(i, 0) - seen(j, 0), seen(i, 1) - seen(j, 1));
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * corners[t + k]);
    const shortest = Math.min(length(a, b), length(b, c), length(c, a));
    for (let k = 0; k < 3; ++k) {
      sums[corners[t + k]] += shortest;
      ++counts[corners[t + k]];
    }
  }
  return sums.map((sum, i) => sum / counts[i]);
}

export class Relief {
  // levels as of readGlb(); texture may be null; photo as in camera.js.
  constructor(levels, texture, photo) {
    this.inverse = inverseDepths(levels[0].positions);
    this.depth = 1 / this.inverse.middle;
    this.uniforms = makeUniforms({ texture, flatDepth: this.depth, inverseRange: [this.inverse.low, this.inverse.high] });
    this.surface = surfaceMaterial(this.uniforms);
    this.wire = wireMaterial(this.uniforms);
    this.hatch = hatchMaterial(this.uniforms);
    this.scene = new Scene();
    this.levels = levels.map((level) => this.#addLevel(level));
    this.wires = this.levels.map(() => null);
    this.sphere = this.#boundingSphere(photo);
    this.wireframe = false;
    this.setLevel(0);
    this.setLook(texture ? 'photograph' : 'grey');
  }

  #addLevel({ positions, texcoords, provenance, indices }) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    if (texcoords) geometry.setAttribute('uv', new BufferAttribute(texcoords, 2));
    if (provenance) geometry.setAttribute('guess', new BufferAttribute(provenance.map((value) => Number(value === kNobody)), 1));
    geometry.setIndex(new BufferAttribute(indices, 1));
    const mesh = new Mesh(geometry, this.surface);
    // The shader moves the vertices, so three.js cannot tell what is seen.
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    return mesh;
  }

  #boundingSphere(photo) {
    const { geometry } = this.levels[0];
    geometry.computeBoundingBox();
    const farthest = -geometry.boundingBox.min.z;
    const wall = new Mesh(wallGeometry(photo, 1.01 * farthest), this.hatch);
    wall.renderOrder = -1;
    wall.frustumCulled = false;
    this.wall = wall;
    this.scene.add(wall);
    const box = geometry.boundingBox.clone();
    wall.geometry.computeBoundingBox();
    box.union(wall.geometry.boundingBox);
    return box.getBoundingSphere(new Sphere());
  }

  get mesh() {
    return this.levels[this.level];
  }

  setLevel(level) {
    this.level = level;
    this.levels.forEach((mesh, i) => { mesh.visible = i === level; });
    this.setWireframe(this.wireframe);
    if (this.look) this.setLook(this.look);
  }

  setLook(look) {
    this.look = look;
    this.uniforms.look.value = kLooks.indexOf(look);
    const { geometry } = this.mesh;
    if ((look === 'grey' || look === 'normals') && !geometry.attributes.normal) geometry.computeVertexNormals();
  }

  get hasGuesses() {
    return this.mesh.geometry.attributes.guess !== undefined;
  }

  // Shows or leaves open what no camera saw.
  setGuesses(shown) {
    this.uniforms.guesses.value = shown;
  }

  // Never quite flat: what is nearer still hides what lies behind it.
  setLift(lift) {
    this.uniforms.lift.value = Math.max(lift, 0.002);
  }

  setWireframe(shown) {
    this.wireframe = shown;
    if (shown && !this.wires[this.level]) this.wires[this.level] = this.#makeWire();
    this.wires.forEach((wire, i) => { if (wire) wire.visible = shown && i === this.level; });
  }

  // All sides of all triangles: what two of them share is drawn twice, which nobody sees.
  #makeWire() {
    const { geometry } = this.mesh;
    const corners = geometry.index.array;
    const sides = new corners.constructor(2 * corners.length);
    for (let t = 0; t < corners.length; t += 3)
      for (let k = 0; k < 3; ++k) {
        sides[2 * (t + k)] = corners[t + k];
        sides[2 * (t + k) + 1] = corners[t + ((k + 1) % 3)];
      }
    const lines = new BufferGeometry();
    lines.setAttribute('position', geometry.attributes.position);
    lines.setAttribute('side', new BufferAttribute(shortSides(corners, geometry.attributes.position.array), 1));
    lines.setIndex(new BufferAttribute(sides, 1));
    const wire = new LineSegments(lines, this.wire);
    wire.frustumCulled = false;
    this.scene.add(wire);
    return wire;
  }
}
