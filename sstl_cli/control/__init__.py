"""References, the feedforward controller, plants to try it on, scores, and its export."""
