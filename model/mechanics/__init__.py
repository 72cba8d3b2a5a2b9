"""A system of bodies: its records, kinds of constraints, frames and measures."""
