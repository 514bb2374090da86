/* The order of what a search finds: pages of keys (of their sections before types) and of steps first, then chapters; records of checks and changes last. */
var Scorer = {
  score: ([page, , , , score]) => {
    const worth = [[/^docs\/reference\/(joints|materials|relaxation|run|checkpoint|contact|supports)\b/, 13], [/^docs\/reference\//, 12], [/^docs\/tutorials\//, 6], [/^docs\/generated\/keys/, 4],
                   [/^docs\/(generated|verification|deviations|extend|design)/, -12], [/^examples\//, -4], [/^CHANGELOG/, -20]];
    return score + (worth.find(([place]) => place.test(page)) || [, 0])[1];
  },
  objNameMatch: 11, objPartialMatch: 6, objPrio: {0: 15, 1: 5, 2: -5}, objPrioDefault: 0,  // as in Sphinx
  title: 15, partialTitle: 7, term: 5, partialTerm: 2,
};
