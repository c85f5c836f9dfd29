// A splat, the cameras that filmed it, and their photos: `mount(element, data)`.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";
import { Cameras } from "./cameras.js";
import { Overlay } from "./overlay.js";

const FLIGHT = 700; // milliseconds to a camera
const FIELD = 50; // degrees of the free view's height
// As the library draws: Kerbl et al.'s low-pass without compensation, to where an opaque Gaussian
// adds less than one level of 255, sorted by depth.
const AS_THE_LIBRARY = {
  preBlurAmount: 0.3,
  blurAmount: 0,
  maxStdDev: Math.sqrt(2 * Math.log(255)),
  minAlpha: 1 / 255,
  maxPixelRadius: 65536,
  sortRadial: false,
  accumExtSplats: true,
  clipXY: 1e4,
};
// The projection is linearised within 1.3 of the field of view, as Kerbl et al. do: Gaussians whose
// middle lies far outside reach into the picture otherwise as smears.
const FREE = "vec2 J2 = -(J1 * viewCenter.xy) * invZ;";
const WITHIN = `
  vec2 lens = vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
  vec2 aside = vec2(projectionMatrix[2][0], projectionMatrix[2][1]);
  vec2 tilt = clamp(-viewCenter.xy * invZ, (aside - 1.3) / lens, (aside + 1.3) / lens);
  vec2 J2 = J1 * tilt;`;

/** Bytes of base64 text that holds a gzip file. */
async function unpacked(text) {
  const packed = await fetch(`data:application/gzip;base64,${text}`);
  const stream = packed.body.pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Points as a cloud of dots. */
function dots(points, extent) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points.xyz.flat(), 3));
  const colours = points.rgb.flatMap((rgb) => new THREE.Color(`rgb(${rgb})`).toArray());
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
  const material = new THREE.PointsMaterial({ size: extent / 150, vertexColors: true });
  return new THREE.Points(geometry, material);
}

export class Viewer {
  constructor(element, data) {
    this.element = element;
    this.data = data;
    element.classList.add("fsel-viewer");
    this.renderer = new THREE.WebGLRenderer({ antialias: false });
    this.renderer.setClearColor(new THREE.Color().setRGB(...data.background, THREE.SRGBColorSpace));
    element.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, data.near, data.extent * 1000);
    this.camera.up.set(...data.up);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("start", () => this.leave());
    this.controls.addEventListener("change", () => this.redraw());
    this.at = null;
    this.chosen = () => {};
    this.overlay = new Overlay(this);
    this.cameras = new Cameras(this);
    this.ready = this.load();
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
    this.home();
  }

  async load() {
    const { model, points, extent } = this.data;
    if (!model) {
      if (points) this.scene.add(dots(points, extent));
      this.redraw();
      return;
    }
    this.spark = new SparkRenderer({
      renderer: this.renderer,
      onDirty: () => this.redraw(),
      ...AS_THE_LIBRARY,
    });
    const { material } = this.spark;
    if (!material.vertexShader.includes(FREE)) throw new Error("Spark's shader has changed");
    material.vertexShader = material.vertexShader.replace(FREE, WITHIN);
    const fileBytes = await unpacked(model);
    const splat = new SplatMesh({ fileBytes, fileType: "ply", extSplats: true });
    this.scene.add(this.spark, splat);
    await splat.initialized;
    this.redraw();
  }

  /** The view from outside, at the first; from farther where the page is narrow. */
  home() {
    this.leave();
    const { start, target } = this.data;
    this.controls.target.set(...target);
    this.camera.position.set(...start).sub(this.controls.target)
      .divideScalar(Math.min(this.camera.aspect, 1)).add(this.controls.target);
    this.controls.update();
    this.redraw();
  }

  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.asked = false;
      this.step(now);
      this.renderer.render(this.scene, this.camera);
      this.cameras.number();
    });
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.at !== null) this.fly(this.at, 0);
    this.redraw();
  }

  /** Where a camera's image lies in the element: as large as fits. */
  frame(entry) {
    const { clientWidth: width, clientHeight: height } = this.element;
    const [w, h] = entry.size;
    const scale = Math.min(width / w, height / h);
    return { left: (width - w * scale) / 2, top: (height - h * scale) / 2, scale };
  }

  /** The projection under which the element shows what a camera sees, and what lies around it. */
  projection(entry) {
    const { clientWidth: width, clientHeight: height } = this.element;
    const { left, top, scale } = this.frame(entry);
    const [fx, fy, cx, cy] = entry.intrinsics;
    const { near, far } = this.camera;
    const [x, y] = [near / (fx * scale), near / (fy * scale)];
    const [px, py] = [left + cx * scale, top + cy * scale];
    const sides = [-px * x, (width - px) * x, py * y, (py - height) * y];
    return new THREE.Matrix4().makePerspective(...sides, near, far);
  }

  /** Fly to a camera, and lay its photo over the rendering. */
  fly(index, milliseconds = FLIGHT) {
    const entry = this.data.cameras[index];
    const { position, quaternion } = this.cameras.poses[index];
    this.leave();
    this.at = index;
    this.flight = {
      begin: performance.now(),
      milliseconds,
      from: [this.camera.position.clone(), this.camera.quaternion.clone()],
      to: [position, quaternion],
      lens: [this.camera.projectionMatrix.clone(), this.projection(entry)],
      land: () => this.overlay.open(entry, this.frame(entry)),
    };
    this.cameras.mark(index);
    this.chosen(index);
    this.redraw();
  }

  /**
   * Go together with a list of frames: `chosen(frame)` is called for the camera that is flown to.
   * Returns a function that flies to the camera of a frame.
   */
  beside(names, chosen) {
    const frames = this.data.cameras.map(({ name }) => names.indexOf(name));
    this.chosen = (index) => frames[index] >= 0 && chosen(frames[index]);
    return (frame) => {
      const index = frames.indexOf(frame);
      if (index >= 0 && index !== this.at) this.fly(index);
    };
  }

  step(now) {
    if (!this.flight) return;
    const { begin, milliseconds, from, to, lens, land } = this.flight;
    const gone = milliseconds ? Math.min(Math.max((now - begin) / milliseconds, 0), 1) : 1;
    const share = gone * gone * (3 - 2 * gone);
    this.camera.position.lerpVectors(from[0], to[0], share);
    this.camera.quaternion.slerpQuaternions(from[1], to[1], share);
    const matrix = this.camera.projectionMatrix;
    matrix.elements.forEach((_, at) => {
      matrix.elements[at] =
        (1 - share) * lens[0].elements[at] + share * lens[1].elements[at];
    });
    this.camera.projectionMatrixInverse.copy(matrix).invert();
    if (gone < 1) return this.redraw();
    this.flight = null;
    land();
  }

  /** Leave a camera: the view is free again, and turns about what lies ahead. */
  leave() {
    this.flight = null;
    if (this.at === null) return;
    this.at = null;
    this.overlay.close();
    this.cameras.mark(null);
    this.camera.updateProjectionMatrix();
    const ahead = this.camera.getWorldDirection(new THREE.Vector3());
    const middle = new THREE.Vector3(...this.data.target).sub(this.camera.position);
    const distance = Math.max(middle.dot(ahead), this.data.extent / 10);
    this.controls.target.copy(this.camera.position).addScaledVector(ahead, distance);
    this.redraw();
  }
}

/** Show a scene in an element of some height; see `fsel.pages.viewer.scene` for the data. */
export function mount(element, data) {
  return new Viewer(element, data);
}
