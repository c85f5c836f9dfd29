// One slider between held-out frame and rendering for all pictures; differences, budgets, order.
(() => {
  const get = (id) => document.getElementById(id);
  const slider = get('slider'), sections = [...document.querySelectorAll('.versus')];
  const chosen = (id) => get(id)?.querySelector('input:checked').value;

  const place = (share) => {
    slider.value = share;
    document.body.style.setProperty('--at', `${slider.value}%`);
  };
  slider.addEventListener('input', () => place(slider.value));
  for (const pair of document.querySelectorAll('.pair')) {
    const over = document.createElement('img'), line = document.createElement('div');
    over.loading = 'lazy';
    over.src = pair.closest('.versus').querySelector('.truth img').src;
    over.alt = '';
    over.className = 'over';
    line.className = 'line';
    pair.append(over, line);
    const follow = (event) => {
      const box = pair.getBoundingClientRect();
      place(100 * (event.clientX - box.left) / box.width);
    };
    pair.addEventListener('pointermove', follow);
    pair.addEventListener('pointerdown', follow);
  }

  const arrange = () => {
    const k = chosen('budget') ?? document.querySelector('.card')?.dataset.k;
    for (const card of document.querySelectorAll('.card')) card.hidden = card.dataset.k !== k;
    document.body.classList.toggle('different', chosen('view') === 'difference');
    const worst = chosen('order') === 'worst';
    const score = (section) => (worst ? JSON.parse(section.dataset.psnr)[k] : 0);
    sections.slice().sort((a, b) => score(a) - score(b)).forEach((at) => get('rows').append(at));
  };
  for (const id of ['budget', 'view', 'order']) {
    if (!get(id)) continue;
    get(id).hidden = false;
    get(id).addEventListener('change', arrange);
  }
  get('share').hidden = false;
  document.body.classList.add('scripted');
  place(50);
  arrange();
})();
