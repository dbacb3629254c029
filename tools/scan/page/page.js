'use strict';
// Shows the JSON of the element 'scan': m, in the frame of the registered cloud; clouds are base64 of little-endian float32.

const scan = JSON.parse(document.getElementById('scan').textContent);
const NOT_MEASURED = new THREE.Color(0x8a8f98);
const VIEW_COLOURS = [0x4e9af1, 0xf1a34e, 0x7bd389, 0xc792ea, 0xf76e8b, 0x5fd3d3, 0xd6cf5a, 0xb0a08f];

const byId = (id) => document.getElementById(id);

function floats(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

// White where the surface is as it should be, red inside, blue outside.
function colourOf(deviation, reach) {
  if (!Number.isFinite(deviation)) return NOT_MEASURED;
  const share = Math.max(-1, Math.min(1, deviation / reach));
  const full = new THREE.Color(share < 0 ? 0xe0261c : 0x2060e0);
  return new THREE.Color(0xf4f4f0).lerp(full, Math.abs(share) ** 0.7);
}

function pointsOf(positions, colourAt, size) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  const colours = new Float32Array(positions.length);
  for (let i = 0; i < positions.length / 3; i += 1) colourAt(i).toArray(colours, 3 * i);
  geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  return new THREE.Points(geometry, new THREE.PointsMaterial({ size, vertexColors: true }));
}

function plain(positions, colour, size) {
  const one = new THREE.Color(colour);
  return pointsOf(positions, () => one, size);
}

function row(table, cells) {
  const line = table.insertRow();
  for (const cell of cells) line.insertCell().textContent = cell;
}

function drawScale(reach) {
  const context = byId('scale').getContext('2d');
  for (let x = 0; x < 300; x += 1) {
    context.fillStyle = `#${colourOf((x / 149.5 - 1) * reach, reach).getHexString()}`;
    context.fillRect(x, 0, 1, 16);
  }
  for (const share of [-1, -0.5, 0, 0.5, 1]) {
    const tick = document.createElement('span');
    tick.textContent = `${share > 0 ? '+' : ''}${(1000 * share * reach).toFixed(0)}`;
    byId('ticks').append(tick);
  }
  byId('ticks').lastChild.textContent += ' mm';
  byId('deviation').hidden = false;
}

function arrowInto(dent) {
  const LENGTH = 0.05;
  const way = new THREE.Vector3(...dent.direction);
  const tail = new THREE.Vector3(...dent.centre).addScaledVector(way, LENGTH + 0.004);
  return new THREE.ArrowHelper(way.negate(), tail, LENGTH, 0xffd23c, 0.012, 0.008);
}

function checkbox(name, colour, thing) {
  const label = document.createElement('label');
  const box = document.createElement('input');
  box.type = 'checkbox';
  box.checked = thing.visible;
  box.addEventListener('change', () => { thing.visible = box.checked; draw(); });
  const swatch = document.createElement('span');
  swatch.className = 'swatch';
  swatch.style.background = colour;
  label.append(box, ' ', swatch, name);
  byId('clouds').append(label, document.createElement('br'));
}

document.title = `${scan.title} ${scan.scan_id}`;
byId('label').textContent = scan.title;
byId('answer').textContent = scan.answer;
byId('summary').textContent = scan.summary;
for (const [name, value] of scan.facts) row(byId('facts'), [name, value]);
row(byId('facts'), ['time', new Date(1000 * scan.stamp_s).toLocaleString()]);

const world = new THREE.Scene();
world.background = new THREE.Color(0x20242a);
const positions = floats(scan.object);
let object;
if (scan.deviation) {
  const deviations = floats(scan.deviation);
  drawScale(scan.deviation_reach);
  object = pointsOf(positions, (i) => colourOf(deviations[i], scan.deviation_reach), 0.0022);
} else {
  object = plain(positions, 0x60dc78, 0.0022);
}
world.add(object);
checkbox('object', scan.deviation ? '#e0261c' : '#60dc78', object);

scan.dents.forEach((dent, number) => {
  world.add(arrowInto(dent));
  row(byId('dents'), [`${number + 1}`, dent.depth, dent.at_height, dent.extent]);
  byId('dented').hidden = false;
});

scan.views.forEach((view, number) => {
  const colour = VIEW_COLOURS[number % VIEW_COLOURS.length];
  const points = plain(floats(view.points), colour, 0.0014);
  points.visible = false;
  world.add(points);
  checkbox(view.name, `#${new THREE.Color(colour).getHexString()}`, points);
});

if (scan.shape) {
  const shape = plain(floats(scan.shape), 0x7f8ea8, 0.0016);
  world.add(shape);
  checkbox('shape, by analysis by synthesis', '#7f8ea8', shape);
}

const renderer = new THREE.WebGLRenderer({ antialias: true });
byId('picture').prepend(renderer.domElement);
const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 10);
camera.up.set(...scan.up);
const controls = new THREE.OrbitControls(camera, renderer.domElement);
const draw = () => renderer.render(world, camera);

function look() {
  object.geometry.computeBoundingSphere();
  const { center, radius } = object.geometry.boundingSphere;
  const from = new THREE.Vector3(...scan.look_from).normalize();
  const distance = 3.2 * Math.max(radius, 0.02) / Math.min(1, camera.aspect);
  controls.target.copy(center);
  camera.position.copy(center).addScaledVector(from, distance);
  controls.update();
}

function fit() {
  const { clientWidth, clientHeight } = byId('picture');
  renderer.setPixelRatio(window.devicePixelRatio);
  renderer.setSize(clientWidth, clientHeight);
  camera.aspect = clientWidth / Math.max(clientHeight, 1);
  camera.updateProjectionMatrix();
  draw();
}

controls.addEventListener('change', draw);
window.addEventListener('resize', fit);
fit();
look();
draw();
