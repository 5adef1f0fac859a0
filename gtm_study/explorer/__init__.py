"""The explorer: a page that computes envelopes in the browser, by the compiled core."""
