"""The airframe of gtm/SPEC.md, a module a section, written once as CasADi expressions."""
