#pragma once

#include <string_view>

/// \file
/// The parts of the report that do not depend on what was measured: its style and its script.

namespace gmis::tools::page {

inline constexpr std::string_view style = R"css(
:root { color-scheme: light dark; --paper: #fbfaf8; --card: #fff; --ink: #1c1b1a; --soft: #67625c; --rule: #e4e0da; --axis: #67625c;
  --accent: #8a3b12; --series-1: #c2410c; --series-2: #0e7490; --series-3: #6d28d9; --series-4: #4d7c0f; --series-5: #be185d;
  --series-6: #a16207; --series-7: #475569; --series-8: #0369a1; }
@media (prefers-color-scheme: dark) { :root { --paper: #151413; --card: #1e1c1b; --ink: #ece8e3; --soft: #a39c94;
  --rule: #35312e; --axis: #a39c94; --accent: #f0a070; --series-1: #fb923c; --series-2: #22d3ee; --series-3: #a78bfa;
  --series-4: #a3e635; --series-5: #f472b6; --series-6: #facc15; --series-7: #94a3b8; --series-8: #38bdf8; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
main { max-width: 70rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .4rem; letter-spacing: -.01em; }
h2 { font-size: 1.3rem; margin: 0 0 .2rem; }
p { margin: .4rem 0; max-width: 46rem; }
.soft { color: var(--soft); font-size: .9rem; }
.warn { border-left: 3px solid var(--accent); padding: .3rem .8rem; }
nav { display: flex; flex-wrap: wrap; gap: .4rem; margin: 1.2rem 0 0; }
nav a { padding: .2rem .7rem; border: 1px solid var(--rule); border-radius: 1rem; color: inherit; text-decoration: none; }
nav a:hover { border-color: var(--accent); color: var(--accent); }
section { background: var(--card); border: 1px solid var(--rule); border-radius: .8rem; padding: 1.4rem; margin: 1.6rem 0; }
.table { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { padding: .4rem .5rem; text-align: right; border-bottom: 1px solid var(--rule); white-space: nowrap; vertical-align: top; }
th { font-weight: 600; color: var(--soft); white-space: normal; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: var(--card); }
td small { display: block; color: var(--soft); }
td.miss { color: var(--soft); }
i.key { display: inline-block; width: .8em; height: .8em; border-radius: 50%; margin-right: .45em; }
.plot svg { display: block; width: 100%; height: auto; max-width: 38rem; margin: 0 auto; }
.plot text { font-family: system-ui, sans-serif; fill: var(--axis); }
.bar { display: flex; flex-wrap: wrap; gap: .5rem 1rem; align-items: center; margin: 1rem 0 .6rem; font-size: .92rem; }
select, button { font: inherit; color: inherit; background: var(--paper); border: 1px solid var(--rule); border-radius: .4rem;
  padding: .25rem .6rem; }
button[aria-pressed=true] { border-color: var(--accent); color: var(--accent); }
.viewer { position: relative; width: 100%; max-width: 40rem; margin: 0 auto; overflow: hidden; border-radius: .4rem;
  background: #000; touch-action: pan-y; user-select: none; cursor: crosshair; }
.viewer canvas { position: absolute; inset: 0; width: 100%; height: 100%; image-rendering: pixelated; transform-origin: 0 0;
  pointer-events: none; }
.exposure { display: flex; flex-wrap: wrap; gap: .3rem .8rem; align-items: center; max-width: 40rem; margin: .4rem auto 0; font-size: .88rem; }
.exposure input[type=range] { flex: 1 1 10rem; width: auto; margin: 0; }
.exposure output { font-variant-numeric: tabular-nums; min-width: 13rem; color: var(--soft); }
.loupe { display: flex; gap: .8rem; align-items: flex-start; max-width: 40rem; margin: .5rem auto 0; min-height: 5.2rem; }
.loupe canvas { width: 5rem; height: 5rem; flex: none; image-rendering: pixelated; border-radius: .3rem; background: #000; }
.loupe pre { margin: 0; font-size: .8rem; line-height: 1.35; overflow-x: auto; }
caption { text-align: left; color: var(--soft); font-size: .9rem; padding-bottom: .3rem; }
.runs { margin-top: 1rem; font-size: .9rem; } .runs ul { margin: .4rem 0 0; padding-left: 1.1rem; }
.runs code { display: block; font-size: .8rem; color: var(--soft); overflow-x: auto; white-space: pre; } a { color: var(--accent); }
.viewer .line { position: absolute; top: 0; bottom: 0; width: 2px; margin-left: -1px; background: #fff; box-shadow: 0 0 4px #000;
  pointer-events: none; }
.viewer .line::after { content: "\2194"; position: absolute; top: 50%; left: 50%; translate: -50% -50%; width: 1.7rem; height: 1.7rem;
  border-radius: 50%; background: #fff; color: #222; text-align: center; line-height: 1.7rem; box-shadow: 0 0 4px #000; }
.viewer b { position: absolute; top: .5rem; padding: .05rem .5rem; border-radius: .3rem; background: #000a; color: #fff;
  font-weight: 500; font-size: .85rem; pointer-events: none; }
.viewer b.l { left: .5rem; } .viewer b.r { right: .5rem; }
input[type=range] { width: 100%; max-width: 40rem; display: block; margin: .5rem auto 0; accent-color: var(--accent); }
.scale { max-width: 40rem; margin: .4rem auto 0; font-size: .82rem; color: var(--soft); display: flex; gap: .6rem; align-items: center; }
.scale span:nth-child(2) { flex: 1; height: .6rem; border-radius: .3rem; background: linear-gradient(90deg, rgb(0 0 4), rgb(51 10 95),
  rgb(121 28 109), rgb(187 55 84), rgb(237 105 37), rgb(252 181 25), rgb(252 255 164)); }
[hidden] { display: none !important; }
dl { margin: 0; } dt { font-weight: 600; margin-top: .7rem; } dd { margin: 0; color: var(--soft); max-width: 46rem; }
@media (max-width: 44rem) {
  table, tbody, caption, tr, td:first-child { display: block; } thead { display: none; }
  tr { border-bottom: 1px solid var(--rule); padding: .5rem 0; }
  td { display: flex; justify-content: space-between; gap: 1rem; border: 0; padding: .1rem 0; white-space: normal; }
  td::before { content: attr(data-name); color: var(--soft); text-align: left; }
  td:first-child { font-weight: 600; position: static; } td:first-child::before { content: none; } }
@media (max-width: 40rem) { main { padding: 1.4rem .8rem 3rem; } section { padding: 1rem .8rem; } body { font-size: 15px; } }
@media print { .bar, .viewer, input, .scale, .exposure, .loupe { display: none; } }
)css";

inline constexpr std::string_view script = R"js(
for (const box of document.querySelectorAll('[data-viewer]')) {
  const data = JSON.parse(box.querySelector('script').textContent);
  const $ = name => box.querySelector('[data-' + name + ']');
  const view = $('view'), line = $('line'), slider = $('slider'), back = $('back'), front = $('front');
  const state = { place: 50, zoom: 1, x: 0, y: 0, show: 'picture', stops: 0 };
  const { width, height } = data;
  for (const canvas of [back, front]) { canvas.width = width; canvas.height = height; }
  const of = side => data.images[$(side).value];
  // Linear values, decoded when first shown.
  const pixels = entry => {
    if (entry.linear) return entry.linear;
    const bytes = Uint8Array.from(atob(entry.pixels), c => c.charCodeAt(0));
    const linear = entry.linear = new Float32Array(3 * width * height);
    for (let i = 0; i < width * height; ++i) {
      const scale = 2 ** (bytes[4 * i + 3] - 136);
      for (let c = 0; c < 3; ++c) linear[3 * i + c] = bytes[4 * i + c] * scale;
    }
    return linear;
  };
  const map = entry => {
    const text = entry.maps && entry.maps[state.show];
    if (!text) return null;
    entry.loaded ??= {};
    if (!entry.loaded[state.show]) {
      const image = entry.loaded[state.show] = new Image();
      image.onload = paint;
      image.src = 'data:image/png;base64,' + text;
    }
    return entry.loaded[state.show];
  };
  const isMap = () => state.show !== 'picture' && state.show !== 'difference';
  const factor = () => data.exposure * 2 ** state.stops;
  const srgb = x => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
  const valueAt = (side, i) => {
    const own = pixels(of(side))[i];
    return state.show === 'difference' ? Math.abs(own - pixels(of(side === 'left' ? 'right' : 'left'))[i]) : own;
  };
  const shownAt = (side, i) => srgb(Math.min(1, Math.max(0, valueAt(side, i) * factor())));
  const paintSide = (canvas, side) => {
    const context = canvas.getContext('2d'), entry = of(side);
    const image = isMap() ? map(entry) : null;
    if (image) {
      if (image.complete) context.drawImage(image, 0, 0);
      return;
    }
    const shown = context.createImageData(width, height);
    for (let i = 0; i < width * height; ++i) {
      for (let c = 0; c < 3; ++c) shown.data[4 * i + c] = shownAt(side, 3 * i + c);
      shown.data[4 * i + 3] = 255;
    }
    context.putImageData(shown, 0, 0);
  };
  const paint = () => { paintSide(front, 'left'); paintSide(back, 'right'); };
  const draw = () => {
    const size = view.getBoundingClientRect();
    state.x = Math.min(0, Math.max(state.x, size.width * (1 - state.zoom)));
    state.y = Math.min(0, Math.max(state.y, size.height * (1 - state.zoom)));
    for (const canvas of [back, front])
      canvas.style.transform = `translate(${state.x}px, ${state.y}px) scale(${state.zoom})`;
    // The clip moves with the canvas: it is given in the canvas's own coordinates.
    const cut = (size.width * state.place / 100 - state.x) / state.zoom;
    front.style.clipPath = `inset(0 ${Math.max(0, size.width - cut)}px 0 0)`;
    line.style.left = state.place + '%';
    slider.value = state.place;
    $('zoom').textContent = state.zoom === 1 ? '1×' : state.zoom.toFixed(1).replace('.0', '') + '×';
  };
  const load = () => {
    state.show = $('show').value;
    $('leftname').textContent = of('left').name;
    $('rightname').textContent = of('right').name;
    $('scale').hidden = !isMap();
    $('exposures').hidden = isMap();
    const sign = state.stops < 0 ? '−' : '+';
    $('factor').textContent = `× ${factor().toPrecision(3)} (${sign}${Math.abs(state.stops)} stops)`;
    paint();
    draw();
  };
  const digits = x => x === 0 ? '0' : x >= 0.001 && x < 10000 ? x.toPrecision(3) : x.toExponential(2);
  const look = event => {
    const size = view.getBoundingClientRect();
    const x = Math.floor((event.clientX - size.left - state.x) / state.zoom / size.width * width);
    const y = Math.floor((event.clientY - size.top - state.y) / state.zoom / size.height * height);
    const inside = x >= 0 && y >= 0 && x < width && y < height;
    $('loupe').hidden = !inside;
    if (!inside) return;
    for (const side of ['left', 'right']) {
      const context = $(side + 'loupe').getContext('2d'), part = context.createImageData(9, 9);
      for (let j = 0; j < 81; ++j) {
        const px = Math.min(width - 1, Math.max(0, x - 4 + j % 9)), py = Math.min(height - 1, Math.max(0, y - 4 + Math.floor(j / 9)));
        for (let c = 0; c < 3; ++c) part.data[4 * j + c] = shownAt(side, 3 * (py * width + px) + c);
        part.data[4 * j + 3] = 255;
      }
      context.putImageData(part, 0, 0);
    }
    const row = entry => {
      const values = [0, 1, 2].map(c => digits(pixels(entry)[3 * (y * width + x) + c]).padStart(9)).join('');
      return entry.name.padEnd(14) + values;
    };
    const named = [of('left'), of('right')], truth = data.images.find(entry => entry.name === 'reference');
    if (truth && !named.includes(truth)) named.push(truth);
    $('values').textContent = [`pixel ${x}, ${y}`.padEnd(14) + '      red    green     blue', ...named.map(row)].join('\n');
  };
  const zoomAt = (factor, x, y) => {
    const zoom = Math.min(16, Math.max(1, state.zoom * factor));
    state.x = x - (x - state.x) * zoom / state.zoom;
    state.y = y - (y - state.y) * zoom / state.zoom;
    state.zoom = zoom;
    draw();
  };
  const centre = (factor) => { const s = view.getBoundingClientRect(); zoomAt(factor, s.width / 2, s.height / 2); };
  const flip = () => {
    const left = $('left').value;
    $('left').value = $('right').value;
    $('right').value = left;
    load();
  };
  $('in').onclick = () => centre(2);
  $('out').onclick = () => centre(0.5);
  $('flip').onclick = flip;
  $('left').onchange = $('right').onchange = $('show').onchange = load;
  $('stops').oninput = () => { state.stops = +$('stops').value; load(); };
  slider.oninput = () => { state.place = +slider.value; draw(); };
  view.onkeydown = event => {
    const show = $('show'), key = event.key.toLowerCase();
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (key === 'f') flip();
    else if (key === 'd') { show.value = show.value === 'difference' ? 'picture' : 'difference'; load(); }
    else if (key === 'e') { show.selectedIndex = (show.selectedIndex + 1) % show.options.length; load(); }
    else return;
    event.preventDefault();
  };
  view.addEventListener('wheel', event => {
    if (!event.ctrlKey && state.zoom === 1 && event.deltaY > 0) return;
    event.preventDefault();
    const size = view.getBoundingClientRect();
    zoomAt(Math.exp(-event.deltaY / 300), event.clientX - size.left, event.clientY - size.top);
  }, { passive: false });
  let grip = null;
  view.onpointerdown = event => {
    view.focus({ preventScroll: true });
    const size = view.getBoundingClientRect(), at = 100 * (event.clientX - size.left) / size.width;
    const onLine = Math.abs(at - state.place) < 6;
    grip = { line: state.zoom === 1 || onLine, x: event.clientX, y: event.clientY };
    if (grip.line) { state.place = at; draw(); }
    view.setPointerCapture(event.pointerId);
    look(event);
  };
  view.onpointermove = event => {
    look(event);
    if (!grip) return;
    const size = view.getBoundingClientRect();
    if (grip.line) state.place = Math.min(100, Math.max(0, 100 * (event.clientX - size.left) / size.width));
    else { state.x += event.clientX - grip.x; state.y += event.clientY - grip.y; }
    grip.x = event.clientX; grip.y = event.clientY;
    draw();
  };
  view.onpointerup = view.onpointercancel = () => { grip = null; };
  addEventListener('resize', draw);
  load();
}
)js";

}  // namespace gmis::tools::page
