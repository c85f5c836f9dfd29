// Frames that are looked at, kept and dropped; the command that follows.
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const get = (id) => document.getElementById(id);
  const frames = [...document.querySelectorAll('.frame')];
  const marks = data.marks.slice(), lanes = get('timeline');
  let now = -1;

  const listed = (mark) => data.names.filter((name, at) => marks[at] === mark);
  const quoted = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`);
  const update = () => {
    const keep = listed('keep'), drop = listed('drop');
    frames.forEach((frame, at) => {
      frame.classList.toggle('keep', marks[at] === 'keep');
      frame.classList.toggle('drop', marks[at] === 'drop');
    });
    const lost = marks.filter((mark, at) => mark === 'drop' && data.kinds[at] === 'pick').length;
    const k = Math.max(data.k, data.k - lost + keep.length);
    const words = [data.editing, '-k', k, '--always', quoted([data.list, ...keep].join(','))];
    if (drop.length) words.push('--never', quoted(drop.join(',')));
    const changed = keep.length + drop.length > 0;
    get('command').textContent = changed ? words.join(' ') : '';
    get('changes').hidden = !changed;
    get('copy').textContent = 'Copy';
    get('marked').textContent = changed ? `${keep.length} kept, ${drop.length} dropped by you:`
      : 'Keep or drop frames to get the command that changes the selection.';
  };
  const mark = (word) => {
    if (now < 0 || fixed(word)) return;
    marks[now] = marks[now] === word ? null : word;
    update();
    buttons();
  };
  const fixed = (word) => data.kinds[now] === 'held' || (word === 'keep' && data.kinds[now] === 'pick');
  const buttons = () => {
    for (const word of ['keep', 'drop']) {
      get(word).disabled = now < 0 || fixed(word);
      get(word).setAttribute('aria-pressed', String(marks[now] === word));
    }
    get('detail').dataset.mark = marks[now] ?? '';
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
  get('copy').addEventListener('click', () => {
    getSelection().selectAllChildren(get('command'));
    get('copy').textContent = document.execCommand('copy') ? 'Copied' : 'Press Ctrl-C';
  });
  get('clear').addEventListener('click', () => { marks.fill(null); update(); buttons(); });

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
