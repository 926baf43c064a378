"""What each load amounts to, on every body and at every patch of the contact, and what is doubtful in it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.models.condensation.contact_frame import ContactFrame, in_space
from shakedown.models.condensation.factorised_interior import WeldedCase
from shakedown.models.condensation.load_case import MEAN_ROUND_OFF, LoadCase, histories
from shakedown.models.importing.bolt_section import BoltSection
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.importing.load_section import LoadSection
from shakedown.models.importing.model_evidence import ModelEvidence, places_of_rows
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import quoted
from shakedown.models.readers.stiffness import Stiffness


@dataclass(frozen=True, eq=False, repr=False)
class LoadPart(Result):
    """What acts on one body, or at one patch of the contact.

    Attributes
    ----------
    what : str
        Which body or patch, in words.
    force : (d + 1,)
        Force along the axes [force]; NaN where it is not known.
    moment : (1,) or (3,)
        Moment about the middle of the contact: for a plane contact about the normal of its plane, in space
        about x, y, z [force × length]; NaN where coordinates are not known.
    """

    what: str
    force: FloatArray
    moment: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class LoadEvidence(Result):
    """Resultants of a load case at factor 1.

    Attributes
    ----------
    name : str
        The load case.
    applied : (d + 1,)
        Sum of its nodal forces along the axes [force].
    contact : (d + 1,)
        Sum of the welded reactions along them: forces of the contact on the
        first body [force]. Where the contact alone holds the model, and no
        displacement is prescribed, it is minus the applied force.
    parts : tuple of LoadPart
        What is applied to every body (with what the shanks of bolts pull), what each patch of the contact
        carries while it is welded (on the first body), and what the supports of every body carry, by
        equilibrium.
    """

    name: str
    applied: FloatArray
    contact: FloatArray
    parts: tuple[LoadPart, ...]


class Resultants:
    """The resultants of load cases of one model."""

    def __init__(
        self,
        stiffness: Stiffness,
        contact: ContactSection,
        frame: ContactFrame,
        evidence: ModelEvidence,
        mesh: Mesh,
        bolts: Sequence[BoltSection] = (),
    ) -> None:
        self.dofs, self.contact, self.frame, self.bolts = stiffness.dofs, contact, frame, bolts
        self.bodies = evidence.bodies
        self.axisymmetric = mesh.axisymmetric
        self.places = None if self.axisymmetric else places_of_rows(stiffness, mesh)
        self.middle = np.zeros(3)
        if self.places is not None:
            self.middle = np.mean([self.places[k] for k in contact.first.tolist()], axis=0)

    def of(self, case: LoadCase, name: str, reactions: FloatArray, pulls: FloatArray) -> LoadEvidence:
        """The resultants of one load case, with its name, its welded reactions and its pull on every bolt."""
        frame, layout = self.frame, self.frame.layout
        q, p = layout.split(reactions)
        welded = (layout.by_node(q)[..., None] * frame.slip_axes).sum(axis=1) + p[:, None] * frame.normals
        force = np.zeros(len(self.dofs)) if case.force is None else case.force
        along = np.where(self.dofs[:, 0] > 0, self.dofs[:, 1], 0)  # of nodes, not of modes
        applied = np.array([force[along == axis].sum() for axis in self.contact.axes])
        for pull, bolt in zip(pulls, self.bolts, strict=True):  # by their shanks while the contact is welded
            if bolt.stiffness and bolt.unit.force is not None:
                force = force + pull * bolt.unit.force
        parts = self._parts(case, force, in_space(welded, self.contact.axes))
        return LoadEvidence(name, applied, welded.sum(axis=0), tuple(parts))

    def _parts(self, case: LoadCase, force: FloatArray, welded: FloatArray) -> Iterator[LoadPart]:
        first, met = self.contact.first, self.contact.met
        d = met.normals.shape[1]
        on_second = np.zeros((len(met.master), 3))
        on_second[:, :d] = met.on_master(welded[self.contact.positions(met.labels), :d])
        rows = (force != 0) & np.isin(self.dofs[:, 1], range(1, 7))
        nodes, direction = self.dofs[rows].T
        along = force[rows, None] * (direction[:, None] == np.arange(1, 7))
        acting = {body.name: self._wrench(nodes, along, body.nodes) for body in self.bodies}
        for name, wrench in acting.items():
            if np.nan_to_num(wrench).any():
                yield self._part(f"applied, {name}", wrench)
        for patch, part in enumerate(self.contact.parts):
            on = self.contact.numbers == patch
            which = part.name or self.bodies[0].name
            yield self._part(f"contact, {which}", self._wrench(first[on], welded[on]))
        if case.reactions is not None or case.opened is not None:
            return  # what acts on the bodies besides is not known
        keys = [axis - 1 for axis in self.contact.axes]
        size = max(np.abs(force).max(initial=0.0), np.abs(welded).max())
        for body in self.bodies:
            carried = -acting[body.name] - self._wrench(first, welded, body.nodes)
            carried -= self._wrench(met.master, on_second, body.nodes)
            if self.axisymmetric:  # the hoop stress carries the radial rest
                carried[0] = np.nan
            bears = body.contact_nodes or np.nan_to_num(acting[body.name]).any()
            # only round-off is left for a body without supports
            if (bears and not body.free) or np.nanmax(np.abs(carried[keys])) > SIX_DIGITS * size:
                yield self._part(f"supports, {body.name}", carried)

    def _wrench(self, nodes: IntArray, forces: FloatArray, among: IntArray | None = None) -> FloatArray:
        """Force and moment, (6,), of forces (k, 3), or with moments (k, 6), at nodes, or at some of them."""
        if among is not None:
            nodes, forces = nodes[own := np.isin(nodes, among)], forces[own]
        total = np.zeros(6)
        total[: forces.shape[1]] = forces.sum(axis=0)
        if self.places is None:
            total[3:] = np.nan
        else:
            arms = np.array([self.places[node] for node in nodes.tolist()]).reshape(-1, 3) - self.middle
            total[3:] += np.cross(arms, forces[:, :3]).sum(axis=0)
        return total

    def _part(self, what: str, wrench: FloatArray) -> LoadPart:
        axes = self.contact.axes
        about = [1, 2, 3] if len(axes) == 3 else sorted({1, 2, 3} - set(axes))
        return LoadPart(what, wrench[[axis - 1 for axis in axes]], wrench[[2 + axis for axis in about]])


def load_doubts(
    loads: Sequence[LoadSection], names: Sequence[str], welded: Sequence[WeldedCase], stiffness: FloatArray
) -> Iterator[str]:
    """Warnings about single loads, and about all of them together, on a model with κ."""
    factors, stiff = histories([load.case for load in loads]), float(np.abs(stiffness).max())
    noise = MEAN_ROUND_OFF * np.maximum(np.abs(factors.period).max(axis=0), np.abs(factors.means))
    still = np.abs(factors.period - factors.means).max(axis=0) <= noise
    for load, name, each, at_rest in zip(loads, names, welded, still.tolist(), strict=True):
        case = load.case
        yield from (f"load {quoted(name)}: {doubt}" for doubt in load.doubts)
        if at_rest and (case.history is None or case.history.ndim):  # a number is meant to be constant
            yield f"load {quoted(name)} does not vary: its factor is the same at every load step"
        sizes = [(case.force, 1.0), (case.reactions, 1.0), (case.displacement, stiff), (case.opened, stiff)]
        size = max(scale * np.abs(part).max(initial=0.0) for part, scale in sizes if part is not None)
        holds = size == 0 and case.displacement is not None  # a displacement of zero
        if np.abs(each.reactions).max() <= NEGLIGIBLE * size and not holds:
            yield f"load {quoted(name)} reaches no contact node: the welded contact carries nothing of it"
    if still.all():
        yield (
            f"no load varies over the {len(factors.period)} load step(s): the periodic part is zero, and "
            "every load factor leaves the joint as it is"
        )


def not_pressed(problem: Problem) -> Iterator[str]:
    """A warning about a mean load that does not press the bodies on each other."""
    p_mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    if p_mean.sum() < 0 or not p_mean.any():
        yield (
            "no mean load presses the contact together: normals point into the (first) body, reactions are "
            "the forces on it, and 'gap' is positive where the bodies lie apart"
        )
