/* uplift.c: computes the uplift pressure in a joint by the rules of guidelines, and its forces on both
   faces.

   The water is an external force on the blocks. So the stress of the contacts IS the effective stress, and
   the joint law needs no water pressure. The pressure p(s) is piecewise linear along the chord from the
   heel, s = 0, to the toe, s = L. It acts normal to each face in its present position (small strain:
   reference position). H1, H2: heads at heel and toe; H3: head at the drain, s = X; K = 1 - efficiency; T:
   open length. The rules:

     linear        H1 to H2
     npb, usbr     H3 = H2 + K (H1 - H2), K = 1/3: "reduced by two thirds"; in a joint that rises towards the
                  toe, H2 here is the head of the tailwater at the drain, which lies lower than the toe
     usace, ferc   X <= 0.05 H1: H3 = H2 + K (H1 - H2), with the same H2
                   beyond:       H3 = H2 + K (H1 - H2) (L - X) / (L - T)
                   a gallery with a head H4 above H2 at the drain: H4 stands for H2 in H3
     cracked       H1 as far as T, then to H3 while T < X; T >= X: the drain is lost, H1 to H2 from T on. In a
                   joint that falls towards the toe, the water stands higher above T than above the heel:
                   from H1 to level less y there
     earthquake    in a stage with a pseudo-static load the crack T stays as it was before the stage;
                   from T to where the earthquake has opened the joint: the pressure stays (unchanged:
                   linear, npb, usace, ferc), or there is none (zero: usbr); or as cracked (full), by the
                   key in_earthquake
     reaches       T ends where the crack from the heel does, or (any) the last open stretch short of the toe

   npb is the rule of the paper. The user must compare the others with the guideline in force: usbr (written
   for X <= 0.05 H1), usace and ferc, and the crack in all of them (docs/reference/uplift.md). */
#include "water/uplift.h"

/* ---- the diagram */

static PetscReal head(PetscReal level, PetscReal y)
{
  return level > y ? level - y : 0.; // a level that is not given is NaN and has no head
}

/* Returns the head H3 [m] at the drain. */
static PetscReal drain_head(const Load *load, PetscReal H1, PetscReal H2, PetscReal H4, PetscReal L,
                            PetscReal T)
{
  const PetscReal K = 1. - load->uplift.efficiency, X = load->uplift.drain;
  const PetscBool by_place = (PetscBool)(load->uplift.rule == UPLIFT_USACE ||
                                         load->uplift.rule == UPLIFT_FERC);
  const PetscReal base = by_place ? PetscMax(H2, H4) : H2,
                  share = by_place && X > 0.05 * H1 ? (L - X) / (L - T) : 1.;
  return base + K * PetscMax(0., H1 - base) * share;
}

static PetscReal pressure_at(const UpliftDiagram *d, PetscReal s)
{
  PetscInt i = 0;
  while (i + 2 < d->n && s > d->s[i + 1]) i++;
  const PetscReal width = d->s[i + 1] - d->s[i];
  return width > 0. ? d->p[i] + (s - d->s[i]) / width * (d->p[i + 1] - d->p[i]) : d->p[i];
}

/* Sets the pressure to zero between two places of a diagram without jumps. */
static void empty(PetscReal from, PetscReal to, UpliftDiagram *d)
{
  const UpliftDiagram whole = *d;
  const PetscReal length = whole.s[whole.n - 1];
  d->n = 0;
  for (PetscInt i = 0; i < whole.n; i++)
    if (whole.s[i] < from) d->s[d->n] = whole.s[i], d->p[d->n++] = whole.p[i];
  if (from > 0.) d->s[d->n] = from, d->p[d->n++] = pressure_at(&whole, from);
  d->s[d->n] = from, d->p[d->n++] = 0.;
  d->s[d->n] = to, d->p[d->n++] = 0.;
  if (to < length) d->s[d->n] = to, d->p[d->n++] = pressure_at(&whole, to);
  for (PetscInt i = 0; i < whole.n; i++)
    if (whole.s[i] > to) d->s[d->n] = whole.s[i], d->p[d->n++] = whole.p[i];
}

