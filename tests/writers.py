"""Small writers of the stiffness formats, for round trips; the labels of the model are (node, direction)."""

import numpy as np

CORNERS_OF = {
    "triangle": [(0, 0), (1, 0), (0, 1)],
    "quadrilateral": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "tetrahedron": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
    "hexahedron": [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
}


def symmetric_matrix(n, seed=0):
    """A positive definite matrix without zeros."""
    root = np.random.default_rng(seed).standard_normal((n, n))
    return root @ root.T + n * np.eye(n)


def abaqus_matrix(K, dofs, triangle="lower"):
    pairs = {
        "lower": [(i, j) for j in range(len(K)) for i in range(j, len(K))],
        "upper": [(i, j) for j in range(len(K)) for i in range(j + 1)],
        "full": [(i, j) for i in range(len(K)) for j in range(len(K))],
    }[triangle]
    return "".join(
        f"{dofs[i][0]},{dofs[i][1]}, {dofs[j][0]},{dofs[j][1]}, {K[i, j]:.15e}\n" for i, j in pairs
    )


def abaqus_substructure(K, dofs, unsymmetric=False):
    """Nodes in order of first appearance, a new dof list wherever it changes."""
    nodes = list(dict.fromkeys(node for node, _ in dofs))
    lists = [[d for node, d in dofs if node == own] for own in nodes]
    lines = ["** GENERATION OF SUBSTRUCTURE Z1", f"*USER ELEMENT, NODES= {len(nodes)}, LINEAR"]
    lines[-1] += ", UNSYM" if unsymmetric else ""
    lines.append("** ELEMENT NODES")
    lines += ["** " + ", ".join(map(str, nodes[k : k + 10])) for k in range(0, len(nodes), 10)]
    lines.append(",".join(map(str, lists[0])))
    for k in range(1, len(nodes)):
        if lists[k] != lists[k - 1]:
            lines.append(",".join(map(str, [k + 1, *lists[k]])))
    lines.append("*MATRIX,TYPE=STIFFNESS")
    rows = [K[:, j] for j in range(len(K))] if unsymmetric else [K[j, : j + 1] for j in range(len(K))]
    for row in rows:
        text = [f"{value:.13E}".replace("0.", ".") if abs(value) < 1 else f"{value:.13E}" for value in row]
        lines += [", ".join(text[k : k + 4]) + "," * (k + 4 < len(text)) for k in range(0, len(text), 4)]
    return "\n".join([*lines, "*MATRIX,TYPE=MASS", "1.0", ""])


def calculix_storage(K, dofs):
    """(.sti, .dof): upper triangle sorted by column."""
    entries = [f"{i + 1} {j + 1} {K[i, j]:20.13e}\n" for j in range(len(K)) for i in range(j + 1)]
    return "".join(entries), "".join(f"{node}.{direction}\n" for node, direction in dofs)


def calculix_deck(nodes, elements, sets, kind, *, more=(), steps=None):
    """A deck of one material, by default of the run that stores the matrix; places (n, 3) of labels from 1."""
    lines = ["*NODE", *(f"{k}, {', '.join(map(repr, place))}" for k, place in enumerate(nodes, start=1))]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=ALL")
    lines += [", ".join(map(str, (k, *own))) for k, own in enumerate(elements, start=1)]
    for name, labels in sets.items():
        lines += [f"*NSET, NSET={name}", *(f"{label}," for label in labels)]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "210000., 0.3", "*DENSITY", "1."]
    lines += ["*SOLID SECTION, ELSET=ALL, MATERIAL=M", *more]
    stored = ["*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"]
    return "\n".join([*lines, *(stored if steps is None else steps)]) + "\n"


def matrix_market(K, symmetric=True, layout="coordinate"):
    n = len(K)
    kind = "symmetric" if symmetric else "general"
    pairs = [(i, j) for j in range(n) for i in range(j if symmetric else 0, n)]
    size = f"{n} {n} {len(pairs)}" if layout == "coordinate" else f"{n} {n}"
    lines = [f"%%MatrixMarket matrix {layout} real {kind}", "% a comment", size]
    keys = [f"{i + 1} {j + 1} " if layout == "coordinate" else "" for i, j in pairs]
    return "\n".join([*lines, *(f"{key}{K[pair]:.17g}" for key, pair in zip(keys, pairs, strict=True)), ""])


