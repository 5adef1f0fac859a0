// Computes what the page shows, so that sliders never wait. The newest question wins: what is asked while an answer is
// being computed replaces what was asked before.

let core, facts;
let waiting = null;

onmessage = async ({ data }) => {
    if (data.module) {
        facts = data.facts;
        core = new Core(await WebAssembly.compile(data.module), facts);
        core.loadMap(data.map);
        postMessage({ ready: true });
        return;
    }
    const isIdle = waiting === null;
    waiting = data;
    if (isIdle) setTimeout(answer);
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
    const { condition, sent, surface } = waiting;
    const started = performance.now();
    const found = surface ? { surface: surfaceOf(surface, condition) } : answerTo(condition);
    const asked = waiting;
    postMessage({ ...found, condition, sent, computed_ms: performance.now() - started });
    // Messages that came meanwhile are delivered before this runs.
    setTimeout(() => {
        if (waiting === asked) waiting = null;
        else answer();
    });
}

function answerTo(condition) {
    const exact = core.envelope(condition);
    return {
        exact,
        section: core.section(condition, exact),
        manoeuvre: core.manoeuvre(condition),
        map: core.mapped(condition),
        network: emulated(condition),
        only_rudder: isOnlyRudder(condition),
    };
}

// The surrogates know failures of the rudder alone.
function isOnlyRudder({ limits, configuration }) {
    const usual = { ...facts.bounds, rudder: limits.rudder };
    const same = Object.keys(limits).every((name) => limits[name][0] === usual[name][0] && limits[name][1] === usual[name][1]);
    return same && Object.entries(facts.usual_configuration).every(([name, value]) => configuration[name] === value);
}

function emulated({ altitude_ft, gamma_deg, limits }) {
    const x = [altitude_ft, gamma_deg, ...limits.rudder];
    const [t_min_pct] = throttleNetwork.predict(x);
    const [v_min_kt, v_max_kt] = speedsNetwork.predict(x);
    if (t_min_pct > facts.full_throttle_pct || v_min_kt > v_max_kt) return { feasible: false };
    const [v_min_std_kt, v_max_std_kt] = speedsNetwork.std(x);
    return { feasible: true, v_min_kt, v_max_kt, v_min_std_kt, v_max_std_kt, in_domain: speedsNetwork.inRange(x) };
}
