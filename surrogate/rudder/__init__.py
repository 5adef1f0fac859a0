"""The emulators of a failed rudder: networks that come with the package, and surrogates by name."""
