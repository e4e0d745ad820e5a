export { AmbientLight, ArrowHelper, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, GridHelper, Group, LineBasicMaterial,
  LineLoop, LineSegments, Mesh, MeshStandardMaterial, PerspectiveCamera, Quaternion, Scene, SphereGeometry, Vector3, WebGLRenderer, AxesHelper } from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