UpliftShaken UpliftInEarthquake(const Scene *scene, const Stage *stage, const Load *load)
{
  PetscBool shakes = PETSC_FALSE;
  for (PetscInt i = 0; i < stage->n_loads; i++)
    shakes = (PetscBool)(shakes || scene->loads[stage->loads[i]].kind == LOAD_PSEUDO_STATIC);
  if (!shakes) return SHAKEN_FULL;
  if (load->uplift.shaken != SHAKEN_RULE) return load->uplift.shaken;
  return load->uplift.rule == UPLIFT_USBR ? SHAKEN_ZERO : SHAKEN_UNCHANGED;
}

PetscReal UpliftFullHead(const Load *load, const Uplift *u, PetscReal s)
{
  const PetscReal H1 = head(load->level, u->heel[1]), fall = PetscMax(0., u->heel[1] - u->toe[1]);
  return H1 > 0. ? H1 + s / u->length * fall : 0.;
}

void UpliftPressure(const Load *load, const Uplift *u, PetscReal gravity, UpliftDiagram *d)
{
  const PetscReal rho_g = load->density * gravity, L = u->length, T = PetscMin(u->crack, L),
                  X = load->uplift.drain;
  const PetscReal y_drain = u->heel[1] + (X > 0. ? X / L : 0.) * (u->toe[1] - u->heel[1]);
  const PetscReal H1 = head(load->level, u->heel[1]), H2 = head(load->uplift.tailwater, u->toe[1]);
  d->n = 0;
  d->s[d->n] = 0., d->p[d->n++] = rho_g * H1;
  if (T > 0.) d->s[d->n] = T, d->p[d->n++] = rho_g * UpliftFullHead(load, u, T);
  const PetscReal tail = PetscMax(H2, head(load->uplift.tailwater, y_drain)); // at the drain
  if (X > T) // false without a drain, where X is NaN
    d->s[d->n] = X, d->p[d->n++] = rho_g * drain_head(load, head(load->uplift.drain_level, u->heel[1]), tail,
                                                      head(load->uplift.gallery, y_drain), L, T);
  if (T < L) d->s[d->n] = L, d->p[d->n++] = rho_g * H2;
  if (u->opened > T) empty(T, PetscMin(u->opened, L), d);
}

/* ---- forces */

void UpliftOnFace(const UpliftDiagram *d, const PetscReal s[2], const PetscReal x[4], PetscReal thickness,
                  PetscReal f[4])
{
  const PetscReal span = s[1] - s[0], length = d->s[d->n - 1];
  const PetscBool across = (PetscBool)(PetscAbsReal(span) < 1e-9 * length); // a face across the joint
  const PetscReal place = PetscClipInterval(s[0], 0., length); // rounding may lead beyond heel and toe
  for (int k = 0; k < 4; k++) f[k] = 0.;
  for (PetscInt i = 0; i + 1 < d->n; i++) {
    const PetscReal width = d->s[i + 1] - d->s[i], slope = width > 0. ? (d->p[i + 1] - d->p[i]) / width : 0.;
    PetscReal t[2], p[2];
    if (across) { // uniform pressure
      if (place < d->s[i] || (place >= d->s[i + 1] && i + 2 < d->n)) continue;
      t[0] = 0., t[1] = 1., p[0] = p[1] = d->p[i] + slope * (place - d->s[i]);
    } else {
      for (int k = 0; k < 2; k++) {
        t[k] = PetscClipInterval((d->s[i + k] - s[0]) / span, 0., 1.);
        p[k] = d->p[i] + slope * (s[0] + t[k] * span - d->s[i]);
      }
    }
    if (t[0] != t[1]) PushAlongFace(t, p, x, thickness, f);
  }
}

PetscReal UpliftPlace(const Uplift *u, const PetscReal X[2])
{
  return ((X[0] - u->heel[0]) * (u->toe[0] - u->heel[0]) + (X[1] - u->heel[1]) * (u->toe[1] - u->heel[1])) /
         u->length;
}

