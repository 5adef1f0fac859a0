// The compiled core as the page asks it. Units are the core's inside (ft/s, rad), the page's outside (kn, deg).
// `facts` are names, ranges and constants that the page brings along from Python.

class Core {
    constructor(module, facts) {
        this.facts = facts;
        this.core = new WebAssembly.Instance(module, {}).exports;
        this.core._initialize();
        this.at = Object.fromEntries(facts.unknowns.map((name, place) => [name, place]));
        this.perUnit = facts.unknowns.map((name) => facts.units_per_core_unit[name] ?? 1);
        const most = facts.unknowns.length + 1;
        for (const name of ["lower", "upper", "objective", "best"]) this[name] = this.numbers(most);
        this.violation = this.numbers(1);
        [this.place, this.answer] = [this.numbers(2), this.core.malloc(this.core.gtm_answer_size())];
        this.intervals = this.core.malloc(this.core.gtm_intervals_size());
        this.dead = this.numbers(most);
        this.casesAt = this.numbers(4);
        this.foundAt = this.numbers(6);
    }

    // An array of doubles in the memory of the core, at `address`.
    numbers(length, values) {
        const address = this.core.malloc(8 * length);
        if (values) new Float64Array(this.core.memory.buffer, address, length).set(values);
        return address;
    }

    view(address, length) {
        return new Float64Array(this.core.memory.buffer, address, length);
    }

    // Whether a configuration is the study's: nothing of the airframe has failed or moved.
    isWhole(configuration) {
        return Object.entries(this.facts.usual_configuration).every(([name, value]) => configuration[name] === value);
    }

    // What a condition means to the solver: a configuration (0: the study's), and the bounds of the unknowns.
    ask(condition) {
        const { configuration: given, limits } = condition;
        const running = { both: [1, 1], left_out: [0, 1], right_out: [1, 0], both_out: [0, 0] }[given.engines];
        const c = this.isWhole(given)
            ? 0
            : this.core.explorer_configuration(
                  given.damage_case, given.fuel_used_lb, given.stabilizer_deg, given.gear, given.flap_deg, given.spoiler_deg, ...running,
              );
        const ranges = { ...this.facts.bounds, ...limits };
        const lower = this.facts.unknowns.map((name, i) => ranges[name][0] / this.perUnit[i]);
        const upper = this.facts.unknowns.map((name, i) => ranges[name][1] / this.perUnit[i]);
        if (c) this.holdDead(c, lower, upper);
        return { c, altitude: condition.altitude_ft, gamma: condition.gamma_deg * this.facts.rad_per_deg, lower, upper };
    }

    // A control that moves nothing is held as near to zero as its limits let it.
    holdDead(c, lower, upper) {
        this.core.gtm_dead_controls(c, this.dead);
        const isDead = new Uint8Array(this.core.memory.buffer, this.dead, lower.length + 1);
        for (let i = 0; i < lower.length; i++) {
            const isThrottle = i === this.at.throttle;
            if (isDead[i] && (!isThrottle || isDead[i + 1])) lower[i] = upper[i] = Math.min(Math.max(0, lower[i]), upper[i]);
        }
    }

    setBounds({ lower, upper }) {
        this.view(this.lower, lower.length).set(lower);
        this.view(this.upper, upper.length).set(upper);
    }

    // The steady manoeuvre with the least of sign * unknown; null if none is inside the limits.
    end(asked, name, sign, changed = {}) {
        const n = this.facts.unknowns.length;
        this.setBounds(asked);
        for (const [other, [low, high]] of Object.entries(changed)) {
            this.view(this.lower, n)[this.at[other]] = low;
            this.view(this.upper, n)[this.at[other]] = high;
        }
        const objective = this.view(this.objective, n).fill(0);
        objective[this.at[name]] = sign;
        const status = this.core.gtm_envelope_end(
            asked.c, 1, asked.altitude, asked.gamma, this.lower, this.upper, this.objective, this.best, this.violation,
        );
        return status === 0 ? Array.from(this.view(this.best, n)) : null;
    }

    // An unknown's value in the units of the page.
    value(y, name) {
        return y[this.at[name]] * this.perUnit[this.at[name]];
    }

    trim(y) {
        return Object.fromEntries(this.facts.unknowns.map((name) => [name, this.value(y, name)]));
    }

    // Names of the limits that a point holds, as "rudder.upper"; a jam is none.
    limitsHit(y, { lower, upper }, tolerance = this.facts.held_tolerance) {
        const near = (i) => tolerance * this.facts.scale[i];
        return this.facts.unknowns.flatMap((name, i) => {
            if (lower[i] === upper[i]) return [];
            return [
                ...(y[i] <= lower[i] + near(i) ? [`${name}.lower`] : []),
                ...(y[i] >= upper[i] - near(i) ? [`${name}.upper`] : []),
            ];
        });
    }

