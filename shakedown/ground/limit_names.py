"""The names of the limits of the load factor: word in documents and options, symbol, name."""

SYMBOLS = {
    "lower": "λ_1",
    "universal": "λ_U",
    "energy": "λ_E",
    "box": "λ_box",
    "accumulated": "λ_S",
    "transient": "λ_T",
    "upper": "λ_max",
}
FROM_HERE = ("energy", "box", "accumulated")  # proved from one state, below any of them
NAMES = {
    "λ_1": "first collapse",
    "λ_U": "from every state",
    "λ_E": "from this state",
    "λ_box": "from this state, by a box",
    "λ_S": "from this state, by total slip",
    "λ_T": "simulated from this state",
    "λ_max": "impossible above",
}


def named(symbol: str) -> str:
    """A limit by its symbol and its name, as tables and pictures show it.

    Examples
    --------
    >>> named("λ_U")
    'λ_U, from every state'
    """
    return f"{symbol}, {NAMES[symbol]}"
