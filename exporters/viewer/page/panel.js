// What stands beside the view: figures, stage pictures, the scale bar. Text is only ever set as text.
const byId = (id) => document.getElementById(id);

function element(name, text) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  return made;
}

// Three significant digits, without an exponent.
export function rounded(value) {
  if (!Number.isFinite(value)) return '–';
  const digits = value === 0 ? 0 : Math.max(0, 2 - Math.floor(Math.log10(Math.abs(value))));
  return value.toFixed(Math.min(digits, 6));
}

// With the given number of decimals, thousands apart.
function grouped(value, decimals = 0) {
  return value.toLocaleString('en', { minimumFractionDigits: decimals, maximumFractionDigits: decimals });
}

function bytes(count) {
  return count < 1e6 ? `${rounded(count / 1e3)} kB` : `${rounded(count / 1e6)} MB`;
}

function addFigure(name, value) {
  const row = element('tr');
  const head = element('th', name);
  head.scope = 'row';
  row.append(head, element('td', value));
  byId('figures').append(row);
}

// Of the level of detail that is shown.
export function showFigures(facts, level) {
  byId('figures').replaceChildren();
  for (const { name, value, decimals, unit } of facts.figures)
    addFigure(name, value === null ? '–' : `${grouped(value, decimals)} ${unit}`);
  const { vertices, triangles } = facts.levels[level];
  addFigure('Vertices', grouped(vertices));
  addFigure('Triangles', grouped(triangles));
  const sizes = facts.bytes ?? {};
  if (sizes.plain) addFigure('Plain GLB, no texture', bytes(sizes.plain));
  if (sizes.draco) addFigure('With Draco', bytes(sizes.draco));
  if (sizes.meshopt) addFigure('With meshopt', bytes(sizes.meshopt));
}

export function showLevels(facts) {
  byId('levels').hidden = facts.levels.length < 2;
  facts.levels.forEach(({ triangles }, i) => {
    const option = element('option', `${i}: ${grouped(triangles)} triangles`);
    option.value = String(i);
    byId('level').append(option);
  });
}

export function showPictures(pictures) {
  byId('stages').hidden = pictures.length === 0;
  for (const { label, source } of pictures) {
    const figure = element('figure');
    const image = element('img');
    image.src = source;
    image.alt = label;
    figure.append(image, element('figcaption', label));
    byId('pictures').append(figure);
  }
}

// inverse: {low, high} inverse depths at the ends of the bar; camera as in the facts.
export function showScale(inverse, camera) {
  const unit = camera.metric ? 'm' : 'px';
  const labels = [0, 0.25, 0.5, 0.75, 1].map((share) => {
    const at = inverse.low + share * (inverse.high - inverse.low);
    return rounded(camera.metric ? 1 / at : camera.focal_px * camera.baseline_m * at - camera.doffs_px);
  });
  labels.forEach((label, i) => byId('ticks').append(element('li', i === 0 || i === 4 ? `${label} ${unit}` : label)));
  byId('heat').ariaLabel = `Colours from ${labels[0]} ${unit}, dark blue, to ${labels[4]} ${unit}, yellow`;
}
