"""The path tracer: samples, film, denoisers."""
