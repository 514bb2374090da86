"""Collects what limits trust in the numbers of a sheet: every remark once, numbered, with its stages and bases."""

from quoin_tools.show.hypertext import esc

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
        return "; ".join(f"stage{'s' * (len(names) > 1)} {', '.join(names)}" + (f" on {', '.join(bases)}" if any(bases) else "") for names, bases in stages.items())

    def line(self, text):
        return f'<p class="note"><b>{self.number(text)}</b> {esc(text)} <small>({esc(self.where(text))})</small></p>'

    def main(self):
        """Returns remarks on judged stages and bases, as far as the main part has room."""
        shown = self.texts[: min(MOST, self.judged)]
        rest = len(self.texts) - len(shown)
        more = f"<p><small>{rest} more, in the annex.</small></p>" if rest and shown else ""
        return "".join(map(self.line, shown)) + more

    def annex(self):
        rest = self.texts[min(MOST, self.judged) :]
        return "<h2>Further reservations</h2>" + "".join(map(self.line, rest)) if rest else ""

    def marks(self, texts):
        """Numbers of remarks, for the place that they are about."""
        return f"<p class='soft'>Reservations {', '.join(str(self.number(text)) for text in texts)}.</p>" if texts else ""