def dof_map(dofs):
    return "# node direction\n" + "".join(f"{node} {direction}\n" for node, direction in dofs)


def _fixed(fields, width):
    return "".join(str(field).ljust(width)[:width] for field in fields)


def nastran_dmig(K, dofs, name="KAAX", style="large", form=6):
    """One symmetric matrix, lower triangle by columns."""
    lines = ["$ a punch file", "DMIG    " + _fixed([name, 0, form, 2, 0, "", "", len(K)], 8)]
    for j in range(len(K)):
        entries = [(dofs[i], K[i, j]) for i in range(j if form == 6 else 0, len(K))]
        head = [name, dofs[j][0], dofs[j][1], ""]
        groups = [[node, direction, value, ""] for (node, direction), value in entries]
        if style == "large":
            lines.append("DMIG*   " + _fixed(head, 16))
            for node, direction, value, _ in groups:
                lines.append("*       " + f"{node:16d}{direction:16d}{value:16.9E}".replace("E", "D"))
        elif style == "free":
            lines.append(",".join(map(str, ["DMIG", *head, *groups[0]])))
            lines += [",".join(map(str, ["", *group])) for group in groups[1:]]
        else:
            short = [[g[0], g[1], f"{g[2]:.2E}".replace("E", "")[:8], ""] for g in groups]
            lines.append("DMIG    " + _fixed([*head, *short[0]], 8))
            pairs = [
                [field for group in short[k : k + 2] for field in group] for k in range(1, len(short), 2)
            ]
            lines += ["        " + _fixed(pair, 8) for pair in pairs]
    return "\n".join([*lines, "ENDDATA", ""])


def nastran_op4(K, name="KAAX", style="dense"):
    """ASCII OUTPUT4, format 1P,3E23.16: numbers touch when they are negative."""
    n = len(K)
    rows = -n if style == "bigmat" else n
    lines = [f"{n:8d}{rows:8d}{6:8d}{2:8d}{name:8s}1P,3E23.16"]

    def numbers(values):
        text = [f"{value:23.16E}" for value in values]
        return ["".join(text[k : k + 3]) for k in range(0, len(text), 3)]

    for j in range(n):
        if style == "dense":
            lines += [f"{j + 1:8d}{1:8d}{n:8d}", *numbers(K[:, j])]
            continue
        half = n // 2
        strings = [(1, K[:half, j]), (half + 1, K[half:, j])]
        header = 2 if style == "bigmat" else 1
        lines.append(f"{j + 1:8d}{0:8d}{sum(2 * len(v) + header for _, v in strings):8d}")
        for row, values in strings:
            long = 2 * len(values) + 1
            lines.append(f"{long:8d}{row:8d}" if style == "bigmat" else f"{row + 65536 * long:12d}")
            lines += numbers(values)
    return "\n".join([*lines, f"{n + 1:8d}{1:8d}{1:8d}", *numbers([1.0]), ""])


def calculix_displacements(tables, node_set="NC"):
    """tables: (nodes, (n, 3) displacements) per step."""
    return calculix_reactions(tables, node_set).replace("forces (fx,fy,fz)", "displacements (vx,vy,vz)")


def calculix_frd(tables, blocks=("FORC",)):
    """The beginning of a result file, and blocks of (nodes, (n, 3) vectors) per step."""
    text = (
        "    1C\n    1UPGM               CalculiX\n    2C             1   1\n -1         1 0.0 0.0 0.0\n -3\n"
    )
    for step, (nodes, vectors) in enumerate(tables, start=1):
        for block in blocks:
            text += f"    1PSTEP{step:26d}{1:12d}{step:12d}\n"
            text += f"  100CL  {100 + step}{step:12.9f}{len(nodes):12d}{0:22d}{step:5d}{1:12d}\n"
            text += f" -4  {block:8s}    4    1\n -5  D1          1    2    1    0\n"
            for node, vector in zip(nodes, vectors, strict=True):
                text += f" -1{node:10d}" + "".join(f"{value:12.5E}" for value in vector) + "\n"
            text += " -3\n"
    return text + " 9999\n"


