// What the relief looks like. Colours go to the screen as they are: the photograph is sRGB, and so is the screen;
// there is no tone mapping, and light falls only on the grey relief.
import { Color, DoubleSide, ShaderMaterial, Vector2, Vector3 } from 'three';

export const kLooks = ['photograph', 'grey', 'depth', 'normals'];

// Lightness rises evenly from far (dark blue) to near (yellow), as in the picture of the disparity map. page.css has
// the same colours for the scale bar.
const kHeat = [[24, 18, 77], [33, 62, 128], [25, 104, 140], [26, 145, 136], [72, 182, 107], [157, 212, 66], [250, 230, 70]];

const kWireOpacity = 0.5;
const kLeastWireOpacity = 0.08;
const kFreeSide_px = 10; // triangles of this side and larger ones leave their surface visible

// Each vertex stays on its ray from the left camera: flat at `lift` 0, where it was measured at 1.
const kPlaced = `
  uniform float lift;
  uniform float flatDepth;
  vec3 placed(vec3 p) {
    float inverse = mix(1.0 / flatDepth, -1.0 / p.z, lift);
    return p / (-p.z * inverse);
  }`;

// Texture coordinates times depth are linear over a triangle in space, as texture coordinates themselves are over its image
// in the photograph: so each point of a triangle gets the pixel that its ray went through.
const kVertex = `${kPlaced}
  varying vec3 at;
  varying vec3 towards;
  varying float inverseDepth;
  attribute float guess;
  varying float guessed;
  void main() {
    guessed = guess;
    vec3 place = placed(position);
    at = vec3(uv, 1.0) * -place.z;
    towards = mix(vec3(0.0, 0.0, 1.0), normal, lift);
    inverseDepth = -1.0 / position.z;
    gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
  }`;

const kFragment = `
  uniform int look;
  uniform sampler2D photograph;
  uniform vec2 inverseRange;
  uniform vec3 heat[${kHeat.length}];
  varying vec3 at;
  varying vec3 towards;
  varying float inverseDepth;
  uniform bool guesses;
  varying float guessed;
  vec3 heatColour(float share) {
    float place = clamp(share, 0.0, 1.0) * ${kHeat.length - 1}.0;
    vec3 colour = heat[0];
    for (int i = 0; i < ${kHeat.length - 1}; ++i)
      colour = mix(colour, heat[i + 1], clamp(place - float(i), 0.0, 1.0));
    return colour;
  }
  void main() {
    if (!guesses && guessed > 0.5) discard;
    vec3 facing = normalize(towards) * (gl_FrontFacing ? 1.0 : -1.0);
    vec3 colour;
    if (look == 0) colour = texture2D(photograph, at.xy / at.z).rgb;
    else if (look == 1) colour = vec3(0.22 + 0.68 * max(0.0, dot(facing, normalize(vec3(-0.5, 0.6, 0.8)))));
    else if (look == 2) colour = heatColour((inverseDepth - inverseRange.x) / (inverseRange.y - inverseRange.x));
    else colour = facing * 0.5 + 0.5;
    gl_FragColor = vec4(colour, 1.0);
  }`;

const kPlacedAlone = `${kPlaced}
  void main() { gl_Position = projectionMatrix * viewMatrix * vec4(placed(position), 1.0); }`;

// uniforms are shared by all materials of the page.
export function makeUniforms({ texture, flatDepth, inverseRange }) {
  return {
    look: { value: 0 },
    guesses: { value: true },
    lift: { value: 1 },
    flatDepth: { value: flatDepth },
    photograph: { value: texture },
    inverseRange: { value: new Vector2(...inverseRange) },
    heat: { value: kHeat.map(([r, g, b]) => new Vector3(r, g, b).divideScalar(255)) },
  };
}

export function surfaceMaterial(uniforms) {
  return new ShaderMaterial({
    uniforms, vertexShader: kVertex, fragmentShader: kFragment, side: DoubleSide, toneMapped: false,
    // Behind the lines of the wireframe, which lie on it.
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
}

// Lines a few px apart would cover the surface: they are drawn fainter the closer they lie. side: of the triangles at each
// vertex, as the left camera saw it, in focal lengths; height: of the view, px.
export function wireMaterial({ lift, flatDepth }) {
  return new ShaderMaterial({
    uniforms: { lift, flatDepth, colour: { value: new Color() }, height: { value: 1 } },
    vertexShader: `${kPlaced}
      attribute float side;
      uniform float height;
      varying float opacity;
      void main() {
        vec3 place = placed(position);
        gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
        float side_px = 0.5 * height * projectionMatrix[1][1] * side * -place.z / max(gl_Position.w, 1e-6);
        opacity = clamp(${kWireOpacity} * side_px / ${kFreeSide_px.toFixed(1)}, ${kLeastWireOpacity}, ${kWireOpacity});
      }`,
    fragmentShader: 'uniform vec3 colour; varying float opacity; void main() { gl_FragColor = vec4(colour, opacity); }',
    transparent: true, depthWrite: false, toneMapped: false,
  });
}

// Stripes of 6 px on the screen, wherever the relief leaves the photograph's frame open.
export function hatchMaterial({ lift, flatDepth }) {
  return new ShaderMaterial({
    uniforms: { lift, flatDepth, dark: { value: new Color() }, light: { value: new Color() }, size: { value: 6 } },
    vertexShader: kPlacedAlone,
    fragmentShader: `uniform vec3 dark, light; uniform float size;
      void main() {
        float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / (2.0 * size)));
        gl_FragColor = vec4(mix(dark, light, stripe), 1.0);
      }`,
    side: DoubleSide, toneMapped: false, depthWrite: false,
  });
}
