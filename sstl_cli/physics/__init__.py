"""Physics of tendon-sheath transmission: the fast model, its effects, and the rig that stands in for hardware."""
