// The page: asks the worker, draws what it answers.

const facts = JSON.parse(document.getElementById("facts").textContent);
const element = (id) => document.getElementById(id);
const is = (number) => number !== null && number !== undefined;
function fixed(number, digits = 2) {
    if (!is(number)) return "\u2013";
    const text = number.toFixed(digits);
    return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "\u2212");
}
const theme = () => getComputedStyle(document.documentElement);

// What gzip and base64 packed.
async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
}

const worker = new Worker(URL.createObjectURL(new Blob([element("worker").textContent], { type: "text/javascript" })));
let isReady = false;
let controls;
let latest = null;
let shown = null;
let resting = null;
const REST_MS = 300;

worker.onmessage = ({ data }) => {
    if (data.ready) {
        isReady = true;
        ask();
    } else if (data.surface) drawSurface(data);
    else if (data.steps) showRested(data);
    else show(data);
};
worker.onerror = ({ message }) => {
    element("summary").textContent = `This page cannot compute: ${message}.`;
};

function ask() {
    if (!isReady || !controls) return;
    worker.postMessage({ condition: controls.condition, sent: performance.now() });
}

async function start() {
    element("summary").textContent = "The core is being unpacked ...";
    controls = new Controls(facts, ask);
    const { map, ...rest } = facts;
    const module = await unpacked(element("core").textContent);
    const table = new Float32Array(await unpacked(map.table));
    worker.postMessage({ module, facts: rest, map: { ...map, table } }, [module]);
    for (const [button, kind] of [["over-limits", "limits"], ["over-condition", "condition"]])
        element(button).onclick = () => {
            element("surface-note").textContent = "Envelopes are being solved ...";
            worker.postMessage({ condition: controls.condition, surface: kind, sent: performance.now() });
        };
}

function show(answer) {
    latest = answer;
    const { exact, condition } = answer;
    element("summary").textContent = exact.feasible
        ? `Steady flight from ${fixed(exact.v_min_kt)} to ${fixed(exact.v_max_kt)} kn.`
        : is(exact.t_min_pct)
          ? `No steady flight: it would take ${fixed(exact.t_min_pct, 1)} % throttle.`
          : "No steady flight: no throttle would do.";
    element("summary").className = exact.feasible ? "" : "bad";
    showSpeeds(answer);
    drawPlane(answer);
    showManoeuvre(answer);
    clearTimeout(resting);
    resting = setTimeout(() => worker.postMessage({ condition: controls.condition, steps: true, sent: performance.now() }), REST_MS);
    requestAnimationFrame(() => {
        shown = performance.now() - answer.sent;
        element("latency").textContent = `Solved in ${fixed(answer.computed_ms, 0)} ms; on the screen ${fixed(shown, 0)} ms after the slider moved.`;
        document.body.dataset.latency = shown;
        document.body.dataset.answered = JSON.stringify(condition);
    });
}

function showSpeeds({ exact, map, network, failed }) {
    const row = (name, found, held) => {
        const interval = (speed, std) => (found.feasible ? fixed(speed) + (is(std) ? ` \u00b1 ${fixed(2 * std)}` : "") : "no envelope");
        return [name, interval(found.v_min_kt, found.v_min_std_kt), interval(found.v_max_kt, found.v_max_std_kt), held];
    };
    const words = (held) => held.map(limitWords).join(", ") || "no limit: the aircraft itself";
    const rows = [row("exact solution", exact, exact.feasible ? `${words(exact.held_at_v_min)}; ${words(exact.held_at_v_max)}` : "")];
    if (failed === "rudder") rows.push(row("thrust map", map, map.fold ? "a fold: solve exactly here" : ""), row("networks", network, network.in_domain === false ? "outside its data" : ""));
    element("speeds").tBodies[0].replaceChildren(...rows.map(tableRow));
    element("speeds-note").textContent = failed === "rudder"
        ? "\u00b1 are two standard deviations that the model itself gives."
        : "The thrust map and the networks know failures of the rudder alone.";
    element("shares").innerHTML = facts.shares[failed].replace(/V_(\w+)/g, "<i>V</i><sub>$1</sub>");
}

