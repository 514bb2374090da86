/* sorted.c: finds the end forces of contacts in the cycles between two checks, where friction is drawn
   towards the law (FRICTION_PULLED) or is springs that keep their slip (FRICTION_SPRINGS).

   In a dam of many stones half of the contacts slip, and half of these are open at both ends. The response of
   a contact that slips in part takes ten times as long as that of an elastic one, and LANES contacts take
   that time when one of them slips so. So contacts are sorted. Those whose springs are elastic and those that
   are open have their forces at once. All others of a stretch are collected and respond LANES at a time,
   wherever they are. No lane sees another, so each has the bits of the response in place. */
#include "contacts/evaluation.h"

/* The contacts of a stretch that respond together: their inputs, one after the other. */
typedef struct {
  int n;
  PetscInt contact[STRETCH + LANES], joint[STRETCH + LANES];
  PetscReal length[STRETCH + LANES], u_n[2][STRETCH + LANES], u_s[2][STRETCH + LANES],
      own[2][STRETCH + LANES], slip[2][STRETCH + LANES], broken[2][STRETCH + LANES];
} Collected;

KERNEL void Collect(const LanesContact *now, const Lanes own[2], int lane, PetscInt contact, PetscInt joint,
                    Collected *all)
{
  const int i = all->n++;
  all->contact[i] = contact, all->joint[i] = joint, all->length[i] = now->length[lane];
  for (int k = 0; k < 2; k++) {
    all->u_n[k][i] = now->u_n[k][lane], all->u_s[k][i] = now->u_s[k][lane], all->own[k][i] = own[k][lane];
    all->slip[k][i] = now->slip[k][lane], all->broken[k][i] = now->broken[k][lane];
  }
}

/* Finds the forces of LANES contacts from `first` on where they are simple, and collects the others. An open
   contact bears nothing, and its springs have slipped as far as its ends. at: place of the first lane in
   `found`. */
KERNEL void Sort(const Evaluation *of, const PetscReal *row, const LanesJoint *J, size_t first,
                 const Place *p, size_t at, StretchForces *found, Collected *all)
{
  Contacts *c = of->c;
  const int traits = c->traits[first / LANES];
  Lanes own[2] = {LanesOf(0.), LanesOf(0.)};
  LanesContact now;
  now.length = LoadLanes(c->length + first);
  for (int k = 0; k < 2; k++) {
    const size_t i = SUB(first, k);
    now.u_n[k] = p->d_n[k], now.u_s[k] = p->d_s[k], now.slip[k] = now.broken[k] = LanesOf(0.);
    if (traits & RESTS) now.u_n[k] -= LoadLanes(c->rest + i);
    if (!(traits & HISTORY)) continue;
    now.slip[k] = LoadLanes(of->from.slip + i), now.broken[k] = LoadLanes(of->from.broken + i);
    own[k] = LoadLanes(c->slip + i);
  }
  TrialStresses(J, 0, &now);
  const Mask kept = (own[0] == now.slip[0]) & (own[1] == now.slip[1]), whole = IsElastic(J, 0, &now),
             springs = (whole & kept) | J->elastic,
             open = ~springs & (now.sigma[0] > 0.) & (now.sigma[1] > 0.) & (J->peak.tension == 0.) &
                    (J->k_s > 0.) & (now.broken[0] <= 0.) & (now.broken[1] <= 0.),
             rest = ~(springs | open);
  RespondElastic(row, &now);
  for (int k = 0; k < 2; k++) {
    StoreLanes(found->F_n[k] + at, Keep(springs, now.F_n[k]));
    StoreLanes(found->F_s[k] + at, Keep(springs, now.F_s[k]));
  }
  if (!Any(~springs)) return;
  c->traits[first / LANES] = (uint16_t)(traits | HISTORY);
  for (int k = 0; k < 2; k++) StoreLanes(c->slip + SUB(first, k), Select(open, now.u_s[k], own[k]));
  if (!Any(rest)) return;
  for (int lane = 0; lane < LANES; lane++)
    if (rest[lane]) Collect(&now, own, lane, (PetscInt)first + lane, c->joint[first + lane], all);
}

