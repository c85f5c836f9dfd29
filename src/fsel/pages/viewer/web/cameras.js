// Cameras as frusta, coloured by their state; the nearest to the pointer is named.
import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

const NEAR_BY = { mouse: 16, touch: 30 }; // pixels within which a camera is meant
const STILL = 6; // pixels that a click may move
const [WIDTH, EDGE] = [2, 1.25]; // pixels of a line, and of the dark edge around it: on any ground
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
    this.orders = cameras.flatMap((entry, at) => (entry.order ? [[entry.order, at]] : []))
      .sort((a, b) => a[0] - b[0])
      .map(([order, at]) => [viewer.overlay.order(order), at]);
    this.marked = null;
    this.listen(viewer.renderer.domElement);
  }

  frustum({ intrinsics: [fx, fy], size: [w, h] }, { position, quaternion }, length) {
    const place = (x, y) => new THREE.Vector3((x * w) / fx / 2, (y * h) / fy / 2, -1)
      .multiplyScalar(length).applyQuaternion(quaternion).add(position);
    return [position, ...CORNERS.map(([x, y]) => place(x, y))];
  }

  drawn(indices, colour, over = false) {
    const ends = indices.flatMap((at) => EDGES.flat().map((corner) => this.corners[at][corner]));
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(ends.flatMap((end) => end.toArray()));
    const drawn = new THREE.Group();
    [["#111", WIDTH + 2 * EDGE], [colour, WIDTH]].forEach(([color, linewidth], order) => {
      const material = new LineMaterial({ color, linewidth, depthTest: !over });
      const behind = { polygonOffset: !order, polygonOffsetFactor: 4, polygonOffsetUnits: 16 };
      const lines = new LineSegments2(geometry, Object.assign(material, behind));
      lines.renderOrder = order + (over ? 2 : 0);
      drawn.add(lines);
    });
    return drawn;
  }

  /** Where a place is seen, in pixels of the element; null where it is not. */
  seen(place) {
    const { x, y, z } = place.clone().project(this.viewer.camera);
    const { clientWidth: width, clientHeight: height } = this.viewer.element;
    return z > 1 ? null : [((x + 1) / 2) * width, ((1 - y) / 2) * height];
  }

  /** Write the order of every pick at its camera, where no earlier one's is. */
  number() {
    const written = [];
    for (const [badge, at] of this.orders) {
      const { visible } = this.lines[this.viewer.data.cameras[at].state];
      const place = this.group.visible && visible ? this.seen(this.poses[at].position) : null;
      badge.hidden = !place || written.some(([x, y]) => Math.hypot(x - place[0], y - place[1]) < 18);
      if (badge.hidden) continue;
      written.push(place);
      badge.style.transform = `translate(${place[0]}px, ${place[1]}px) translate(-50%, -50%)`;
    }
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
    const outside = index !== null && this.viewer.at === null;
    this.marked = outside ? this.drawn([index], "#ffd400", true) : null;
    if (this.marked) this.viewer.scene.add(this.marked);
    this.viewer.redraw();
  }

  /** The camera that a pointer means, or null. */
  under(event) {
    const box = this.viewer.element.getBoundingClientRect();
    let [best, found] = [NEAR_BY[event.pointerType] ?? NEAR_BY.mouse, null];
    this.viewer.data.cameras.forEach((entry, at) => {
      if (!this.lines[entry.state].visible) return;
      const middle = this.corners[at].reduce((sum, corner) => sum.add(corner), new THREE.Vector3());
      const seen = this.seen(middle.divideScalar(5));
      if (!seen) return;
      const [x, y] = [event.clientX - box.left, event.clientY - box.top];
      const distance = Math.hypot(x - seen[0], y - seen[1]);
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