function showManoeuvre({ manoeuvre, condition }) {
    const { feasible, trim, limits } = manoeuvre;
    const asked = `${fixed(condition.tas_kt, 1)} kn, ${fixed(condition.turn_rate_deg_s, 1)} deg/s`;
    const beyond = (limits ?? []).filter(isBeyond).map(({ name }) => NAMES[name] ?? name);
    element("verdict").textContent = feasible
        ? `${asked}: can be flown. It is ${manoeuvre.stable ? "stable" : "unstable"} and ${manoeuvre.controllable ? "controllable" : "not controllable"}; ` +
          `nearest is the ${limitWords(manoeuvre.binding)}.`
        : trim
          ? `${asked}: cannot be flown. The nearest steady motion exceeds the limits of ${beyond.join(", ")}.`
          : `${asked}: the aircraft has no such steady motion.`;
    element("verdict").className = feasible ? "good" : "bad";
    element("margins").replaceChildren(...(limits ?? []).map(marginRow));
    element("aircraft").innerHTML = trim ? aircraftPicture(trim) : "";
}

const isBeyond = ({ margins }) => Math.min(...margins) < -1e-6;

// Where a value stands between its limits; a jam has no room to either side.
function marginRow(limit) {
    const { name, value, low, high, margins } = limit;
    const unit = name === "throttle" ? "%" : "\u00b0";
    const isJam = low === high;
    const row = document.createElement("div");
    row.className = `margin${isBeyond(limit) ? " beyond" : ""}`;
    const share = isJam ? 50 : Math.min(100, Math.max(0, (100 * (value - low)) / (high - low)));
    const room = isJam && !isBeyond(limit) ? "held" : `${fixed(Math.min(...margins), 1)} left`;
    row.innerHTML = `<span>${NAMES[name] ?? name}</span><span class="bar"><span class="at" style="left:${share}%"></span></span><span class="number">${fixed(value, 1)} ${unit}; ${room}</span>`;
    row.title = isJam ? `jammed at ${fixed(low, 1)} ${unit}` : `between ${fixed(low, 1)} and ${fixed(high, 1)} ${unit}`;
    return row;
}

function showRested({ exact, section, steps, condition }) {
    drawPlane({ exact, section, condition });
    const moves = ({ v_min_kt, v_max_kt }) => (is(v_min_kt) ? [signed(v_min_kt), signed(v_max_kt)] : ["no envelope left", ""]);
    element("steps").tBodies[0].replaceChildren(...steps.map((step) => tableRow([step.words, ...moves(step)])));
    document.body.dataset.steps = JSON.stringify(condition);
}

const signed = (number) => (Math.abs(number) < 0.005 ? "0" : (number > 0 ? "+" : "") + fixed(number));

function tableRow(cells) {
    const row = document.createElement("tr");
    row.append(...cells.map((text, place) => Object.assign(document.createElement(place ? "td" : "th"), { textContent: text, ...(place ? {} : { scope: "row" }) })));
    return row;
}

const NAMES = { alpha: "angle of attack", phi: "bank", psi_dot: "turn rate", beta: "sideslip", V: "speed" };
function limitWords(name) {
    const [what, end] = name.split(".");
    return `${NAMES[what] ?? what}, ${end} limit`;
}

// Polygons around the manoeuvres: rows of the same number of intervals follow each other; where gaps begin, new ones do.
function rings(section) {
    const groups = [];
    for (const row of section) {
        const last = groups.at(-1);
        if (last && last[0].intervals.length === row.intervals.length) last.push(row);
        else groups.push([row]);
    }
    return groups.flatMap((group) =>
        group[0].intervals.map((_, i) => {
            const side = (end) => group.map((row) => ({ tas_kt: row.tas_kt, ...row.intervals[i][end] }));
            const ring = [...side("low"), ...side("high").reverse()];
            return [...ring, ring[0]];
        }),
    );
}

