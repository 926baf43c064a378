"""What text and pages say in sentences: a fixed list, each of at most 25 words."""

# about the answer
ASSUMED = (
    "Assumed: quasi-static loads, Coulomb friction with one constant coefficient per node, linear elastic "
    "bodies, small displacements."
)
NOT_SAID = "Nothing is said about the strength of the material, wear, or fretting fatigue."
CONSTANT = "The loading does not change over the period, so the load factor makes no difference."
GIVEN_STATES = "The file has initial slips: --initial given proves from the first of them."
NO_PROOF = "Limits of averaged slips prove nothing of the joint itself."
COMPUTED = (
    "computed: exactly, or to a relative width that exact arithmetic confirms; else in floats (double "
    "precision), or simulated."
)
# about the loads
LOAD_DOMAIN = "The load steps are the corners of a load domain: limits hold for every path inside it."
ONE_PATH = "The corners of the load domain are simulated in the order given: one path of many."
# about the joint
TOO_LONG = "Too long to be kept with the problem; its SHA-256 is among the sources."
FLOATING = "Only friction keeps one body from sliding or turning on the other, as in a bolted joint."
DIRECTIONS = "x, y: the two tangential directions of a node, in the order of the file."
REACHED = "reached: the load steps, counted from 0, in which the node is at its friction limit."
F_THRESHOLD = "f threshold: above it the node alone, all others stuck, has no unique motion (A_jj/|B_jj|)."
ZONE_SLIP = "open: throughout; its safe slip is the displacement of the node under the mean load."
NO_SIDES = "λ_1, sensitivities and friction thresholds exist for plane joints, with one tangential direction."
NOT_UNIQUE = (
    "Above the threshold of uniqueness a motion may have several continuations or none, and then it jumps."
)
WEDGING = "Above the threshold of wedging, locked-in slip can hold the joint without any load."
# about a run
APART = "All nodes are open: the bodies separate."
SIGN = "Is the sign of p_w right, or does an initial gap stay open?"
SLIDES_AWAY = "The joint does not hold: the body slides away (gross slip)."
SEPARATION = "Separation: nodes open and close in every period, and none slips while it is closed."
NO_PERIOD = "There is no steady period, and so there are no numbers."
TRANSIENT_MOVES = "The transient load steps move every slip that is safe in the loop."
SUMMED = "Σ|Δv|: slip distance per cycle."
FORCES = "p and q: normal and tangential force."
MIXED = "mixed: open at times; slip range and distance count only what slips in contact."
MESH_AT_EDGES = "At a sharp edge pressure, wear and τ δ of the last node depend on the mesh; slips do not."
AFTER = "(after): the state locked in when the transient load steps are over."
IN_ZONE = "(zone): starts with the nodes of the zone open."
JUDGED = "Agreement is judged only where the limits predict the outcome."
RESIDUAL = "Residual: largest relative violation of the friction law, computed again from slips and gaps."
ALL_NODES = "All nodes with all digits: shakedown-bounds nodes FILE --load-factor 1 -o nodes.csv (or .vtu)."
# about maps, sweeps, meshes, damping
GRID = "A grid is no random sample: it has no confidence interval."
SHARE = "The share is that of these states; states from another region have another share."
SPREAD = "spread: how far apart the slips lie on which these states end; 0: all on the same motion."
UNTRIED = "Of states not tried only “proved from every state” says something (solve)."
AT_VALUES = "Limits are proved at the values given, not between them."
OF_ZONES = "–: nodes are open there, and no limit of the whole joint is known."
TREND = "A number converges where a + c h^p fits the last three meshes with p ≥ 0.5: evidence, no proof."
FALLING = "What falls or grows says something about one element; order is then the power of its size."
FEW_MESHES = "Undecided: so few meshes show no trend; three or more may."
ZERO_MESHES = "zero: no slip, or nothing proved, on these meshes."
OTHER_LOADS = "The other loads stay as they are at λ = 1: an amplitude here is no load factor."
NO_DISPLACEMENT = "Displacements are not known: the problem has no load_compliance."
SAME_FROM_START = (
    "From the initial state every amplitude ends in the same dissipation as from the one before it."
)
# about the enumeration
INFEASIBLE_CORNER = "It lies below λ_1: there other constraints are broken already, so it ends no safe state."
COLLAPSED_AT_MEAN = "λ_1 is 0 all the same: the safe region has collapsed at the mean load already."
DEGENERATE = "A slip of all nodes together changes no reaction, so no subset meets in a point: see solve."
# below pictures
STEPPED = "No state is drawn: the simulations did not go from event to event."
NO_STATE = "No state is drawn: at λ = 1 no long-term state was found."
NO_VIEW = "There is no view to turn: the problem does not say where its nodes are."
NO_LOOPS = "There are no loops to draw: no simulated state from this start slips in every cycle."
SLIP_PER_CYCLE = (
    "Slip per cycle of the node that slips most. A line that falls to “no slip” has shaken down, or is "
    "separation; one that ends on its way down was followed no further. A level line is cyclic slip or "
    "ratchetting. Initial slips: zero; given: from the file; safe: safe at this load; witness: critical at "
    "λ_1; random: left by random loads; ball: in the energy ball."
)
SLIP_SPACE = "Slip space: the limits of both nodes, the safe region, and the paths (○ start, ■ end)."
CHANGES = "Change of a limit [%] with 1 % more friction, constant load or load amplitude at one node."
KINKS = "No bar: the limit has a kink there, and no derivative."
SLIP_OVER_LOAD = (
    "Largest slip range of a node in the long run. Dotted: slips grow for ever or contact is lost."
)
LOADS = (
    "Loads at λ = 1: the welded reactions, those with every slip held. An arrow is a mean, the line at it "
    "the period; beside them the reactions of single nodes, and their sums."
)
