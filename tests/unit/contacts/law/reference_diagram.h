/* reference_diagram.h: moving control points, for the stress model tptm: the places where the law changes
   along a contact, and integrals between them, where every field is linear in x. Read reference_law.h
   first. */
#pragma once
#include "reference_law.h"

enum { MAX_POINTS = 64 };
typedef struct {
  int n;
  double x[MAX_POINTS];
} Points;
typedef double (*Field)(const OneContact *c, double x);

/* What happens at a control point: the field of that name (EventField) is zero there. */
typedef enum {
  LINE_0,
  LINE_1,
  LINES_MEET,
  OPENS,
  CRUSHES,
  APEX,
  SLIPS_UP,
  SLIPS_DOWN,
  PRESSES,
  STOPS,
  PULLS
} Event;

static inline double EventField(const OneContact *c, Event event, double x)
{
  const Strength *s = StrengthAt(c, x);
  const double sigma = TrialSigma(c, x), tau = Along(c->tau, x), line = Along(c->closure[event == LINE_1], x);
  switch (event) {
  case LINE_0:
  case LINE_1:
    return line;
  case LINES_MEET:
    return line - Along(c->closure[1], x);
  case OPENS:
    return sigma - s->T;
  case CRUSHES:
    return sigma + c->C;
  case APEX:
    return s->c - fmax(sigma, -c->C) * s->tan_phi;
  case SLIPS_UP:
    return tau - LimitAt(c, x);
  case SLIPS_DOWN:
    return tau + LimitAt(c, x);
  case PRESSES:
    return sigma;
  case STOPS:
    return sigma + Along(c->dashpot, x) + c->C;
  default:
    return sigma + Along(c->dashpot, x);
  }
}

/* Adds a point; points stay in ascending order, and two events at one place are one point. */
static inline void AddPoint(Points *p, double x)
{
  int i = 1;
  if (!(x > 0 && x < 1) || p->n == MAX_POINTS) return;
  while (p->x[i] < x) i++;
  if (x - p->x[i - 1] < 1e-13 || p->x[i] - x < 1e-13) return;
  for (int j = p->n++; j > i; j--) p->x[j] = p->x[j - 1];
  p->x[i] = x;
}

static const double GAUSS[2] = {0.2113248654051871177, 0.7886751345948128823};

/* Adds the control points of the events first .. last, in this order. */
static inline void AddEvents(const OneContact *c, Event first, Event last, Points *p)
{
  for (Event event = first; event <= last; event++) {
    const Points old = *p;
    for (int i = 0; i + 1 < old.n; i++) {
      const double a = old.x[i], h = old.x[i + 1] - a; /* the field may jump at the ends of the piece */
      const double f = EventField(c, event, a + GAUSS[0] * h), g = EventField(c, event, a + GAUSS[1] * h);
      const double slope = (g - f) / (GAUSS[1] - GAUSS[0]), x = GAUSS[0] - f / slope;
      if (slope != 0 && x > 0 && x < 1) AddPoint(p, a + x * h);
    }
  }
}

/* The places where the trial stress, the strength or the limit of shear bends or jumps. */
static inline Points LimitPoints(const OneContact *c)
{
  Points p = {2, {0, 1}};
  AddEvents(c, LINE_0, LINES_MEET, &p);
  AddPoint(&p, c->broken[0]), AddPoint(&p, 1 - c->broken[1]);
  AddEvents(c, OPENS, APEX, &p);
  return p;
}

/* F: end forces statically equal to the diagram of f, F_0 = L int f (1-x) dx and F_1 = L int f x dx. */
static inline void IntegrateDiagram(const OneContact *c, const Points *p, Field f, double F[2])
{
  F[0] = F[1] = 0;
  for (int i = 0; i + 1 < p->n; i++)
    for (int g = 0; g < 2; g++) { /* two Gauss points are exact, because f is linear in each piece */
      const double h = p->x[i + 1] - p->x[i], x = p->x[i] + GAUSS[g] * h, force = 0.5 * h * c->L * f(c, x);
      F[0] += (1 - x) * force, F[1] += x * force;
    }
}

/* The places where the stress that dashpots add bends. */
static inline Points DashpotPoints(const OneContact *c)
{
  Points p = {2, {0, 1}};
  AddEvents(c, LINE_0, LINES_MEET, &p);
  AddEvents(c, CRUSHES, CRUSHES, &p);
  AddEvents(c, PRESSES, PULLS, &p);
  return p;
}
