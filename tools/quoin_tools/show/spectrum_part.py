"""Writes the part of the sheet about an earthquake by a design spectrum: coefficient, first mode, all modes and records beside each other."""

import numpy as np

from quoin_tools.assess import spectrum_tables
from quoin_tools.assess.assessment import cell
from quoin_tools.base.language import _
from quoin_tools.base.results import sliding
from quoin_tools.show.hypertext import head, notes, small, table


def record_rows(study, shaken):
    """Rows of the joints that are planes, in stages that are shaken: the largest changes of forces since the stage began, the least factor of one moment."""
    planes, rows = {row.plane: row.level for row in study.rows}, []
    for stage in shaken.stages if shaken else ():
        series = shaken.series(stage)
        for name, c in series.joints.items() if shaken.is_shaken(stage) else ():
            if name in planes:
                finite = c["factor_peak"][np.isfinite(c["factor_peak"])]
                rows.append((name, cell(planes[name], 2), _("record, stage {0}", stage), cell(abs(c["T"] - c["T"][0]).max() / 1e3, 0), "-", cell(abs(c["N"] - c["N"][0]).max() / 1e3, 0),
                             sliding(float(finite.min()) if len(finite) else None, 2), "-", cell(float(c["open_length"].max()), 2), "-"))  # fmt: skip
    return rows


def spectrum_part(study, shaken=None):
    """HTML; empty: no spectrum was given."""
    if study is None:
        return ""
    records = record_rows(study, shaken)
    part = head(_("Earthquake by a spectrum")) + table(("", ""), spectrum_tables.facts_of(study), (1,)) + notes(study.why)
    if not study.rows:
        return part
    return part + table(map(_, spectrum_tables.COLUMNS), spectrum_tables.rows_of(study) + records, (1, 3, 4, 5, 6, 7, 8)) + small(_(spectrum_tables.READ)) + notes(spectrum_tables.failed(study)) + notes(spectrum_tables.left_out(study, bool(records)))
