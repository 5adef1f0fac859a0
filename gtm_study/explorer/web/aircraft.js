// The aircraft from behind: its bank, and its surfaces as they are deflected (enlarged, so that a degree can be seen).

const ENLARGED = 0.9; // drawing units a degree

function aircraftPicture({ phi, alpha, beta, elevator, aileron, rudder, throttle }) {
    // Trailing edge down is positive.
    const surface = (x, y, width, deg) => {
        const down = ENLARGED * deg;
        return `<rect x="${x}" y="${Math.min(y, y + down)}" width="${width}" height="${Math.max(2, Math.abs(down))}" class="moved"/>`;
    };
    const fin = ENLARGED * rudder; // trailing edge left is positive
    const parts = [
        `<path d="M-150,-4 L-14,6 L14,6 L150,-4" class="body"/>`,
        `<path d="M-52,-14 L0,-18 L52,-14" class="body"/>`,
        `<path d="M0,-16 L0,-78" class="body"/>`,
        `<circle r="16" class="hull"/>`,
        ...[-55, 55].map((x) => `<circle cx="${x}" cy="14" r="8" class="hull"/>`),
        surface(-140, 0, 45, -aileron), // the right aileron down is positive
        surface(95, 0, 45, aileron),
        surface(-50, -14, 40, elevator),
        surface(10, -14, 40, elevator),
        `<rect x="${Math.min(0, -fin)}" y="-74" width="${Math.max(2, Math.abs(fin))}" height="50" class="moved"/>`,
    ];
    const words = `Aircraft from behind: bank ${fixed(phi, 1)} deg, elevator ${fixed(elevator, 1)} deg, aileron ${fixed(aileron, 1)} deg, rudder ${fixed(rudder, 1)} deg.`;
    return `<svg viewBox="-170 -120 340 220" role="img" aria-label="${words}">
<line x1="-165" x2="165" y1="0" y2="0" class="horizon"/>
<g transform="rotate(${phi})">${parts.join("")}</g>
<text x="-165" y="92">bank ${fixed(phi, 1)}\u00b0, \u03b1 ${fixed(alpha, 1)}\u00b0, \u03b2 ${fixed(beta, 1)}\u00b0, throttle ${fixed(throttle, 0)} %</text>
<text x="-165" y="-106">\u03b4e ${fixed(elevator, 1)}\u00b0, \u03b4a ${fixed(aileron, 1)}\u00b0, \u03b4r ${fixed(rudder, 1)}\u00b0</text></svg>`;
}
