// A slider between a held-out frame and its rendering, and a choice of the number of frames.
(() => {
  for (const section of document.querySelectorAll('.versus')) {
    const truth = section.querySelector('.truth').src;
    for (const card of section.querySelectorAll('.card')) {
      const pair = card.querySelector('.pair'), slider = card.querySelector('input');
      const over = document.createElement('img'), line = document.createElement('div');
      over.src = truth; over.alt = ''; over.className = 'over'; line.className = 'line';
      pair.append(over, line);
      const show = () => {
        over.style.clipPath = `inset(0 ${100 - slider.value}% 0 0)`;
        line.style.left = `calc(${slider.value}% - 1px)`;
      };
      const follow = (event) => {
        const box = pair.getBoundingClientRect();
        slider.value = 100 * (event.clientX - box.left) / box.width;
        show();
      };
      pair.addEventListener('pointermove', follow);
      pair.addEventListener('pointerdown', follow);
      slider.addEventListener('input', show);
      slider.hidden = false;
      show();
    }
  }
  const budgets = document.getElementById('budgets');
  if (!budgets) return;
  const choose = () => {
    const k = budgets.querySelector('input:checked').value;
    for (const card of document.querySelectorAll('.card')) card.hidden = card.dataset.k !== k;
  };
  budgets.addEventListener('change', choose);
  budgets.hidden = false;
  choose();
})();
