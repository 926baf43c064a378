"""What a node does at an instant: the names of the contact states, as compiled code numbers them."""

STICK, BACKWARD_SLIP, FORWARD_SLIP, OPEN = 0, 1, -1, 2