def calculix_reactions(tables, node_set="NC"):
    """tables: (nodes, (n, 3) forces) per step."""
    text = ""
    for step, (nodes, forces) in enumerate(tables, start=1):
        text += f"\n forces (fx,fy,fz) for set {node_set} and time  {step:.7E}\n\n"
        for node, force in zip(nodes, forces, strict=True):
            text += f"{node:10d}" + "".join(f"{value:14.6E}" for value in force) + "\n"
    return text


def ansys_archive(places, elements, components, types=(182,), more=()) -> str:
    """A ``.cdb`` file: places by labels, (type, nodes) by labels, (kind, labels) by names."""
    lines = ["/PREP7", *(f"ET,{k},{number}" for k, number in enumerate(types, start=1)), *more]
    lines += [f"NBLOCK,6,SOLID,{max(places)},{len(places)}", "(3i9,6e21.13e3)"]
    lines += [f"{label:9d}{0:9d}{0:9d}" + "".join(f"{x:21.13E}" for x in at) for label, at in places.items()]
    lines += ["N,R5.3,LOC,       -1,", f"EBLOCK,19,SOLID,{max(elements)},{len(elements)}", "(19i9)"]
    for label, (kind, nodes) in elements.items():
        row = [1, kind, 1, 1, 0, 0, 0, 0, len(nodes), 0, label, *nodes]
        lines += ["".join(f"{x:9d}" for x in part) for part in (row[:19], row[19:]) if part]
    lines.append("       -1")
    for name, (kind, own) in components.items():
        lines += [f"CMBLOCK,{name:8s},{kind},{len(own)}", "(8i10)"]
        lines += ["".join(f"{x:10d}" for x in own[k : k + 8]) for k in range(0, len(own), 8)]
    return "\n".join([*lines, "FINISH", ""])


def universal(places, labels, cells, groups=()) -> str:
    """A ``.unv`` file: nodes, elements (descriptor, nodes), groups (name, code of their members, members)."""

    def rows(numbers):
        return ["".join(f"{v:10d}" for v in numbers[k : k + 8]) for k in range(0, len(numbers), 8)]

    lines = ["    -1", "  2411"]
    for label, place in zip(labels, places, strict=True):
        lines += [*rows((label, 1, 1, 11)), "".join(f"{x:25.16E}" for x in place).replace("E", "D")]
    lines += ["    -1", "    -1", "  2412"]
    for label, (kind, nodes) in enumerate(cells, start=1):
        lines += [*rows((label, kind, 1, 1, 7, len(nodes)))]
        lines += [*rows((0, 1, 1))] if kind == 11 else []  # a beam has a row of its own
        lines += rows(nodes)
    lines += ["    -1", "    -1", "  2467"]
    for k, (name, code, members) in enumerate(groups, start=1):
        lines += [*rows((k, 0, 0, 0, 0, 0, 0, len(members))), name]
        lines += rows([v for member in members for v in (code, member, 0, 0)])
    return "\n".join([*lines, "    -1", ""])


def harwell_boeing(K, kind="RSA", stored=lambda i, j: i >= j) -> str:
    """By the definition of the format: pointers, rows, values, in fixed fields that may touch."""
    n = len(K)
    columns = [[(i, K[i, j]) for i in range(n) if stored(i, j)] for j in range(n)]
    rows, values = zip(*[pair for column in columns for pair in column], strict=True)
    pointers = np.cumsum([1, *map(len, columns)])
    blocks = []
    for numbers, field, count in (
        (pointers, "5d", 16),
        (np.array(rows) + 1, "5d", 16),
        (values, "22.15E", 3),
    ):
        texts = [format(number, field) for number in numbers]
        blocks.append(["".join(texts[k : k + count]) for k in range(0, len(texts), count)])
    sizes = [sum(map(len, blocks)), *map(len, blocks), 0]
    head = ["stiffness".ljust(72) + "key", "".join(f"{size:14d}" for size in sizes)]
    head += [f"{kind}           {n:14d}{n:14d}{len(values):14d}{0:14d}"]
    head += [f"{'(16I5)':16s}{'(16I5)':16s}{'(1P,3E22.15)':20s}"]
    return "\n".join([*head, *(line for block in blocks for line in block), ""])
