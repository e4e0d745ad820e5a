// The real surfaces, the bodies and the force on the hand, seen from where one likes. World frame, z up, metres.
import * as three from './three-console.min.js';

const kMetresPerNewton = 0.01;
const colours = [0xf2a33c, 0xe4572e, 0x4cc38a, 0x6aa5ff, 0xb388eb, 0xd1d646, 0x3bc9db, 0xff8fab];

export class WorldView {
  constructor(parent) {
    this.parent = parent;
    this.renderer = new three.WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    parent.append(this.renderer.domElement);
    this.scene = new three.Scene();
    this.scene.background = new three.Color(0x141a22);
    this.camera = new three.PerspectiveCamera(45, 1, 0.01, 20);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(0.9, -1.1, 0.8);
    this.orbit = new three.OrbitControls(this.camera, this.renderer.domElement);
    this.scene.add(new three.AmbientLight(0xffffff, 1.4));
    const sun = new three.DirectionalLight(0xffffff, 2);
    sun.position.set(1, -1, 3);
    this.scene.add(sun, new three.AxesHelper(0.1));
    this.world = new three.Group();
    this.scene.add(this.world);
    this.bodies = [];
    this.arrow = new three.ArrowHelper(new three.Vector3(0, 0, 1), new three.Vector3(), 0.1, 0xff5555);
    this.arrow.visible = false;
    this.touch = new three.Mesh(new three.SphereGeometry(0.005), new three.MeshStandardMaterial({ color: 0xff5555 }));
    this.touch.visible = false;
    this.scene.add(this.arrow, this.touch);
    this.changed = true;
    this.orbit.addEventListener('change', () => { this.changed = true; });
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
  }

  resize() {
    const width = Math.max(100, this.parent.clientWidth), height = Math.max(100, this.parent.clientHeight);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  setScene(scene) {
    this.world.clear();
    this.bodies = scene.bodies.map((name, i) => {
      const mesh = new three.Mesh(new three.SphereGeometry(0.02, 24, 16), new three.MeshStandardMaterial({ color: colours[i % colours.length] }));
      mesh.visible = false;
      mesh.name = name;
      this.world.add(mesh);
      return mesh;
    });
    const corners = [];
    for (const surface of scene.surfaces) {
      const points = surface.corners.map((c) => new three.Vector3(c[0], c[1], c[2]));
      corners.push(...points);
      const outline = new three.BufferGeometry().setFromPoints(points);
      this.world.add(new three.LineLoop(outline, new three.LineBasicMaterial({ color: 0x6aa5ff })));
      const face = new three.BufferGeometry().setFromPoints([points[0], points[1], points[2], points[0], points[2], points[3]]);
      face.computeVertexNormals();
      this.world.add(new three.Mesh(face, new three.MeshStandardMaterial(
        { color: 0x3a6ea5, transparent: true, opacity: 0.18, side: three.DoubleSide, depthWrite: false })));
    }
    if (corners.length) this.lookAt(corners);
    this.changed = true;
  }

  // From the side of the person, so that all of it is in view.
  lookAt(points) {
    const middle = points.reduce((sum, p) => sum.add(p), new three.Vector3()).divideScalar(points.length);
    const radius = Math.max(0.2, ...points.map((p) => p.distanceTo(middle)));
    this.orbit.target.copy(middle);
    this.camera.position.copy(middle).add(new three.Vector3(1.4, -1.6, 1.3).multiplyScalar(radius));
    this.orbit.update();
  }

  draw(states) {
    if (states) {
      states.bodies.forEach((body, i) => {
        const mesh = this.bodies[i];
        if (!mesh) return;
        mesh.position.set(body[0], body[1], body[2]);
        mesh.quaternion.set(body[4], body[5], body[6], body[3]);
        mesh.visible = body[7];
      });
      const f = states.force[states.force.length - 1];
      const force = new three.Vector3(f[0], f[1], f[2]), size = force.length();
      this.touch.visible = this.arrow.visible = states.touch !== null;
      if (states.touch) {
        this.touch.position.set(...states.touch);
        this.arrow.position.set(...states.touch);
        this.arrow.visible = size > 0.01;
        if (size > 0.01) {
          this.arrow.setDirection(force.normalize());
          this.arrow.setLength(size * kMetresPerNewton + 0.02, 0.02, 0.012);
        }
      }
      this.changed = true;
    }
    if (!this.changed) return;
    this.changed = false;
    this.renderer.render(this.scene, this.camera);
  }
}
