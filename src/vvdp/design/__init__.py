"""Designing a rotary valve: optima, trade-offs, tolerances, oil temperature."""
