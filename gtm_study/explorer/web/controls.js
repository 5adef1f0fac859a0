// The controls of the page: one slider with a number for each input of a condition, two for each limit. The condition is
// one flat object of numbers and names; what differs from the healthy aircraft stands in the address.

class Controls {
    constructor(facts, onChange) {
        this.facts = facts;
        this.onChange = onChange;
        this.inputs = {};
        this.usual = Object.fromEntries(facts.inputs.map(({ name, usual }) => [name, usual]));
        this.values = { ...this.usual };
        for (const input of facts.inputs) this.add(input);
        this.examples = document.getElementById("examples");
        this.examples.append(...facts.examples.map(({ label }, place) => new Option(label, place)));
        this.examples.onchange = () => this.set(facts.examples[this.examples.value].values);
        document.getElementById("reset").onclick = () => this.set({});
        addEventListener("hashchange", () => this.readAddress());
        this.readAddress();
    }

    add(input) {
        const { name, label, unit, least, greatest, step, options, group } = input;
        const row = document.createElement("div");
        row.className = "row";
        const text = document.createElement("label");
        text.htmlFor = name;
        text.textContent = unit ? `${label}, ${unit}` : label;
        row.append(text);
        const parts = [];
        if (options) {
            const select = document.createElement("select");
            select.id = name;
            select.append(...options.map(([value, words]) => new Option(words, value)));
            parts.push(select);
        } else {
            const slider = Object.assign(document.createElement("input"), { type: "range", id: name, min: least, max: greatest, step });
            const number = Object.assign(document.createElement("input"), { type: "number", min: least, max: greatest, step: "any" });
            number.setAttribute("aria-label", text.textContent);
            parts.push(slider, number);
        }
        for (const part of parts) {
            part.oninput = () => this.change(name, options ? part.value : Number(part.value), part);
            row.append(part);
        }
        this.inputs[name] = { ...input, parts };
        document.getElementById(group).append(row);
    }

    // Take a new value of one input; limits push each other along.
    change(name, value, from) {
        const { least, greatest, options, pushes } = this.inputs[name];
        if (!options && !(value >= least && value <= greatest)) {
            from.setCustomValidity(`Give a number from ${least} to ${greatest}.`);
            from.reportValidity();
            return;
        }
        if (from) from.setCustomValidity("");
        this.values[name] = value;
        if (pushes && (name.endsWith("lower") ? this.values[pushes] < value : this.values[pushes] > value)) this.values[pushes] = value;
        this.show(from);
        this.writeAddress();
        this.onChange();
    }

    // The healthy aircraft but for some values.
    set(values) {
        this.values = { ...this.usual, ...values };
        this.show();
        this.writeAddress();
        this.onChange();
    }

    show(from) {
        for (const [name, { parts }] of Object.entries(this.inputs))
            for (const part of parts) if (part !== from) part.value = this.values[name];
        const isShown = ({ values }) => Object.entries({ ...this.usual, ...values }).every(([name, value]) => this.values[name] === value);
        this.examples.selectedIndex = this.facts.examples.findIndex(isShown);
    }

    writeAddress() {
        const changed = Object.entries(this.values).filter(([name, value]) => value !== this.usual[name]);
        history.replaceState(null, "", changed.length ? `#${new URLSearchParams(changed)}` : location.pathname);
    }

    readAddress() {
        const given = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
        const values = {};
        for (const [name, { least, greatest, options }] of Object.entries(this.inputs)) {
            if (!(name in given)) continue;
            const known = options ? options.some(([value]) => value === given[name]) : Number(given[name]) >= least && Number(given[name]) <= greatest;
            if (known) values[name] = options ? given[name] : Number(given[name]);
        }
        this.values = { ...this.usual, ...values };
        for (const { pushes, name } of Object.values(this.inputs))
            if (pushes && name.endsWith("lower") && this.values[name] > this.values[pushes]) this.values[pushes] = this.values[name];
        this.show();
        this.onChange();
    }

    // As the worker is asked.
    get condition() {
        const v = this.values;
        const limits = Object.fromEntries(this.facts.controls.map((name) => [name, [v[`${name}.lower`], v[`${name}.upper`]]]));
        const configuration = Object.fromEntries(Object.keys(this.facts.usual_configuration).map((name) => [name, name === "damage_case" ? Number(v[name]) : v[name]]));
        return { altitude_ft: v.altitude_ft, gamma_deg: v.gamma_deg, tas_kt: v.tas_kt, turn_rate_deg_s: v.turn_rate_deg_s, limits, configuration };
    }
}
