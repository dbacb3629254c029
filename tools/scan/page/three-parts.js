export {
  ArrowHelper, BufferAttribute, BufferGeometry, Color, Group, PerspectiveCamera, Points, PointsMaterial, Scene, Vector3, WebGLRenderer,
} from 'three';
export { OrbitControls } from 'three/addons/controls/OrbitControls.js';
