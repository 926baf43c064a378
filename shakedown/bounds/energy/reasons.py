"""Why there is no energy ball, or no end to it, in the words of an answer."""

NO_SAFE_SLIP = "no slip keeps every node within its friction limits at this load factor"
NOT_HELD = "no ball at this load factor reaches the state given"
NO_SLACK = "no slip leaves every node a margin to both its friction limits at this load factor"
ALL_ADMISSIBLE = "slip of one node shifts no limit of another: every admissible state shakes down"
WEDGED = "the centre may move away without end, and the radius grows with it: this is one ball of many"
TOO_FAR = "no safe slip is close enough to the initial slip"
UNLIMITED = "the ball about some safe slip holds the initial slip at every load factor"
