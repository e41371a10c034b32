"""What all figures have in common: colours, sizes of letters, units of display."""

from __future__ import annotations

from typing import Any

#: Colours that stay apart in grey and for colour-blind readers (Okabe and Ito).
PLAN, BASELINE, BOUND, BORDER = "#0072B2", "#D55E00", "#999999", "#333333"
STYLE: dict[Any, Any] = {"font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8, "legend.fontsize": 7, "xtick.labelsize": 7, "ytick.labelsize": 7}
#: km/h per m/s
KMH = 3.6