/* Loads the joints of the LANES collected contacts from i on, unless J is of the same rows. */
KERNEL void LoadCollected(const Evaluation *of, const Collected *all, int i, PetscInt rows[LANES],
                          LanesJoint *J)
{
  int same = 1;
  for (int lane = 0; lane < LANES; lane++) same &= rows[lane] == all->joint[i + lane];
  if (same) return;
  for (int lane = 0; lane < LANES; lane++) rows[lane] = all->joint[i + lane];
  LoadJoints(of->joints, rows, of->c->margin, J);
}

/* Lets the collected contacts respond. last, last_rows: joints that are loaded, and their rows, mostly
   those of these contacts; begin: contact of the first place in `found`. */
KERNEL void RespondCollected(const Evaluation *of, const LanesModel *model, const LanesJoint *last,
                             const PetscInt last_rows[LANES], PetscInt begin, Collected *all,
                             StretchForces *found)
{
  Contacts *c = of->c;
  PetscInt rows[LANES];
  LanesJoint J = *last;
  for (int lane = 0; lane < LANES; lane++) rows[lane] = last_rows[lane];
  for (int lane = 0; lane < LANES; lane++) { // the last contact fills the remaining lanes
    const int from = all->n - 1, i = all->n + lane;
    all->joint[i] = all->joint[from], all->length[i] = all->length[from];
    for (int k = 0; k < 2; k++) {
      all->u_n[k][i] = all->u_n[k][from], all->u_s[k][i] = all->u_s[k][from];
      all->own[k][i] = all->own[k][from];
      all->slip[k][i] = all->slip[k][from], all->broken[k][i] = all->broken[k][from];
    }
  }
  for (int i = 0; i < all->n; i += LANES) {
    LanesContact now;
    Lanes own[2];
    now.length = LoadLanes(all->length + i);
    LoadCollected(of, all, i, rows, &J);
    for (int k = 0; k < 2; k++) {
      now.u_n[k] = LoadLanes(all->u_n[k] + i), now.u_s[k] = LoadLanes(all->u_s[k] + i);
      now.slip[k] = LoadLanes(all->slip[k] + i), now.broken[k] = LoadLanes(all->broken[k] + i);
      own[k] = LoadLanes(all->own[k] + i);
    }
    if (of->pull > 0.) {
      RespondFollowing(&J, model, of->pull, 0, own, &now);
    } else {
      RespondContacts(&J, model, 1, 0, 0, &now);
      own[0] = now.slip[0], own[1] = now.slip[1];
    }
    for (int lane = 0; lane < LANES && i + lane < all->n; lane++)
      for (int k = 0; k < 2; k++) {
        const PetscInt contact = all->contact[i + lane];
        found->F_n[k][contact - begin] = now.F_n[k][lane];
        found->F_s[k][contact - begin] = now.F_s[k][lane];
        c->slip[SUB(contact, k)] = own[k][lane], c->broken[SUB(contact, k)] = now.broken[k][lane];
      }
  }
}

/* Decides whether the joints of LANES contacts from `first` on can be sorted. Joints that crush, soften or
   lose strength have more history than slip. */
KERNEL int CanSort(const Contacts *c, const LanesJoint *J, PetscInt first)
{
  return !J->crushes && !J->softens && !Any(J->brittle) && !(c->traits[first / LANES] & CRUSHED);
}

KERNEL void SortStretch_code(const Evaluation *of, int model, PetscInt from, PetscInt to, const Place *places,
                             LanesJoint *J, StretchForces *found, PetscInt *end)
{
  const Contacts *c = of->c;
  Collected all;
  PetscInt i;
  all.n = 0;
  for (i = from; i < to; i += LANES) {
    if (c->traits[i / LANES] & JOINTS) LoadJoints(of->joints, c->joint + i, c->margin, J);
    if (!CanSort(c, J, i)) break;
    Sort(of, LanesModels[model].elastic, J, (size_t)i, places + (i - from) / LANES, (size_t)(i - from), found,
         &all);
  }
  if (all.n)
    RespondCollected(of, LanesModels + model, J, c->joint + PetscMin(i, to - LANES), from, &all, found);
  *end = i;
}

VARIANTS(SortStretch,
         (const Evaluation *of, int model, PetscInt from, PetscInt to, const Place *places, LanesJoint *J,
          StretchForces *found, PetscInt *end),
         (of, model, from, to, places, J, found, end))

PetscInt SortedForces(const Evaluation *of, int model, PetscInt from, PetscInt to, const Place *places,
                      LanesJoint *J, StretchForces *found)
{
  PetscInt end;
  SortStretch(of, model, from, to, places, J, found, &end);
  return end;
}
