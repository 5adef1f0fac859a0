// Computes what the page shows, so that sliders never wait. Of each kind the newest question wins: what is asked while
// an answer is being computed replaces what was asked before.

let core, facts;
const KINDS = ["answer", "surface", "steps"]; // the most urgent first
const MOVING_SPEEDS = 25, RESTING_SPEEDS = 97; // at which the turn rates are solved as sliders move, and when they rest
const waiting = {};
let isBusy = false;

onmessage = async ({ data }) => {
    if (data.module) {
        facts = data.facts;
        core = new Core(await WebAssembly.compile(data.module), facts);
        core.loadMap(data.map);
        postMessage({ ready: true });
        return;
    }
    waiting[data.surface ? "surface" : data.steps ? "steps" : "answer"] = data;
    if (!isBusy) answer();
};

// Surfaces of V_max for jams, which need many envelopes: over the limits of the rudder (a range's envelope is the union of
// its jams', here of those every 2 deg), or over altitude and flight path.
function surfaceOf(kind, condition) {
    const highest = (changed) => {
        const found = core.end(core.ask({ ...condition, ...changed }), "V", -1);
        return found && core.value(found, "V");
    };
    if (kind === "condition") {
        const altitudes = steps(0, 30000, 13), paths = steps(-6, 6, 13);
        return {
            kind, x: paths, y: altitudes,
            z: altitudes.map((altitude_ft) => paths.map((gamma_deg) => highest({ altitude_ft, gamma_deg }))),
        };
    }
    const places = steps(...facts.bounds.rudder, 31);
    const jams = places.map((at) => highest({ limits: { ...condition.limits, rudder: [at, at] } }));
    const best = (from, to) => jams.slice(from, to + 1).reduce((most, each) => (each === null ? most : Math.max(most ?? each, each)), null);
    return { kind, x: places, y: places, z: places.map((_, upper) => places.map((_, lower) => (lower <= upper ? best(lower, upper) : null))) };
}

const steps = (from, to, n) => Array.from({ length: n }, (_, k) => from + ((to - from) * k) / (n - 1));

function answer() {
    const kind = KINDS.find((each) => waiting[each]);
    isBusy = kind !== undefined;
    if (!isBusy) return;
    const { condition, sent, surface } = waiting[kind];
    delete waiting[kind];
    const started = performance.now();
    const found = { surface: () => ({ surface: surfaceOf(surface, condition) }), steps: () => rested(condition), answer: () => answerTo(condition) }[kind]();
    postMessage({ ...found, condition, sent, computed_ms: performance.now() - started });
    setTimeout(answer); // messages that came meanwhile are delivered first
}

// What there is time for when the sliders rest.
function rested(condition) {
    const exact = core.envelope(condition);
    return { exact, section: core.section(condition, exact, RESTING_SPEEDS), steps: stepsFrom(condition, exact) };
}

// What a climb, a steeper path or the next degree lost of a control would do to V_min and V_max, by exact solutions.
function stepsFrom(condition, here) {
    if (!here.feasible) return [];
    const changed = [
        { words: "1000 ft higher", altitude_ft: Math.min(condition.altitude_ft + 1000, facts.highest_ft) },
        { words: "1 deg steeper up", gamma_deg: condition.gamma_deg + 1 },
        { words: "1 deg steeper down", gamma_deg: condition.gamma_deg - 1 },
    ];
    for (const name of facts.controls) {
        const [low, high] = condition.limits[name];
        if (high - low < 1) continue; // a jam has nothing to lose
        const loses = (limits) => ({ ...condition.limits, [name]: limits });
        changed.push({ words: `${name}: 1 ${facts.control_units[name]} lost at the top`, limits: loses([low, high - 1]) });
        changed.push({ words: `${name}: 1 ${facts.control_units[name]} lost at the bottom`, limits: loses([low + 1, high]) });
    }
    return changed
        .map(({ words, ...change }) => {
            const there = core.envelope({ ...condition, ...change });
            if (!there.feasible) return { words, v_min_kt: null, v_max_kt: null, cost: Infinity };
            const [v_min_kt, v_max_kt] = [there.v_min_kt - here.v_min_kt, there.v_max_kt - here.v_max_kt];
            return { words, v_min_kt, v_max_kt, cost: v_min_kt - v_max_kt };
        })
        .sort((one, other) => other.cost - one.cost);
}

function answerTo(condition) {
    const exact = core.envelope(condition);
    return {
        exact,
        section: core.section(condition, exact, MOVING_SPEEDS),
        manoeuvre: core.manoeuvre(condition),
        map: core.mapped(condition),
        network: emulated(condition),
        failed: failed(condition),
    };
}

// What may have failed: the rudder alone, which is all that the surrogates know, controls, or the airframe too.
function failed({ limits, configuration }) {
    if (!core.isWhole(configuration)) return "everything";
    const others = facts.controls.filter((name) => name !== "rudder");
    return others.every((name) => limits[name].every((bound, end) => bound === facts.bounds[name][end])) ? "rudder" : "controls";
}

function emulated({ altitude_ft, gamma_deg, limits }) {
    const x = [altitude_ft, gamma_deg, ...limits.rudder];
    const [t_min_pct] = throttleNetwork.predict(x);
    const [v_min_kt, v_max_kt] = speedsNetwork.predict(x);
    if (t_min_pct > facts.full_throttle_pct || v_min_kt > v_max_kt) return { feasible: false };
    const [v_min_std_kt, v_max_std_kt] = speedsNetwork.std(x);
    return { feasible: true, v_min_kt, v_max_kt, v_min_std_kt, v_max_std_kt, in_domain: speedsNetwork.inRange(x) };
}
