// What lies over the canvas: the legend, a camera's picture, the photo with its slider.

/** A new element of HTML. */
function made(tag, name, parent, text = "") {
  const element = document.createElement(tag);
  element.className = name;
  element.textContent = text;
  parent.append(element);
  return element;
}

export class Overlay {
  constructor(viewer) {
    this.viewer = viewer;
    const over = viewer.element;
    this.tip = made("div", "tip", over);
    this.photo = made("div", "photo", over);
    this.image = made("img", "", this.photo);
    this.line = made("div", "line", this.photo);
    this.bar = made("div", "bar", over);
    this.caption = made("span", "caption", this.bar);
    this.slider = made("input", "", this.bar);
    Object.assign(this.slider, { type: "range", value: 50, step: 0.5, ariaLabel: "photo, rendering" });
    this.legend = made("div", "legend", over);
    for (const part of [this.tip, this.photo, this.bar]) part.hidden = true;
    this.slider.addEventListener("input", () => this.slide());
    this.line.addEventListener("pointerdown", (event) => this.line.setPointerCapture(event.pointerId));
    this.line.addEventListener("pointermove", (event) => this.drag(event));
    this.buttons();
    this.states();
    over.tabIndex = 0;
    over.addEventListener("keydown", (event) => this.key(event));
  }

  buttons() {
    const keys = { "‹": () => this.next(-1), "›": () => this.next(1), "×": () => this.viewer.leave() };
    const said = { "‹": "previous camera", "›": "next camera", "×": "leave the camera" };
    for (const [sign, act] of Object.entries(keys)) {
      const button = made("button", "", this.bar, sign);
      Object.assign(button, { title: said[sign], ariaLabel: said[sign], onclick: act });
    }
  }

  states() {
    const { cameras, states } = this.viewer.data;
    for (const [state, { colour, label }] of Object.entries(states)) {
      const count = cameras.filter((entry) => entry.state === state).length;
      if (!count) continue;
      const line = made("label", "", this.legend);
      const box = made("input", "", line);
      Object.assign(box, { type: "checkbox", checked: true });
      box.style.accentColor = colour;
      line.append(` ${label} `);
      made("b", "", line, String(count));
      box.addEventListener("change", () => this.viewer.cameras.show(state, box.checked));
    }
    const button = made("button", "", this.legend, "whole scene");
    button.onclick = () => this.viewer.home();
    if (!document.fullscreenEnabled) return;
    const whole = made("button", "", this.legend, "full screen");
    whole.onclick = () => document.fullscreenElement
      ? document.exitFullscreen()
      : this.viewer.element.requestFullscreen();
  }

  /** A badge with the order of a pick, below all else. */
  order(number) {
    const badge = made("b", "order", this.viewer.element, String(number));
    this.viewer.element.insertBefore(badge, this.tip);
    return badge;
  }

  key(event) {
    const acts = {
      ArrowLeft: () => this.next(-1),
      ArrowRight: () => this.next(1),
      Escape: () => this.viewer.leave(),
      Home: () => this.viewer.home(),
    };
    if (!acts[event.key] || event.target === this.slider) return;
    event.preventDefault();
    event.stopPropagation();
    acts[event.key]();
  }

  /** The next camera in the order of the capture, of those that are shown. */
  next(by) {
    const { cameras } = this.viewer.data;
    let at = this.viewer.at ?? (by > 0 ? -1 : 0);
    for (let tried = 0; tried < cameras.length; tried++) {
      at = (at + by + cameras.length) % cameras.length;
      if (!this.viewer.cameras.lines[cameras[at].state].visible) continue;
      return this.viewer.fly(at);
    }
  }

  /** Name a camera beside the pointer, with its picture; or nothing. */
  name(index, event) {
    this.tip.hidden = index === null;
    if (index === null || index === this.named) return;
    this.named = index;
    const entry = this.viewer.data.cameras[index];
    this.tip.replaceChildren();
    if (entry.picture) made("img", "", this.tip).src = entry.picture;
    made("b", "", this.tip, entry.name);
    made("span", "", this.tip, entry.note);
    const box = this.viewer.element.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    this.tip.style[x > box.width / 2 ? "right" : "left"] =
      `${Math.max(x > box.width / 2 ? box.width - x : x, 0) + 14}px`;
    this.tip.style[x > box.width / 2 ? "left" : "right"] = "auto";
    this.tip.style.top = `${Math.min(y, Math.max(box.height - 240, 0))}px`;
  }

  /** Lay a camera's photo over the rendering at its pose. */
  open(entry, { left, top, scale }) {
    this.tip.hidden = true;
    this.caption.textContent = entry.note ? `${entry.name}: ${entry.note}` : entry.name;
    this.bar.hidden = false;
    this.slider.hidden = this.photo.hidden = !entry.picture;
    if (!entry.picture) return;
    this.image.src = entry.picture;
    const [width, height] = entry.size.map((side) => `${side * scale}px`);
    Object.assign(this.photo.style, { left: `${left}px`, top: `${top}px`, width, height });
    this.slide();
  }

  close() {
    this.photo.hidden = this.bar.hidden = true;
  }

  slide() {
    const share = Number(this.slider.value);
    this.image.style.clipPath = `inset(0 ${100 - share}% 0 0)`;
    this.line.style.left = `${share}%`;
  }

  drag(event) {
    if (!event.buttons) return;
    const box = this.photo.getBoundingClientRect();
    this.slider.value = (100 * (event.clientX - box.left)) / box.width;
    this.slide();
  }
}