// The boundary in the colours of its limits: a trace for each, broken where it does not hold.
function boundary(section) {
    const traces = new Map();
    const edges = rings(section).flatMap((ring) => ring.slice(1).map((next, k) => [ring[k], next]));
    for (const [here, next] of edges) {
        const common = here.held.filter((name) => next.held.includes(name));
        const what = (common[0] ?? here.held[0] ?? next.held[0] ?? "none").split(".")[0];
        const trace = traces.get(what) ?? { x: [], y: [] };
        trace.x.push(here.turn_rate_deg_s, next.turn_rate_deg_s, null);
        trace.y.push(here.tas_kt, next.tas_kt, null);
        traces.set(what, trace);
    }
    return [...traces].map(([what, trace]) => ({
        ...trace, mode: "lines", name: what === "none" ? "no limit" : NAMES[what] ?? what, hovertemplate: "%{y:.2f} kn, %{x:.2f} deg/s",
        line: { width: 4, color: what === "rudder" ? ink() : facts.colours[what] ?? "#777777" },
    }));
}

const ink = () => theme().getPropertyValue("--ink").trim();

function layout(more) {
    const line = theme().getPropertyValue("--line").trim();
    const axis = { gridcolor: line, zerolinecolor: line, automargin: true };
    return {
        paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: ink() }, margin: { l: 10, r: 10, t: 10, b: 10 },
        legend: { orientation: "h", y: 1.02, yanchor: "bottom" }, ...more,
        xaxis: { ...axis, ...more.xaxis }, yaxis: { ...axis, ...more.yaxis },
    };
}

const LOOK = { responsive: true, displaylogo: false, displayModeBar: false };

function drawPlane({ exact, section, condition }) {
    const area = rings(section).map((ring) => ({
        x: ring.map((at) => at.turn_rate_deg_s), y: ring.map((at) => at.tas_kt),
        fill: "toself", fillcolor: "rgba(116,185,232,.25)", mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false,
    }));
    const point = { x: [condition.turn_rate_deg_s], y: [condition.tas_kt], mode: "markers", marker: { size: 13, symbol: "cross", color: "#d55e00", line: { color: ink(), width: 1 } }, name: "chosen manoeuvre", hoverinfo: "skip" };
    const more = { xaxis: { title: { text: "turn rate, deg/s" } }, yaxis: { title: { text: "true airspeed, kn" } } };
    if (!exact.feasible) more.annotations = [{ text: "no steady manoeuvre is left", x: 0.5, y: 0.5, xref: "paper", yref: "paper", showarrow: false }];
    Plotly.react("plane", [...area, ...boundary(section), point], layout(more), LOOK);
    element("plane").setAttribute("aria-label", `Envelope in the plane of turn rate and speed. ${element("summary").textContent}`);
    element("plane").onclick = choose;
}

// A click chooses a manoeuvre.
function choose(event) {
    const { xaxis, yaxis } = element("plane")._fullLayout;
    const box = element("plane").getBoundingClientRect();
    const [x, y] = [xaxis.p2d(event.clientX - box.left - xaxis._offset), yaxis.p2d(event.clientY - box.top - yaxis._offset)];
    controls.change("turn_rate_deg_s", Math.round(x * 10) / 10);
    controls.change("tas_kt", Math.round(y * 2) / 2);
}

function drawSurface({ surface, computed_ms }) {
    const axes = surface.kind === "condition" ? ["flight-path angle, deg", "altitude, ft"] : ["rudder, lower limit, deg", "rudder, upper limit, deg"];
    const scene = {
        camera: { eye: { x: -1.5, y: -1.5, z: 0.9 } }, xaxis: { title: { text: axes[0] } }, yaxis: { title: { text: axes[1] } }, zaxis: { title: { text: "V_max, kn" } } };
    const { x, y, z } = surface;
    Plotly.react("surface", [{ type: "surface", x, y, z, colorscale: "Cividis", showscale: false }], layout({ scene }), LOOK);
    element("surface-note").textContent = `${x.length} by ${y.length} points, exact, in ${fixed(computed_ms / 1000, 1)} s.` + (surface.kind === "limits" ? " A range's envelope is taken as the union of its jams' every 2 deg." : "");
}

start();
