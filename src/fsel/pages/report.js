// Frames that are looked at, kept and dropped; the command and the lists that follow.
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const get = (id) => document.getElementById(id);
  const frames = [...document.querySelectorAll('.frame')];
  const marks = data.marks.slice(), lanes = get('timeline');
  let now = -1, saved = true;

  const listed = (mark) => data.names.filter((name, at) => marks[at] === mark);
  const link = (id, file, names) => {
    const anchor = get(id);
    anchor.textContent = `${file} (${names.length})`;
    anchor.removeAttribute('href');
    if (!names.length) return;
    anchor.href = `data:text/plain;charset=utf-8,${encodeURIComponent(`${names.join('\n')}\n`)}`;
    anchor.download = file;
  };
  const update = () => {
    const keep = listed('keep'), drop = listed('drop');
    frames.forEach((frame, at) => {
      frame.classList.toggle('keep', marks[at] === 'keep');
      frame.classList.toggle('drop', marks[at] === 'drop');
    });
    link('keep-file', 'keep.txt', keep);
    link('drop-file', 'drop.txt', drop);
    get('command').textContent = (keep.length ? data.keeping : data.asked)
      + (keep.length ? ' --always keep.txt' : '') + (drop.length ? ' --never drop.txt' : '');
    get('too-many').hidden = keep.length <= data.k;
  };
  const mark = (word) => {
    if (now < 0 || (word && data.kinds[now] === 'held')) return;
    marks[now] = marks[now] === word ? null : word;
    saved = false;
    update();
    buttons();
  };
  const buttons = () => {
    const fixed = data.kinds[now] === 'held';
    for (const word of ['keep', 'drop']) {
      get(word).disabled = now < 0 || fixed;
      get(word).setAttribute('aria-pressed', String(marks[now] === word));
    }
  };
  const show = (frame) => {
    frames[now]?.classList.remove('now');
    now = frame;
    frames[now].classList.add('now');
    const picture = frames[now].querySelector('img');
    get('picture').hidden = !picture;
    if (picture) get('picture').src = picture.src;
    get('name').textContent = data.names[now];
    get('why').textContent = data.texts[now];
    get('faults').textContent = data.faults[now];
    get('now').setAttribute('d', `M${(now + 0.5) / frames.length * lanes.viewBox.baseVal.width} 0V999`);
    get('detail').classList.add('open');
    ring(now);
    buttons();
  };
  const ring = (window.mountView ?? mountScene)(get('world'), data, show);

  frames.forEach((frame, at) => frame.addEventListener('click', () => show(at)));
  const step = (by) => {
    for (let at = now + by; at >= 0 && at < frames.length; at += by) {
      if (frames[at].hidden) continue;
      show(at);
      frames[at].scrollIntoView({ block: 'nearest' });
      return;
    }
  };
  const keys = {
    ArrowRight: () => step(1), ArrowLeft: () => step(-1), k: () => mark('keep'), d: () => mark('drop'),
    Escape: () => get('detail').classList.remove('open'),
  };
  document.addEventListener('keydown', (event) => {
    const field = /^(INPUT|TEXTAREA)$/.test(event.target.tagName);
    if (field || event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  for (const word of ['keep', 'drop']) get(word).addEventListener('click', () => mark(word));
  get('keep-picks').addEventListener('click', () => {
    data.kinds.forEach((kind, at) => { if (kind === 'pick' && !marks[at]) marks[at] = 'keep'; });
    saved = false;
    update();
    buttons();
  });
  get('clear').addEventListener('click', () => { marks.fill(null); update(); buttons(); });
  for (const id of ['keep-file', 'drop-file']) get(id).addEventListener('click', () => { saved = true; });
  window.addEventListener('beforeunload', (event) => { if (!saved) event.preventDefault(); });

  lanes.addEventListener('click', (event) => {
    const box = lanes.getBoundingClientRect();
    show(Math.min(frames.length - 1, Math.floor((event.clientX - box.left) / box.width * frames.length)));
  });
  const filter = get('filter');
  filter.hidden = false;
  filter.addEventListener('change', () => {
    const wanted = filter.querySelector('input:checked').value;
    frames.forEach((frame) => {
      frame.hidden = wanted !== 'all' && !frame.classList.contains(wanted);
    });
  });
  get('wishes').hidden = false;
  update();
})();
