"""The coefficients of MF-Tyre 5.2 and MF 6.1, under the names that `.tir` files give them."""

from __future__ import annotations

import msgspec


class Coefficients(msgspec.Struct, frozen=True, kw_only=True):
    """Coefficients of one tyre in SI units; what a file leaves out is 0, a scaling factor 1, a range endless.

    Names follow the `.tir` files and the books. Each model version reads the ones that it knows.
    """

    # Dimensions, nominal state
    UNLOADED_RADIUS: float = 0.0
    FNOMIN: float = 0.0
    LONGVL: float = 0.0
    NOMPRES: float = 0.0
    INFLPRES: float = 0.0
    VERTICAL_STIFFNESS: float = 0.0
    LONGITUDINAL_STIFFNESS: float = 0.0
    LATERAL_STIFFNESS: float = 0.0
    BREFF: float = 0.0
    DREFF: float = 0.0
    FREFF: float = 0.0
    PFZ1: float = 0.0

    # Ranges of validity
    VXLOW: float = 0.0
    KPUMIN: float = -1e9
    KPUMAX: float = 1e9
    ALPMIN: float = -1e9
    ALPMAX: float = 1e9
    CAMMIN: float = -1e9
    CAMMAX: float = 1e9
    FZMIN: float = 0.0
    FZMAX: float = 1e9
    PRESMIN: float = 0.0
    PRESMAX: float = 1e9

    # Scaling factors; LGA? and LSG? belong to 5.2, LKYC and LKZC to 6.1
    LFZO: float = 1.0
    LCX: float = 1.0
    LMUX: float = 1.0
    LEX: float = 1.0
    LKX: float = 1.0
    LHX: float = 1.0
    LVX: float = 1.0
    LGAX: float = 1.0
    LCY: float = 1.0
    LMUY: float = 1.0
    LEY: float = 1.0
    LKY: float = 1.0
    LHY: float = 1.0
    LVY: float = 1.0
    LGAY: float = 1.0
    LKYG: float = 1.0
    LKYC: float = 1.0
    LTR: float = 1.0
    LRES: float = 1.0
    LGAZ: float = 1.0
    LKZC: float = 1.0
    LXAL: float = 1.0
    LYKA: float = 1.0
    LVYKA: float = 1.0
    LS: float = 1.0
    LSGKP: float = 1.0
    LSGAL: float = 1.0
    LMX: float = 1.0
    LVMX: float = 1.0
    LMY: float = 1.0
    LMUV: float = 0.0

    # Longitudinal force
    PCX1: float = 0.0
    PDX1: float = 0.0
    PDX2: float = 0.0
    PDX3: float = 0.0
    PEX1: float = 0.0
    PEX2: float = 0.0
    PEX3: float = 0.0
    PEX4: float = 0.0
    PKX1: float = 0.0
    PKX2: float = 0.0
    PKX3: float = 0.0
    PHX1: float = 0.0
    PHX2: float = 0.0
    PVX1: float = 0.0
    PVX2: float = 0.0
    PPX1: float = 0.0
    PPX2: float = 0.0
    PPX3: float = 0.0
    PPX4: float = 0.0
    RBX1: float = 0.0
    RBX2: float = 0.0
    RBX3: float = 0.0
    RCX1: float = 0.0
    REX1: float = 0.0
    REX2: float = 0.0
    RHX1: float = 0.0
    PTX1: float = 0.0
    PTX2: float = 0.0
    PTX3: float = 0.0
    PCFX1: float = 0.0
    PCFX2: float = 0.0
    PCFX3: float = 0.0

    # Lateral force; 5.2 has PKY4 = 2 built in
    PCY1: float = 0.0
    PDY1: float = 0.0
    PDY2: float = 0.0
    PDY3: float = 0.0
    PEY1: float = 0.0
    PEY2: float = 0.0
    PEY3: float = 0.0
    PEY4: float = 0.0
    PEY5: float = 0.0
    PKY1: float = 0.0
    PKY2: float = 0.0
    PKY3: float = 0.0
    PKY4: float = 2.0
    PKY5: float = 0.0
    PKY6: float = 0.0
    PKY7: float = 0.0
    PHY1: float = 0.0
    PHY2: float = 0.0
    PHY3: float = 0.0
    PVY1: float = 0.0
    PVY2: float = 0.0
    PVY3: float = 0.0
    PVY4: float = 0.0
    PPY1: float = 0.0
    PPY2: float = 0.0
    PPY3: float = 0.0
    PPY4: float = 0.0
    PPY5: float = 0.0
    RBY1: float = 0.0
    RBY2: float = 0.0
    RBY3: float = 0.0
    RBY4: float = 0.0
    RCY1: float = 0.0
    REY1: float = 0.0
    REY2: float = 0.0
    RHY1: float = 0.0
    RHY2: float = 0.0
    RVY1: float = 0.0
    RVY2: float = 0.0
    RVY3: float = 0.0
    RVY4: float = 0.0
    RVY5: float = 0.0
    RVY6: float = 0.0
    PTY1: float = 0.0
    PTY2: float = 0.0
    PCFY1: float = 0.0
    PCFY2: float = 0.0
    PCFY3: float = 0.0

    # Aligning moment
    QBZ1: float = 0.0
    QBZ2: float = 0.0
    QBZ3: float = 0.0
    QBZ4: float = 0.0
    QBZ5: float = 0.0
    QBZ6: float = 0.0
    QBZ9: float = 0.0
    QBZ10: float = 0.0
    QCZ1: float = 0.0
    QDZ1: float = 0.0
    QDZ2: float = 0.0
    QDZ3: float = 0.0
    QDZ4: float = 0.0
    QDZ6: float = 0.0
    QDZ7: float = 0.0
    QDZ8: float = 0.0
    QDZ9: float = 0.0
    QDZ10: float = 0.0
    QDZ11: float = 0.0
    QEZ1: float = 0.0
    QEZ2: float = 0.0
    QEZ3: float = 0.0
    QEZ4: float = 0.0
    QEZ5: float = 0.0
    QHZ1: float = 0.0
    QHZ2: float = 0.0
    QHZ3: float = 0.0
    QHZ4: float = 0.0
    PPZ1: float = 0.0
    PPZ2: float = 0.0
    SSZ1: float = 0.0
    SSZ2: float = 0.0
    SSZ3: float = 0.0
    SSZ4: float = 0.0

    # Rolling resistance
    QSY1: float = 0.0
    QSY2: float = 0.0
    QSY3: float = 0.0
    QSY4: float = 0.0
    QSY5: float = 0.0
    QSY6: float = 0.0
    QSY7: float = 0.0
    QSY8: float = 0.0