/* Adds the forces to the faces of the joint. Unlike reservoir faces, faces of condensed bodies move: all
   vertices of a face in a joint are kept degrees of freedom, and contacts use their present position.
   Water on both faces of a joint has no resultant only if both faces move. */
void UpliftForces(const TermView *view, const Load *load, const Uplift *uplift, PetscReal *f)
{
  const Model *m = view->m;
  const PetscReal *u = view->state->u + 3 * m->rigid.n;
  const PetscBool moves = (PetscBool)(m->materials.strain == STRAIN_LARGE && !view->faces);
  const PetscBool vertical = (PetscBool)(load->uplift.component == UPLIFT_VERTICAL);
  UpliftDiagram diagram;
  UpliftPressure(load, uplift, view->scene->gravity, &diagram);
  for (PetscInt i = 0; i < uplift->n_faces; i++) {
    const PetscInt *v = m->faces.vertex + 2 * uplift->faces[i];
    PetscReal s[2], x[4], f_face[4];
    for (int k = 0; k < 2; k++) s[k] = UpliftPlace(uplift, m->mesh.X + 2 * v[k]);
    FaceCoordinates(m, moves ? u : NULL, uplift->faces[i], x);
    UpliftOnFace(&diagram, s, x, m->materials.thickness, f_face);
    if (vertical) f_face[0] = f_face[2] = 0.;
    LoadOnFaceKeep(view, uplift->faces[i], x, f_face);
    for (int k = 0; k < 4; k++)
      if (v[k / 2] < m->mesh.n_owned) f[2 * v[k / 2] + k % 2] += f_face[k];
  }
}

/* ---- the joint line, the same on all ranks */

/* Collective. Gathers the faces of the named set, gids: (n,) on all ranks, ascending. */
static PetscErrorCode faces_of_set(const Model *m, const char *name, PetscInt *n, PetscInt **gids)
{
  PetscInt s = 0, n_mine, *mine;
  PetscFunctionBeginUser;
  while (s < m->mesh.n_face_sets && strcmp(m->mesh.face_set_names[s], name)) s++;
  PetscCheck(s < m->mesh.n_face_sets, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no set of faces has the name '%s'",
             name);
  n_mine = m->mesh.face_set_start[s + 1] - m->mesh.face_set_start[s];
  PetscCall(PetscMalloc1(n_mine, &mine));
  for (PetscInt i = 0; i < n_mine; i++)
    mine[i] = m->faces.gid[m->mesh.face_set_faces[m->mesh.face_set_start[s] + i]];
  PetscCall(GatherToAll(m->comm, n_mine, sizeof(PetscInt), mine, n, (void **)gids));
  PetscCall(PetscSortRemoveDupsInt(n, *gids));
  PetscCall(PetscFree(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the faces under pressure: both faces of every contact, even if the set names one side only. */
static PetscErrorCode wet_faces(const Model *m, PetscInt n, const ProfileRow *rows, Uplift *u)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * n, &u->gids));
  u->n_gids = 2 * n;
  for (PetscInt i = 0; i < 2 * n; i++) u->gids[i] = rows[i / 2].key[i % 2];
  PetscCall(PetscSortRemoveDupsInt(&u->n_gids, u->gids));
  PetscCall(PetscMalloc1(m->faces.n_local, &u->faces));
  for (PetscInt f = 0, at; f < m->faces.n_local; f++) {
    PetscCall(PetscFindInt(m->faces.gid[f], u->n_gids, u->gids, &at));
    if (at >= 0) u->faces[u->n_faces++] = f;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the direction e of the joint: the direction of the largest dispersion of the contact ends, all
   with the same weight. */
static void main_direction(PetscInt n, const ProfileRow *rows, PetscReal e[2])
{
  PetscReal mean[2] = {0., 0.}, xx = 0., xy = 0., yy = 0.;
  for (PetscInt i = 0; i < 2 * n; i++)
    for (int x = 0; x < 2; x++) mean[x] += rows[i / 2].point[i % 2][x] / (2. * n);
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal dx = rows[i / 2].point[i % 2][0] - mean[0], dy = rows[i / 2].point[i % 2][1] - mean[1];
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  JointDirection(xx, xy, yy, e);
}

/* Takes the outermost ends as heel (the start of the joint) and toe. Returns the largest distance of an
   end from the chord, over the length of the chord. */
static PetscReal find_chord(PetscInt n, const ProfileRow *rows, Uplift *u)
{
  PetscReal e[2], low = PETSC_INFINITY, high = PETSC_NINFINITY, most = 0.;
  main_direction(n, rows, e);
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal *P = rows[i / 2].point[i % 2], at = P[0] * e[0] + P[1] * e[1];
    if (at < low) low = at, u->heel[0] = P[0], u->heel[1] = P[1];
    if (at > high) high = at, u->toe[0] = P[0], u->toe[1] = P[1];
  }
  for (int x = 0; x < 2; x++) e[x] = u->toe[x] - u->heel[x];
  u->length = PetscHypotReal(e[0], e[1]);
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal *P = rows[i / 2].point[i % 2];
    most = PetscMax(most, PetscAbsReal(e[0] * (P[1] - u->heel[1]) - e[1] * (P[0] - u->heel[0])));
  }
  return most / (u->length * u->length);
}

