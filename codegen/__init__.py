"""From derivations to source text: freeze, specialise, optimise, emit."""
