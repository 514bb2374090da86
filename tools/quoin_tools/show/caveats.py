"""Collects what limits trust in the numbers of a sheet: every remark once, numbered, with its stages and bases."""

from quoin_tools.base.language import _, ngettext
from quoin_tools.show.hypertext import esc, head, small, soft

MOST = 6  # remarks on judged stages in the main part; the others stand in the annex


class Caveats:
    """Remarks on stages and on bases; remarks on judged ones come first."""

    def __init__(self, case, found, complaints):
        self.about = {}  # remark: base, or "" for the whole stage, to stages
        for stage, sentences in complaints.items():
            for text in sentences:
                self.about.setdefault(text, {}).setdefault("", []).append(stage)
        for a in found:
            for text in a.notes:
                self.about.setdefault(text, {}).setdefault(a.name, []).append(a.stage)
        judged = {text for text, where in self.about.items() if any(stage in case.conditions for stages in where.values() for stage in stages)}
        self.texts = sorted(self.about, key=lambda text: text not in judged)  # stable
        self.judged = len(judged)

    def number(self, text):
        return self.texts.index(text) + 1

    def where(self, text):
        stages = {}  # bases with the same stages together
        for base, names in self.about[text].items():
            stages.setdefault(tuple(dict.fromkeys(names)), []).append(base)
        return "; ".join(ngettext("stage {1} on {2}", "stages {1} on {2}", len(names), ", ".join(names), ", ".join(bases)) if any(bases) else ngettext("stage {1}", "stages {1}", len(names), ", ".join(names))
                         for names, bases in stages.items())  # fmt: skip

    def line(self, text):
        return f'<p class="note"><b>{self.number(text)}</b> {esc(text)} <small>({esc(self.where(text))})</small></p>'

    def main(self):
        """Returns remarks on judged stages and bases, as far as the main part has room."""
        shown = self.texts[: min(MOST, self.judged)]
        rest = len(self.texts) - len(shown)
        more = small(_("{0} more, in the annex.", rest)) if rest and shown else ""
        return "".join(map(self.line, shown)) + more

    def annex(self):
        rest = self.texts[min(MOST, self.judged) :]
        return head(_("Further reservations")) + "".join(map(self.line, rest)) if rest else ""

    def marks(self, texts):
        """Numbers of remarks, for the place that they are about."""
        return soft(_("Reservations {0}.", ", ".join(str(self.number(text)) for text in texts))) if texts else ""
