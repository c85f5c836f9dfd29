// Cameras as frusta, coloured by their state; the nearest to the pointer is named.
import * as THREE from "three";

const NEAR_BY = { mouse: 16, touch: 30 }; // pixels within which a camera is meant
const STILL = 6; // pixels that a click may move
const CORNERS = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
const EDGES = [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1]];

/** Position and turn of a camera whose pose is 12 numbers, world to camera, OpenCV axes. */
function placed([a, b, c, x, d, e, f, y, g, h, i, z]) {
  const turn = new THREE.Matrix4();
  turn.set(a, -d, -g, 0, b, -e, -h, 0, c, -f, -i, 0, 0, 0, 0, 1);
  const position = new THREE.Vector3(-x, y, z).applyMatrix4(turn);
  return { position, quaternion: new THREE.Quaternion().setFromRotationMatrix(turn) };
}

export class Cameras {
  constructor(viewer) {
    this.viewer = viewer;
    const { cameras, states, extent } = viewer.data;
    this.poses = cameras.map((entry) => placed(entry.pose));
    this.corners = cameras.map((entry, at) => this.frustum(entry, this.poses[at], extent / 25));
    this.lines = {};
    this.group = new THREE.Group();
    viewer.scene.add(this.group);
    for (const [state, { colour }] of Object.entries(states)) {
      const own = cameras.flatMap((entry, at) => (entry.state === state ? [at] : []));
      this.lines[state] = this.drawn(own, colour);
      this.group.add(this.lines[state]);
    }
    this.marked = null;
    this.listen(viewer.renderer.domElement);
  }

  frustum({ intrinsics: [fx, fy], size: [w, h] }, { position, quaternion }, length) {
    const place = (x, y) => new THREE.Vector3((x * w) / fx / 2, (y * h) / fy / 2, -1)
      .multiplyScalar(length).applyQuaternion(quaternion).add(position);
    return [position, ...CORNERS.map(([x, y]) => place(x, y))];
  }

  drawn(indices, colour) {
    const ends = indices.flatMap((at) => EDGES.flat().map((corner) => this.corners[at][corner]));
    const geometry = new THREE.BufferGeometry().setFromPoints(ends);
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour }));
  }

  /** Show or hide the cameras of a state. */
  show(state, shown) {
    this.lines[state].visible = shown;
    this.viewer.redraw();
  }

  /** Draw one camera over everything, or none; while one looks through a camera, no other. */
  mark(index) {
    this.group.visible = this.viewer.at === null;
    if (this.marked) this.viewer.scene.remove(this.marked);
    this.marked = index === null || this.viewer.at !== null ? null : this.drawn([index], "#ffd400");
    if (this.marked) {
      this.marked.material.depthTest = false;
      this.marked.renderOrder = 1;
      this.viewer.scene.add(this.marked);
    }
    this.viewer.redraw();
  }

  /** The camera that a pointer means, or null. */
  under(event) {
    const canvas = this.viewer.renderer.domElement;
    const box = canvas.getBoundingClientRect();
    let [best, found] = [NEAR_BY[event.pointerType] ?? NEAR_BY.mouse, null];
    this.viewer.data.cameras.forEach((entry, at) => {
      if (!this.lines[entry.state].visible) return;
      const middle = this.corners[at].reduce((sum, corner) => sum.add(corner), new THREE.Vector3());
      const seen = middle.divideScalar(5).project(this.viewer.camera);
      if (seen.z > 1) return;
      const x = box.left + ((seen.x + 1) / 2) * box.width;
      const y = box.top + ((1 - seen.y) / 2) * box.height;
      const distance = Math.hypot(event.clientX - x, event.clientY - y);
      if (distance < best) [best, found] = [distance, at];
    });
    return found;
  }

  listen(canvas) {
    let pressed = null;
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons || this.viewer.at !== null) return;
      const index = this.under(event);
      this.mark(index);
      this.viewer.overlay.name(index, event);
      canvas.style.cursor = index === null ? "grab" : "pointer";
    });
    canvas.addEventListener("pointerleave", () => this.viewer.overlay.name(null));
    canvas.addEventListener("pointerdown", (event) => {
      pressed = { x: event.clientX, y: event.clientY, index: this.under(event) };
      this.viewer.overlay.name(null);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (!pressed || pressed.index === null) return;
      const moved = Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y);
      if (moved < STILL) this.viewer.fly(pressed.index);
      pressed = null;
    });
  }
}
