// A line over the last seconds, on a canvas.
const PAST_S = 60, LEAST_S = 5;
const MOST_POINTS = 6000;
const LEFT = 58, BOTTOM = 16, TOP = 6;

export class Plot {
    constructor(parent, label, close) {
        this.points = [];
        this.box = document.createElement('div');
        this.box.className = 'plot';
        const head = document.createElement('div');
        const name = document.createElement('span');
        name.textContent = label;
        const button = document.createElement('button');
        button.textContent = 'close';
        button.setAttribute('aria-label', `close the plot of ${label}`);
        button.addEventListener('click', () => { this.box.remove(); close(); });
        head.append(name, button);
        this.canvas = document.createElement('canvas');
        this.canvas.setAttribute('role', 'img');
        this.canvas.setAttribute('aria-label', `plot of ${label}`);
        this.box.append(head, this.canvas);
        parent.append(this.box);
    }

    add(time, value) {
        const last = this.points.at(-1);
        if (last && time < last[0]) this.points = [];  // the slider went back
        if (!last || time > last[0]) this.points.push([time, value]);
        const from = time - PAST_S;
        if (this.points.length > MOST_POINTS || this.points[0]?.[0] < from) {
            this.points = this.points.filter(([at]) => at >= from).slice(-MOST_POINTS);
        }
    }

    draw() {
        const scale = window.devicePixelRatio || 1;
        const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
        this.canvas.width = width * scale;
        this.canvas.height = height * scale;
        const pen = this.canvas.getContext('2d');
        const style = getComputedStyle(document.documentElement);
        pen.scale(scale, scale);
        pen.font = '11px system-ui, sans-serif';
        const shown = this.points.filter(([, value]) => Number.isFinite(value));
        if (!shown.length) return;
        const end = this.points.at(-1)[0], begin = Math.max(end - PAST_S, Math.min(this.points[0][0], end - LEAST_S));
        let low = Infinity, high = -Infinity;
        for (const [, value] of shown) { low = Math.min(low, value); high = Math.max(high, value); }
        if (high - low < 1e-9) { low -= 0.5; high += 0.5; }
        const x = time => LEFT + (width - LEFT - 4) * (time - begin) / (end - begin);
        const y = value => TOP + (height - TOP - BOTTOM) * (high - value) / (high - low);
        pen.strokeStyle = style.getPropertyValue('--line');
        pen.fillStyle = style.getPropertyValue('--weak');
        for (let i = 0; i <= 4; ++i) {
            const value = low + (high - low) * i / 4;
            line(pen, [[LEFT, y(value)], [width - 4, y(value)]]);
            pen.fillText(value.toPrecision(4), 2, y(value) + 4);
        }
        for (let i = 0; i <= 6; ++i) pen.fillText(`${(begin + (end - begin) * i / 6).toFixed(0)} s`, x(begin + (end - begin) * i / 6) - (i === 6 ? 28 : 8), height - 3);
        pen.strokeStyle = style.getPropertyValue('--mark');
        pen.lineWidth = 1.4;
        let run = [];  // a value that is not a number leaves a gap
        for (const [time, value] of this.points) {
            if (Number.isFinite(value)) { run.push([x(time), y(value)]); continue; }
            line(pen, run);
            run = [];
        }
        line(pen, run);
    }
}

function line(pen, points) {
    pen.beginPath();
    points.forEach(([x, y], i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y));
    pen.stroke();
}