/* Collective. Reverses the chord if the water stands at the end of the joint. */
static PetscErrorCode find_heel(const Scene *scene, const Model *m, PetscInt load, Uplift *u,
                                char message[MESSAGE_LENGTH])
{
  const PetscReal ends[4] = {u->heel[0], u->heel[1], u->toe[0], u->toe[1]};
  PetscFunctionBeginUser;
  PetscCall(HeelOf(scene, m, load, ends, &u->at_end, message));
  for (int x = 0; x < 2 && u->at_end; x++) u->heel[x] = ends[2 + x], u->toe[x] = ends[x];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode create_one(const Scene *scene, const Load *load, const Model *m, const Contacts *c,
                                 Uplift *u)
{
  char message[MESSAGE_LENGTH] = "", where[64] = "";
  PetscInt n, n_gids, *gids;
  ProfileRow *rows;
  PetscFunctionBeginUser;
  if (load->line) PetscCall(PetscSNPrintf(where, sizeof(where), ":%d", load->line));
  PetscCall(faces_of_set(m, load->target, &n_gids, &gids));
  PetscCall(GatherProfile(m, c, n_gids, gids, &n, &rows));
  if (!n) {
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s%s: loads.%s.faces: '%s' is not a joint: none of its faces is in contact",
                            scene->file, where, load->name, load->target));
  } else {
    const PetscReal off = find_chord(n, rows, u);
    PetscCall(wet_faces(m, n, rows, u));
    PetscCall(find_heel(scene, m, (PetscInt)(load - scene->loads), u, message));
    if (off > 0.1)
      PetscCall(
          PetscSNPrintf(message, MESSAGE_LENGTH,
                        "%s%s: loads.%s.faces: '%s' is no line: it leaves its chord by %.3g of its length, "
                        "at most 0.1 is allowed",
                        scene->file, where, load->name, load->target, (double)off));
    else if (load->uplift.drain >= u->length)
      PetscCall(PetscSNPrintf(
          message, MESSAGE_LENGTH,
          "%s%s: loads.%s.drain: %.6g m from the heel is outside the joint '%s', which is %.6g m long",
          scene->file, where, load->name, (double)load->uplift.drain, load->target, (double)u->length));
  }
  PetscCall(PetscFree(gids));
  PetscCall(PetscFree(rows));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftCreate(const Scene *scene, const Model *m, const Contacts *c, Uplift **all)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->n_loads, all));
  for (PetscInt l = 0; l < scene->n_loads; l++)
    if (scene->loads[l].kind == LOAD_UPLIFT) PetscCall(create_one(scene, scene->loads + l, m, c, *all + l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftDestroy(const Scene *scene, Uplift **all)
{
  PetscFunctionBeginUser;
  for (PetscInt l = 0; *all && l < scene->n_loads; l++) {
    PetscCall(PetscFree((*all)[l].gids));
    PetscCall(PetscFree((*all)[l].faces));
  }
  PetscCall(PetscFree(*all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
