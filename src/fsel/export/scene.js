// Cameras, picks, targets and points, turned and zoomed with finger, mouse or keys; no library.
(() => {
  const canvas = document.getElementById('scene');
  const data = JSON.parse(document.getElementById('scene-data').textContent);
  const pen = canvas.getContext('2d');
  if (!pen) return;
  canvas.hidden = false;
  let yaw = 0.7, pitch = 0.6, zoom = 1, panX = 0, panY = 0, due = false;

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

  const camera = (place, tip, colour, size) => {
    const [x, y] = project(place), [u, v] = project(tip);
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = size / 3;
    pen.beginPath(); pen.moveTo(x, y); pen.lineTo(u, v); pen.stroke();
    pen.beginPath(); pen.arc(x, y, size, 0, 7); pen.fill();
    return [x, y];
  };

  const draw = () => {
    due = false;
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    const dot = 2 * ratio;
    const seen = data.points.map((p) => [project(p), p]).sort((a, b) => b[0][2] - a[0][2]);
    for (const [[x, y], p] of seen) {
      pen.fillStyle = `rgb(${p[3]},${p[4]},${p[5]})`;
      pen.fillRect(x, y, dot, dot);
    }
    for (const [place, tip] of data.frames) camera(place, tip, '#b5b5b5', 2 * ratio);
    for (const [place, tip] of data.targets) camera(place, tip, '#0072b2', 2.5 * ratio);
    pen.font = `600 ${9 * ratio}px system-ui, sans-serif`;
    pen.textAlign = 'center'; pen.textBaseline = 'middle';
    data.picks.slice().reverse().forEach(([place, tip], i) => {
      const [x, y] = camera(place, tip, '#d55e00', 7.5 * ratio);
      pen.fillStyle = '#fff';
      pen.fillText(String(data.picks.length - i), x, y);
    });
  };
  const ask = () => { if (!due) { due = true; requestAnimationFrame(draw); } };
  const turn = (dx, dy) => {
    yaw -= dx; pitch = Math.min(1.57, Math.max(-1.57, pitch + dy)); ask();
  };
  const scale = (factor) => { zoom = Math.min(40, Math.max(0.2, zoom * factor)); ask(); };

  const held = new Map();
  const spread = () => {
    const [a, b] = [...held.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = held.get(event.pointerId);
    if (!before) return;
    const apart = held.size === 2 ? spread() : 0;
    held.set(event.pointerId, [event.clientX, event.clientY]);
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    if (held.size === 2) scale(spread() / Math.max(apart, 1));
    else if (event.shiftKey) { panX += dx * devicePixelRatio; panY += dy * devicePixelRatio; ask(); }
    else turn(dx / 150, dy / 150);
  });
  for (const name of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(name, (event) => held.delete(event.pointerId));
  }
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
    event.preventDefault();
    keys[event.key]();
  });
  window.addEventListener('resize', ask);
  draw();
})();
