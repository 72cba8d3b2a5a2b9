"""A scene turned into a system: SI units, principal frames, instances, coordinates."""
