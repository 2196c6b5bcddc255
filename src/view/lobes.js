// Lobes: R above and T below the layer in the plane of incidence, as polar curves of one scale.
const lobeAngles = 720;

/** Draws into both halves of a canvas; `curves` are [once, all], each of red, green and blue. */
function drawLobes(canvas, curves, elevation, isGrey) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const pen = canvas.getContext("2d");
  const half = canvas.width / 2, middle = { y: canvas.height / 2 }, radius = 0.4 * Math.min(half, canvas.height);
  const unit = canvas.width / canvas.clientWidth;
  const largest = Math.max(1e-12, ...curves.flat().map((curve) => Math.max(...curve)));
  const grid = roundBelow(largest);
  const scale = radius / Math.max(largest, grid);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.font = `${12 * unit}px system-ui, sans-serif`;
  curves.forEach((channels, panel) => {
    middle.x = half * (panel + 0.5);
    pen.lineWidth = unit;
    pen.strokeStyle = colour("--line");
    for (const value of [grid / 2, grid]) circle(pen, middle, value * scale);
    line(pen, middle.x - half * 0.46, middle.y, middle.x + half * 0.46, middle.y, colour("--soft"), 2 * unit);
    pen.fillStyle = colour("--soft");
    pen.fillText(formatted(grid), middle.x + 4 * unit, middle.y - grid * scale - 4 * unit);
    incidentRay(pen, middle, radius, elevation, colour("--once"), unit);
    channels.slice(0, isGrey ? 1 : 3).forEach((curve, channel) => {
      const own = isGrey ? colour(panel === 0 ? "--once" : "--accent") : ["#d1495b", "#3a9d5d", "#3d7dd8"][channel];
      lobe(pen, middle, scale, curve, own, isGrey, unit);
    });
  });
}

/** The largest of 1, 2, 5 times a power of ten that is not above a value. */
function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((digit) => digit * power <= value * (1 + 1e-9)) * power;
}

function circle(pen, middle, radius) {
  pen.beginPath();
  pen.arc(middle.x, middle.y, radius, 0, 2 * Math.PI);
  pen.stroke();
}

function line(pen, x0, y0, x1, y1, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

/** Light comes from the left. */
function incidentRay(pen, middle, radius, elevation, colour, unit) {
  const x = -Math.cos(elevation), y = -Math.sin(elevation), far = 1.1 * radius;
  pen.setLineDash([6 * unit, 5 * unit]);
  line(pen, middle.x + far * x, middle.y + far * y, middle.x, middle.y, colour, 1.5 * unit);
  pen.setLineDash([]);
  pen.fillStyle = colour;
  pen.beginPath();
  pen.arc(middle.x + far * x, middle.y + far * y, 5 * unit, 0, 2 * Math.PI);
  pen.fill();
}

function lobe(pen, middle, scale, curve, colour, isFilled, unit) {
  pen.beginPath();
  curve.forEach((value, k) => {
    const turn = 2 * Math.PI * (k + 0.5) / curve.length;
    pen.lineTo(middle.x + value * scale * Math.sin(turn), middle.y - value * scale * Math.cos(turn));
  });
  pen.closePath();
  pen.strokeStyle = colour;
  pen.lineWidth = 2 * unit;
  pen.stroke();
  if (!isFilled) return;
  pen.globalAlpha = 0.15;
  pen.fillStyle = colour;
  pen.fill();
  pen.globalAlpha = 1;
}
