// The distance between two points of the relief that are clicked on.
import { BufferAttribute, BufferGeometry, Color, Line, Points, Raycaster, ShaderMaterial, Vector2, Vector3 } from 'three';

const kMarker_px = 11;

function markMaterial(lit) {
  return new ShaderMaterial({
    uniforms: { size: { value: kMarker_px }, colour: { value: new Color() } },
    vertexShader: `uniform float size;
      void main() {
        gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
        gl_PointSize = size;
      }`,
    fragmentShader: lit
      ? `uniform vec3 colour;
        void main() {
          float away = length(gl_PointCoord - 0.5);
          if (away > 0.5) discard;
          gl_FragColor = vec4(away > 0.36 ? vec3(1.0) : colour, 1.0);
        }`
      : 'uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }',
    depthTest: false, toneMapped: false,
  });
}

export class Measure {
  constructor(relief) {
    this.relief = relief;
    this.ends = [];
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(6), 3));
    const materials = [markMaterial(false), markMaterial(true)];
    for (const material of materials) material.uniforms.colour.value.set(0xd9480f);
    this.marks = [new Line(geometry, materials[0]), new Points(geometry, materials[1])];
    for (const mark of this.marks) {
      mark.renderOrder = 2;
      mark.frustumCulled = false;
      relief.scene.add(mark);
    }
    this.geometry = geometry;
    this.#draw();
  }

  clear() {
    this.ends = [];
    this.#draw();
  }

  // At the point of the view that has normalised device coordinates x, y. Returns what to say.
  take(x, y, camera, pixelRatio) {
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(x, y), camera);
    const hit = ray.intersectObject(this.relief.mesh)[0];
    if (!hit) return 'No surface there';
    if (this.ends.length === 2) this.ends = [];
    this.ends.push(hit.point);
    this.marks[1].material.uniforms.size.value = kMarker_px * pixelRatio;
    this.#draw();
    return null;
  }

  // In the relief's unit; null before there are two ends.
  get distance() {
    return this.ends.length === 2 ? this.ends[0].distanceTo(this.ends[1]) : null;
  }

  #draw() {
    const positions = this.geometry.attributes.position;
    this.ends.forEach((end, i) => positions.setXYZ(i, ...new Vector3().copy(end).toArray()));
    positions.needsUpdate = true;
    this.geometry.setDrawRange(0, this.ends.length);
    for (const mark of this.marks) mark.visible = this.ends.length > 0;
  }
}
