"""What a node does at an instant: the names of the contact states, as compiled code numbers them."""

STICK, BACKWARD_SLIP, FORWARD_SLIP, OPEN = 0, 1, -1, 2
SLIP, NO_STATE = 1, 3  # in space a disc has no sides; a node for which no state satisfies the law
