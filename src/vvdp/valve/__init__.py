"""The self-spinning rotary valve that connects a pump in turn to the load and to the tank."""
