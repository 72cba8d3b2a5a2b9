"""From derivations to source text: freeze, optimise, emit."""
