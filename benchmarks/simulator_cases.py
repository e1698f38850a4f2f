"""Which simulators are asked for the paper's gaits, and with which settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple


@dataclass(frozen=True, kw_only=True)
class Peer:
    """A simulator: its module here, and its package, of which the rest is installed."""

    module: str
    package: str
    apart: bool = True


PEERS = {
    "Drake": Peer(module="benchmarks.drake_peer", package="drake"),
    "Exudyn": Peer(module="benchmarks.exudyn_peer", package="exudyn"),
    "Jiminy": Peer(module="benchmarks.jiminy_peer", package="jiminy-py"),
    "Pinocchio": Peer(module="benchmarks.pinocchio_peer", package="pin", apart=False),
}


class Case(NamedTuple):
    """A simulator, how it takes the ground, steps in a cycle, and settings its module knows.

    Where the steps are not fixed, they are the fewest.
    """

    peer: str
    model: str
    steps: int
    settings: dict[str, Any] = {}
    fixed: bool = True


CENIC = {"discrete": False, "integrator": "cenic"}
RK3 = {"discrete": False, "integrator": "runge_kutta3"}
HYDRO = {"contact_model": "hydroelastic", "modulus": 1e7}
PENALTY = {"contact": "penalty", "dissipation": 300.0}
SPRING = {"model": "spring_damper"}
RK4 = {"solver": "runge_kutta_4", "regularization": 1e-12}
SAP = {"approximation": "sap", "stiffness": 1e6}
CASES = (
    Case("Drake", "point contact, defaults", 800),
    Case("Drake", "point contact, SAP", 200, SAP),
    Case("Drake", "point contact, SAP", 800, SAP),
    Case("Drake", "point contact, SAP", 8000, SAP),
    Case("Drake", "point contact, TAMSI", 800, {**SAP, "approximation": "tamsi"}),
    Case("Drake", "point contact, CENIC", 800,
         {**CENIC, "error_control": False, "stiffness": 1e6, "stiction": 1e-5}),
    Case("Drake", "point contact, CENIC", 16000,
         {**CENIC, "error_control": False, "stiffness": 1e6, "stiction": 1e-5}),
    Case("Drake", "point contact, CENIC, accuracy 1e-7", 800,
         {**CENIC, "accuracy": 1e-7, "servo": 40.0, "stiffness": 1e6, "stiction": 1e-5}, False),
    Case("Drake", "point contact, continuous, RK3, accuracy 1e-4", 80,
         {**RK3, "accuracy": 1e-4, "stiffness": 1e5, "stiction": 3e-4, "dissipation": 1e3}, False),
    Case("Drake", "hydroelastic contact, ball of triangles of 2 cm", 800,
         {**HYDRO, "resolution": 0.02}),
    Case("Drake", "hydroelastic contact, ball of triangles of 5 mm", 800,
         {**HYDRO, "resolution": 0.005}),
    Case("Exudyn", "penalty contact, ball on triangle", 800,
         {**PENALTY, "stiffness": 1e5, "stiction": 1e-3}),
    *(Case("Exudyn", "penalty contact, ball on triangle, stiff", n,
           {**PENALTY, "stiffness": 1e6, "stiction": 1e-4}) for n in (800, 3200)),
    *(Case("Exudyn", "rolling written by the user as velocity constraint", n)
      for n in (200, 800, 3200)),
    Case("Jiminy", "ball on ground, defaults", 50, {"contact": "ground"}, False),
    Case("Jiminy", "ball on ground, spring and damper", 50,
         {"contact": "ground", "contacts": SPRING}, False),
    Case("Jiminy", "ball on ground, spring and damper, steep friction", 800,
         {"contact": "ground",
          "contacts": {**SPRING, "friction": 10.0, "transitionVelocity": 1e-4}}, False),
    Case("Jiminy", "SphereConstraint, defaults", 50, {"baumgarte": 0.0}, False),
    Case("Jiminy", "SphereConstraint, defaults but Baumgarte 20 Hz", 50, {}, False),
    *(Case("Jiminy", "SphereConstraint, RK4", n, RK4) for n in (200, 800, 3200)),
    Case("Jiminy", "SphereConstraint, Dormand-Prince, tolerance 1e-11", 50,
         {"regularization": 1e-12, "tol_abs": 1e-11, "tol_rel": 1e-10}, False),
    Case("Pinocchio", "CONTACT_3D below the centre", 800, {"method": "CONTACT_3D"}),
    *(Case("Pinocchio", f"CONTACT_3D below the centre, Baumgarte {f} / s", n,
           {"method": "CONTACT_3D", "frequency": float(f)})
      for f, n in ((50, 800), (500, 800), (1000, 3200))),
    *(Case("Pinocchio", "no drift, centre's velocity overwritten", n,
           {"method": "zero drift", "project": "overwrite"}) for n in (800, 3200)),
)  # fmt: skip