    // V_min and V_max, exact.
    envelope(condition) {
        const asked = this.ask(condition);
        const low = this.end(asked, "V", 1);
        const high = low && this.end(asked, "V", -1);
        if (!high) {
            const spare = this.end(asked, "throttle", 1, { throttle: [asked.lower[this.at.throttle], this.facts.throttle_without_limit] });
            return { feasible: false, t_min_pct: spare && spare[this.at.throttle] };
        }
        return {
            feasible: true,
            v_min_kt: this.value(low, "V"),
            v_max_kt: this.value(high, "V"),
            at_v_min: this.trim(low),
            at_v_max: this.trim(high),
            held_at_v_min: this.limitsHit(low, asked),
            held_at_v_max: this.limitsHit(high, asked),
        };
    }

    // The turn rates that are left at speeds over the envelope: of each the intervals between gaps, exact, each end with
    // the limits that hold it.
    section(condition, envelope, speeds) {
        if (!envelope.feasible) return [];
        const asked = this.ask(condition);
        const n = this.facts.unknowns.length;
        const { count, end, y } = this.facts.intervals;
        const [psi, V] = [this.at.psi_dot, this.at.V];
        const rows = [];
        for (let k = 0; k < speeds; k++) {
            const share = 0.5 - 0.5 * Math.cos((Math.PI * k) / (speeds - 1));
            const tas_kt = envelope.v_min_kt + share * (envelope.v_max_kt - envelope.v_min_kt);
            this.setBounds(asked);
            this.view(this.lower, n)[V] = this.view(this.upper, n)[V] = tas_kt / this.perUnit[V];
            this.core.gtm_section(
                asked.c, 1, 0, asked.altitude, asked.gamma, this.lower, this.upper, asked.lower[psi], asked.upper[psi], this.intervals,
            );
            const found = new Int32Array(this.core.memory.buffer, this.intervals + count, 1)[0];
            const ends = this.view(this.intervals + end, 2 * found);
            const trims = this.view(this.intervals + y, 2 * found * (n + 1));
            const at = (place) => ({
                turn_rate_deg_s: ends[place] * this.perUnit[psi],
                held: this.limitsHit(trims.subarray(place * (n + 1), place * (n + 1) + n), asked, this.facts.section_tolerance),
            });
            const intervals = Array.from({ length: found }, (_, i) => ({ low: at(2 * i), high: at(2 * i + 1) }));
            if (found) rows.push({ tas_kt, intervals });
        }
        return rows;
    }

    // The chosen manoeuvre: feasible or not, its trim, how far every limit is, which one binds, stable, controllable.
    manoeuvre(condition) {
        const asked = this.ask(condition);
        const n = this.facts.unknowns.length;
        this.setBounds(asked);
        for (const [name, value] of [["V", condition.tas_kt], ["psi_dot", condition.turn_rate_deg_s]]) {
            const i = this.at[name];
            this.view(this.lower, n)[i] = this.view(this.upper, n)[i] = value / this.perUnit[i];
        }
        this.view(this.place, 2).set([asked.altitude, asked.gamma]);
        this.core.gtm_query(asked.c, 1, 1, this.place, this.place + 8, this.lower, this.upper, this.answer);
        const at = this.facts.answer;
        const integer = (name) => new Int32Array(this.core.memory.buffer, this.answer + at[name], 1)[0];
        if (integer("status") === 2) return { feasible: false };
        const y = Array.from(this.view(this.answer + at.y, n));
        const margins = this.view(this.answer + at.margin, 2 * n);
        const limits = this.facts.shown_margins.map((name) => {
            const i = this.at[name];
            const [low, high] = [asked.lower[i], asked.upper[i]].map((bound) => bound * this.perUnit[i]);
            return { name, value: this.value(y, name), low, high, margins: [margins[2 * i], margins[2 * i + 1]].map((each) => each * this.perUnit[i]) };
        });
        const binding = integer("binding");
        return {
            feasible: integer("status") === 0,
            stable: Boolean(integer("stable")),
            controllable: Boolean(integer("controllable")),
            binding: binding < 0 ? null : `${this.facts.unknowns[Math.min(binding, n - 1)]}.${["lower", "upper"][integer("side")]}`,
            trim: this.trim(y),
            limits,
            thrust_margins_lbf: Array.from(this.view(this.answer + at.thrust_margin, 2)),
        };
    }

    loadMap({ densities, paths, deflections, reach, table, constants }) {
        const floats = this.core.malloc(4 * table.length);
        new Float32Array(this.core.memory.buffer, floats, table.length).set(table);
        const speeds = table.length / (densities.length * paths.length * deflections.length) - 2;
        const arrays = [densities, paths, deflections, reach].map((array) => this.numbers(array.length, array));
        this.map = this.core.explorer_map(densities.length, paths.length, deflections.length, speeds, ...arrays, floats, ...constants);
    }

    // V_min and V_max by the thrust map of the rudder, with standard deviations.
    mapped({ altitude_ft, gamma_deg, limits }) {
        this.view(this.casesAt, 4).set([altitude_ft, gamma_deg, ...limits.rudder]);
        this.core.gtm_map_envelopes(this.map, 1, this.casesAt, this.foundAt);
        const [v_min_kt, v_max_kt, v_min_std_kt, v_max_std_kt, spare, fold] = this.view(this.foundAt, 6);
        return spare >= 0 ? { feasible: true, v_min_kt, v_max_kt, v_min_std_kt, v_max_std_kt, fold: fold > 0 } : { feasible: false };
    }
}
