// Cameras, targets and points on a canvas, turned and zoomed with finger, mouse or keys; no library.
// mountScene(element, data, chosen): data has points, targets and frames [place, tip] with their
// kinds and orders; chosen(frame) is called for a click. Returns show(frame), which rings a camera.
function mountScene(element, data, chosen) {
  const canvas = document.createElement('canvas');
  const pen = canvas.getContext('2d');
  canvas.tabIndex = 0;
  canvas.className = 'scene';
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label',
    'cameras and points; turn with the arrow keys, zoom with plus and minus');
  element.prepend(canvas);
  const COLOURS = { pick: '#d55e00', held: '#0072b2', bad: '#b00020', left: '#a0a0a0' };
  let yaw = 0.7, pitch = 0.6, zoom = 1, panX = 0, panY = 0, due = false, now = -1, seen = [];

  const project = ([x, y, z]) => {
    const a = Math.cos(yaw), b = Math.sin(yaw), c = Math.cos(pitch), d = Math.sin(pitch);
    const right = a * x + b * y, ahead = -b * x + a * y;
    const scale = zoom * Math.min(canvas.width, canvas.height) * 0.55;
    return [
      canvas.width / 2 + panX + scale * right,
      canvas.height / 2 + panY - scale * (c * z + d * ahead),
      c * ahead - d * z,
    ];
  };
  const disc = (x, y, size, colour) => {
    pen.fillStyle = colour;
    pen.beginPath(); pen.arc(x, y, size, 0, 7); pen.fill();
  };
  const camera = ([place, tip], colour, size) => {
    const [x, y] = project(place), [u, v] = project(tip);
    pen.strokeStyle = colour;
    pen.lineWidth = Math.max(1, size / 2.5);
    pen.beginPath(); pen.moveTo(x, y); pen.lineTo(u, v); pen.stroke();
    disc(x, y, size, colour);
    return [x, y];
  };
  // the order of a pick is written where no earlier pick's lies under it
  const orders = (ratio) => {
    const written = [], size = 7.5 * ratio;
    pen.font = `600 ${9 * ratio}px system-ui, sans-serif`;
    pen.textAlign = 'center'; pen.textBaseline = 'middle';
    const picks = data.orders.map((order, frame) => [order, frame]).filter(([order]) => order);
    for (const [order, frame] of picks.sort((a, b) => a[0] - b[0])) {
      const [x, y] = seen[frame];
      if (written.some(([u, v]) => Math.hypot(u - x, v - y) < 2 * size)) continue;
      written.push([x, y]);
      disc(x, y, size, COLOURS.pick);
      pen.fillStyle = '#fff';
      pen.fillText(String(order), x, y);
    }
  };
  const draw = () => {
    due = false;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    const far = data.points.map((p) => [project(p), p]).sort((a, b) => b[0][2] - a[0][2]);
    for (const [[x, y], p] of far) {
      pen.fillStyle = `rgb(${p[3]},${p[4]},${p[5]})`;
      pen.fillRect(x, y, 2 * ratio, 2 * ratio);
    }
    for (const target of data.targets) camera(target, '#56b4e9', 1.6 * ratio);
    seen = data.frames.map((frame, at) => {
      const kind = data.kinds[at];
      return camera(frame, COLOURS[kind], (kind === 'left' ? 2.2 : 3.5) * ratio);
    });
    orders(ratio);
    if (now < 0) return;
    const [x, y] = seen[now];
    pen.strokeStyle = '#111'; pen.lineWidth = 2 * ratio;
    pen.beginPath(); pen.arc(x, y, 11 * ratio, 0, 7); pen.stroke();
  };
  const ask = () => { if (!due) { due = true; requestAnimationFrame(draw); } };
  const turn = (dx, dy) => {
    yaw -= dx; pitch = Math.min(1.57, Math.max(-1.57, pitch + dy)); ask();
  };
  const scale = (factor) => { zoom = Math.min(40, Math.max(0.2, zoom * factor)); ask(); };
  // the camera under a place of the window, picks before others
  const under = (event) => {
    const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
    const x = (event.clientX - box.left) * ratio, y = (event.clientY - box.top) * ratio;
    let best = -1, least = 12 * ratio;
    seen.forEach(([u, v], frame) => {
      const apart = Math.hypot(u - x, v - y) - (data.orders[frame] ? 5 * ratio : 0);
      if (apart < least) { least = apart; best = frame; }
    });
    return best;
  };

  const touches = new Map();
  let moved = 0;
  const spread = () => {
    const [a, b] = [...touches.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture?.(event.pointerId);
    touches.set(event.pointerId, [event.clientX, event.clientY]);
    moved = 0;
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = touches.get(event.pointerId);
    if (!before) { canvas.style.cursor = under(event) < 0 ? 'grab' : 'pointer'; return; }
    const apart = touches.size === 2 ? spread() : 0;
    touches.set(event.pointerId, [event.clientX, event.clientY]);
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    moved += Math.abs(dx) + Math.abs(dy);
    if (touches.size === 2) scale(spread() / Math.max(apart, 1));
    else if (event.shiftKey) { panX += dx * devicePixelRatio; panY += dy * devicePixelRatio; ask(); }
    else turn(dx / 150, dy / 150);
  });
  for (const name of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(name, (event) => touches.delete(event.pointerId));
  }
  canvas.addEventListener('click', (event) => {
    const frame = moved < 6 ? under(event) : -1;
    if (frame >= 0) chosen(frame);
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    scale(Math.exp(-event.deltaY / 500));
  }, { passive: false });
  const keys = {
    ArrowLeft: () => turn(0.15, 0), ArrowRight: () => turn(-0.15, 0),
    ArrowUp: () => turn(0, -0.15), ArrowDown: () => turn(0, 0.15),
    '+': () => scale(1.2), '=': () => scale(1.2), '-': () => scale(1 / 1.2),
  };
  canvas.addEventListener('keydown', (event) => {
    if (!keys[event.key]) return;
    event.preventDefault(); event.stopPropagation();
    keys[event.key]();
  });
  window.addEventListener('resize', ask);
  element.querySelector('.above')?.addEventListener('click', () => { yaw = 0; pitch = 1.57; ask(); });
  draw();
  return (frame) => { now = frame; ask(); };
}
