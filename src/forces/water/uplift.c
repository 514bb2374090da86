/* uplift.c: water pressure in a joint, on both of its faces.

   The water is an external force on the blocks, so what the contacts of the joint carry IS the effective
   stress, and the joint law sees it without a word about water. The pressure p(s) runs in straight lines
   along the chord from the heel, s = 0, to the toe, s = L, and presses normal to each face in its present
   position. H1, H2: heads at heel and toe, H3 at the drain, s = X; K = 1 - efficiency; T: open length. The
   rules:

     linear        H1 to H2
     npb, usbr     H3 = H2 + K (H1 - H2), K = 1/3: "reduced by two thirds"
     usace, ferc   X <= 0.05 H1: H3 = H2 + K (H1 - H2)
                   beyond:       H3 = H2 + K (H1 - H2) (L - X) / (L - T)
                   a gallery with a head H4 above H2 at the drain: H4 stands for H2 in H3
     cracked       H1 as far as T, then to H3 while T < X; T >= X: the drain is lost, H1 to H2 from T on
     reaches       T ends where the crack from the heel does, or (any) the last open stretch short of the toe

   npb is the paper's; what the user must compare with the guideline in force: usbr (written for X <= 0.05
   H1), usace and ferc, and the crack in all of them (docs/scene.md). */
#include "stages/stages.h"

/* ---- the diagram */

static PetscReal head(PetscReal level, PetscReal y)
{
  return level > y ? level - y : 0.; // none where there is no level (NaN)
}

/* Head at the drain. */
static PetscReal drain_head(const Load *load, PetscReal H1, PetscReal H2, PetscReal H4, PetscReal L,
                            PetscReal T)
{
  const PetscReal K = 1. - load->efficiency, X = load->drain;
  const PetscBool by_place = (PetscBool)(load->rule == UPLIFT_USACE || load->rule == UPLIFT_FERC);
  const PetscReal base = by_place ? PetscMax(H2, H4) : H2,
                  share = by_place && X > 0.05 * H1 ? (L - X) / (L - T) : 1.;
  return base + K * PetscMax(0., H1 - base) * share;
}

void UpliftPressure(const Load *load, const Uplift *u, PetscReal gravity, UpliftDiagram *d)
{
  const PetscReal rho_g = load->density * gravity, L = u->length, T = PetscMin(u->crack, L), X = load->drain;
  const PetscReal y_drain = u->heel[1] + (X > 0. ? X / L : 0.) * (u->toe[1] - u->heel[1]);
  const PetscReal H1 = head(load->level, u->heel[1]), H2 = head(load->tailwater, u->toe[1]);
  d->n = 0;
  d->s[d->n] = 0., d->p[d->n++] = rho_g * H1;
  if (T > 0.) d->s[d->n] = T, d->p[d->n++] = rho_g * H1;
  if (X > T) // not without a drain (NaN)
    d->s[d->n] = X, d->p[d->n++] = rho_g * drain_head(load, head(load->drain_level, u->heel[1]), H2,
                                                      head(load->gallery, y_drain), L, T);
  if (T < L) d->s[d->n] = L, d->p[d->n++] = rho_g * H2;
}

/* ---- forces */

/* Pressure from p[0] at t[0] to p[1] at t[1] (parameters along the face): exact by two Gauss points. */
static void add_piece(const PetscReal t[2], const PetscReal p[2], const PetscReal x[4], PetscReal thickness,
                      PetscReal f[4])
{
  const PetscReal ex = x[2] - x[0], ey = x[3] - x[1];
  for (int g = -1; g <= 1; g += 2) {
    const PetscReal w = 0.5 + g * 0.5 / PetscSqrtReal(3.), at = t[0] + w * (t[1] - t[0]);
    const PetscReal push = 0.5 * PetscAbsReal(t[1] - t[0]) * (p[0] + w * (p[1] - p[0])) * thickness;
    const PetscReal N[2] = {1. - at, at};
    for (int k = 0; k < 2; k++) {
      f[2 * k] -= N[k] * push * ey; // the outward normal times length is (ey, -ex)
      f[2 * k + 1] += N[k] * push * ex;
    }
  }
}

void UpliftOnFace(const UpliftDiagram *d, const PetscReal s[2], const PetscReal x[4], PetscReal thickness,
                  PetscReal f[4])
{
  const PetscReal span = s[1] - s[0];
  for (int k = 0; k < 4; k++) f[k] = 0.;
  for (PetscInt i = 0; i + 1 < d->n; i++) {
    const PetscReal width = d->s[i + 1] - d->s[i], slope = width > 0. ? (d->p[i + 1] - d->p[i]) / width : 0.;
    PetscReal t[2], p[2];
    if (PetscAbsReal(span) < 1e-9 * d->s[d->n - 1]) { // a step across the joint: one pressure
      if (s[0] < d->s[i] || s[0] >= d->s[i + 1]) continue;
      t[0] = 0., t[1] = 1., p[0] = p[1] = d->p[i] + slope * (s[0] - d->s[i]);
    } else {
      for (int k = 0; k < 2; k++) {
        t[k] = PetscClipInterval((d->s[i + k] - s[0]) / span, 0., 1.);
        p[k] = d->p[i] + slope * (s[0] + t[k] * span - d->s[i]);
      }
    }
    if (t[0] != t[1]) add_piece(t, p, x, thickness, f);
  }
}

/* Place along the chord of a point in the reference state. */
static PetscReal place(const Uplift *u, const PetscReal X[2])
{
  return ((X[0] - u->heel[0]) * (u->toe[0] - u->heel[0]) + (X[1] - u->heel[1]) * (u->toe[1] - u->heel[1])) /
         u->length;
}

void UpliftForces(const Scene *scene, const Load *load, const Uplift *uplift, const Model *m,
                  const PetscReal *u, PetscReal *f)
{
  const PetscReal moving = m->strain == STRAIN_LARGE ? 1. : 0.;
  UpliftDiagram diagram;
  UpliftPressure(load, uplift, scene->gravity, &diagram);
  for (PetscInt i = 0; i < uplift->n_faces; i++) {
    const PetscInt *v = m->faces.vertex + 2 * uplift->faces[i];
    PetscReal s[2], x[4], f_face[4];
    for (int k = 0; k < 2; k++) s[k] = place(uplift, m->X + 2 * v[k]);
    for (int k = 0; k < 4; k++) x[k] = m->X[2 * v[k / 2] + k % 2] + moving * u[2 * v[k / 2] + k % 2];
    UpliftOnFace(&diagram, s, x, m->thickness, f_face);
    for (int k = load->component == UPLIFT_VERTICAL ? 1 : 0; k < 4; k++) {
      if (load->component == UPLIFT_VERTICAL && k == 2) continue;
      if (v[k / 2] < m->n_owned) f[2 * v[k / 2] + k % 2] += f_face[k];
    }
  }
}

/* ---- the joint line, the same on all ranks */

/* A contact of the joint. */
typedef struct {
  PetscInt key[2];
  PetscReal point[2][2]; /* [m] reference place of its ends */
  PetscReal u_n[2];      /* [m] */
  PetscInt open[2];
} ProfileRow;

static int row_order(const void *a, const void *b)
{
  const ProfileRow *p = a, *q = b;
  for (int i = 0; i < 2; i++)
    if (p->key[i] != q->key[i]) return p->key[i] < q->key[i] ? -1 : 1;
  return 0;
}

/* Collective. All ranks' rows one after the other, on all ranks; free with PetscFree. */
static PetscErrorCode gather_all(MPI_Comm comm, PetscInt n, size_t unit, const void *mine, PetscInt *n_all,
                                 void *all)
{
  PetscMPIInt size, bytes, *counts, *starts;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &counts, size + 1, &starts));
  PetscCall(PetscMPIIntCast(n * (PetscInt)unit, &bytes));
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts, 1, MPI_INT, comm));
  starts[0] = 0;
  for (PetscMPIInt r = 0; r < size; r++) starts[r + 1] = starts[r] + counts[r];
  PetscCall(PetscMalloc((size_t)PetscMax(starts[size], 1), (char **)all));
  PetscCallMPI(MPI_Allgatherv(mine, bytes, MPI_BYTE, *(char **)all, counts, starts, MPI_BYTE, comm));
  *n_all = starts[size] / (PetscInt)unit;
  PetscCall(PetscFree2(counts, starts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool has_gid(PetscInt n, const PetscInt *sorted, PetscInt gid)
{
  PetscInt low = 0, high = n;
  while (low < high) {
    const PetscInt middle = (low + high) / 2;
    if (sorted[middle] < gid)
      low = middle + 1;
    else
      high = middle;
  }
  return (PetscBool)(low < n && sorted[low] == gid);
}

/* Contacts with a face in the list of gids, by their faces. */
static PetscErrorCode gather_profile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                                     PetscInt *n, ProfileRow **rows)
{
  PetscInt n_mine = 0;
  ProfileRow *mine;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(c->n, &mine));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->key[2 * i + 1] < 0 || !c->owned[i]) continue;
    if (!has_gid(n_gids, gids, c->key[2 * i]) && !has_gid(n_gids, gids, c->key[2 * i + 1])) continue;
    ProfileRow *row = mine + n_mine++;
    for (int k = 0; k < 2; k++) {
      PetscInt v[3];
      ContactEndVertices(c, i, k, v);
      row->key[k] = c->key[2 * i + k];
      row->u_n[k] = c->u_n[SUB(i, k)];
      row->open[k] = !!(c->state[SUB(i, k)] & CONTACT_OPEN);
      for (int x = 0; x < 2; x++) row->point[k][x] = m->X[2 * v[0] + x];
    }
  }
  PetscCall(gather_all(m->comm, n_mine, sizeof(ProfileRow), mine, n, rows));
  qsort(*rows, *n, sizeof(ProfileRow), row_order);
  PetscCall(PetscFree(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Faces of the named set on all ranks: ascending gids. */
static PetscErrorCode faces_of_set(const Model *m, const char *name, PetscInt *n, PetscInt **gids)
{
  PetscInt s = 0, n_mine, *mine;
  PetscFunctionBeginUser;
  while (s < m->n_face_sets && strcmp(m->face_set_names[s], name)) s++;
  n_mine = m->face_set_start[s + 1] - m->face_set_start[s];
  PetscCall(PetscMalloc1(n_mine, &mine));
  for (PetscInt i = 0; i < n_mine; i++) mine[i] = m->faces.gid[m->face_set_faces[m->face_set_start[s] + i]];
  PetscCall(gather_all(m->comm, n_mine, sizeof(PetscInt), mine, n, gids));
  PetscCall(PetscSortRemoveDupsInt(n, *gids));
  PetscCall(PetscFree(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Both faces of every contact: the faces that the water presses on, even if the set names one side only. */
static PetscErrorCode wet_faces(const Model *m, PetscInt n, const ProfileRow *rows, Uplift *u)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * n, &u->gids));
  u->n_gids = 2 * n;
  for (PetscInt i = 0; i < 2 * n; i++) u->gids[i] = rows[i / 2].key[i % 2];
  PetscCall(PetscSortRemoveDupsInt(&u->n_gids, u->gids));
  PetscCall(PetscMalloc1(m->n_faces_local, &u->faces));
  for (PetscInt f = 0; f < m->n_faces_local; f++)
    if (has_gid(u->n_gids, u->gids, m->faces.gid[f])) u->faces[u->n_faces++] = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Direction of the longest spread of the ends of contacts, to the right, upwards when upright. */
static void main_direction(PetscInt n, const ProfileRow *rows, PetscReal e[2])
{
  PetscReal mean[2] = {0., 0.}, xx = 0., xy = 0., yy = 0.;
  for (PetscInt i = 0; i < 2 * n; i++)
    for (int x = 0; x < 2; x++) mean[x] += rows[i / 2].point[i % 2][x] / (2. * n);
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal dx = rows[i / 2].point[i % 2][0] - mean[0], dy = rows[i / 2].point[i % 2][1] - mean[1];
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  const PetscReal angle = 0.5 * atan2(2. * xy, xx - yy);
  e[0] = cos(angle), e[1] = sin(angle);
  if (e[0] < -1e-6 || (e[0] < 1e-6 && e[1] < 0.)) e[0] = -e[0], e[1] = -e[1];
}

/* Heel and toe are the outermost ends; returns the largest distance of an end from the
   chord, over its length. */
static PetscReal find_chord(const Load *load, PetscInt n, const ProfileRow *rows, Uplift *u)
{
  PetscReal e[2], low = PETSC_INFINITY, high = PETSC_NINFINITY, most = 0.;
  main_direction(n, rows, e);
  if (load->heel == HEEL_END) e[0] = -e[0], e[1] = -e[1];
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

static PetscErrorCode create_one(const Scene *scene, const Load *load, const Model *m, const Contacts *c,
                                 Uplift *u)
{
  char message[MESSAGE_LENGTH] = "", where[64] = "";
  PetscInt n, n_gids, *gids;
  ProfileRow *rows;
  PetscFunctionBeginUser;
  if (load->line) PetscCall(PetscSNPrintf(where, sizeof(where), ":%d", load->line));
  PetscCall(faces_of_set(m, load->target, &n_gids, &gids));
  PetscCall(gather_profile(m, c, n_gids, gids, &n, &rows));
  if (!n) {
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s%s: loads.%s.faces: '%s' is not a joint: none of its faces is in contact",
                            scene->file, where, load->name, load->target));
  } else {
    const PetscReal off = find_chord(load, n, rows, u);
    PetscCall(wet_faces(m, n, rows, u));
    if (off > 0.1)
      PetscCall(
          PetscSNPrintf(message, MESSAGE_LENGTH,
                        "%s%s: loads.%s.faces: '%s' is no line: it leaves its chord by %.3g of its length, "
                        "at most 0.1 is allowed",
                        scene->file, where, load->name, load->target, (double)off));
    else if (load->drain >= u->length)
      PetscCall(PetscSNPrintf(
          message, MESSAGE_LENGTH,
          "%s%s: loads.%s.drain: %.6g m from the heel is outside the joint '%s', which is %.6g m long",
          scene->file, where, load->name, (double)load->drain, load->target, (double)u->length));
  }
  PetscCall(PetscFree(gids));
  PetscCall(PetscFree(rows));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftCreate(const Scene *scene, const Model *m, const Contacts *c, State *state)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->n_loads, &state->uplift));
  for (PetscInt l = 0; l < scene->n_loads; l++)
    if (scene->loads[l].kind == LOAD_UPLIFT)
      PetscCall(create_one(scene, scene->loads + l, m, c, state->uplift + l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftDestroy(const Scene *scene, State *state)
{
  PetscFunctionBeginUser;
  for (PetscInt l = 0; state->uplift && l < scene->n_loads; l++) {
    PetscCall(PetscFree(state->uplift[l].gids));
    PetscCall(PetscFree(state->uplift[l].faces));
  }
  PetscCall(PetscFree(state->uplift));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the cracked base: open length -> pressure -> equilibrium -> open length */

/* A contact along the joint: its ends in the order of s. */
typedef struct {
  PetscReal s[2], u_n[2];
  PetscInt open[2];
} Span;

static int span_order(const void *a, const void *b)
{
  const Span *p = a, *q = b;
  return (p->s[0] > q->s[0]) - (p->s[0] < q->s[0]);
}

/* Contacts in the order of s. */
static PetscErrorCode spans_along(const Uplift *u, PetscInt n, const ProfileRow *rows, Span **spans)
{
  Span *span;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(1, n), &span));
  for (PetscInt i = 0; i < n; i++) {
    const int turned = place(u, rows[i].point[1]) < place(u, rows[i].point[0]);
    for (int k = 0; k < 2; k++) {
      const int from = turned ? 1 - k : k;
      span[i].s[k] = place(u, rows[i].point[from]);
      span[i].u_n[k] = rows[i].u_n[from], span[i].open[k] = rows[i].open[from];
    }
  }
  qsort(span, n, sizeof(Span), span_order);
  *spans = span;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A stretch that is open; closure: of the joint at most [m] between the one before, or the heel, and it. */
typedef struct {
  PetscReal from, to, closure;
} Stretch;

static void add_open(PetscReal tie, PetscReal from, PetscReal to, PetscReal *closure, PetscInt *n,
                     Stretch *open)
{
  if (*n && from <= open[*n - 1].to + tie) {
    open[*n - 1].to = PetscMax(open[*n - 1].to, to);
  } else {
    open[(*n)++] = (Stretch){from, to, *closure};
    *closure = 0.;
  }
}

static PetscReal tie_of(const Uplift *u)
{
  return 1e-6 * u->length;
}

/* Where the joint is open, from heel to toe; where there is no contact, faces have parted. open: (3 n + 1) */
static PetscErrorCode open_stretches(const Uplift *u, PetscInt n, const ProfileRow *rows, PetscInt *n_open,
                                     Stretch *open)
{
  PetscReal reached = 0., closure = 0.;
  Span *span;
  PetscFunctionBeginUser;
  PetscCall(spans_along(u, n, rows, &span));
  *n_open = 0;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *s = span[i].s, *u_n = span[i].u_n;
    if (s[0] > reached + tie_of(u)) add_open(tie_of(u), reached, s[0], &closure, n_open, open);
    reached = PetscMax(reached, s[1]);
    const int first = !!span[i].open[0], last = !!span[i].open[1];
    const PetscReal out = u_n[!first], in = u_n[first],
                    part = first == last         ? first
                           : out > 0. && in < 0. ? out / (out - in)
                                                 : 0.5;
    if (first) add_open(tie_of(u), s[0], s[0] + part * (s[1] - s[0]), &closure, n_open, open);
    for (int k = 0; k < 2; k++)
      if (!span[i].open[k]) closure = PetscMax(closure, -u_n[k]);
    if (last && !first) add_open(tie_of(u), s[1] - part * (s[1] - s[0]), s[1], &closure, n_open, open);
  }
  if (reached < u->length - tie_of(u)) add_open(tie_of(u), reached, u->length, &closure, n_open, open);
  PetscCall(PetscFree(span));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How far the full head reaches: as far as the joint is open from the heel; with reaches: any, to the end of
   the last stretch that does not run out at the toe, where it has the tailwater. */
static PetscReal wet_length(const Load *load, const Uplift *u, PetscInt n, const Stretch *open)
{
  PetscReal wet = 0.;
  for (PetscInt i = 0; i < n; i++) {
    const PetscBool from_heel = (PetscBool)(open[i].from <= tie_of(u)),
                    inside = (PetscBool)(open[i].to < u->length - tie_of(u) &&
                                         open[i].to - open[i].from > load->crack_tolerance);
    if (from_heel || (inside && load->reaches == REACHES_ANY)) wet = open[i].to;
  }
  return wet > u->length - tie_of(u) ? u->length : wet;
}

/* Open stretches that the full head does not reach. */
static void note_dry(const Load *load, PetscReal wet, PetscInt n, const Stretch *open, Uplift *u)
{
  u->n_dry = 0;
  for (PetscInt i = 0; i < n && u->n_dry < UPLIFT_MOST_DRY; i++) {
    if (open[i].from < wet || open[i].to - open[i].from <= load->crack_tolerance || open[i].from <= tie_of(u))
      continue;
    u->dry[u->n_dry++] = (UpliftDry){.from = open[i].from,
                                     .to = open[i].to,
                                     .closed_from = i ? open[i - 1].to : 0.,
                                     .closure = open[i].closure,
                                     .at_toe = (PetscBool)(open[i].to >= u->length - tie_of(u))};
  }
}

/* Collective. Measures the joint of a cracked load as it is now; wet: how far the full head should reach. */
static PetscErrorCode measure(const Problem *p, const Load *load, Uplift *u, PetscReal *wet)
{
  PetscInt n, n_open = 0;
  ProfileRow *rows;
  Stretch *open;
  PetscFunctionBeginUser;
  PetscCall(gather_profile(p->m, p->contacts, u->n_gids, u->gids, &n, &rows));
  PetscCall(PetscMalloc1(3 * n + 1, &open));
  PetscCall(open_stretches(u, n, rows, &n_open, open));
  *wet = wet_length(load, u, n_open, open);
  note_dry(load, *wet, n_open, open, u);
  PetscCall(PetscFree(open));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftSurvey(const Problem *p, PetscBool tell)
{
  PetscReal wet;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < p->stage->n_loads; l++) {
    const Load *load = p->scene->loads + p->stage->loads[l];
    Uplift *u = p->state->uplift + p->stage->loads[l];
    if (load->kind != LOAD_UPLIFT || !load->cracked) continue;
    PetscCall(measure(p, load, u, &wet));
    for (PetscInt i = 0; i < u->n_dry && tell && !p->m->rank; i++) {
      const UpliftDry *d = u->dry + i;
      if (d->at_toe) continue; // the tailwater stands there
      fprintf(
          stderr,
          "quoin: warning: stage %s: %s: the joint is open over %.4g m, from %.4g to %.4g m from the heel, "
          "and "
          "has no full head there: %.3g m before it are closed, by %.3g m at most; reaches: any lets it in\n",
          p->stage->name, load->name, (double)(d->to - d->from), (double)d->from, (double)d->to,
          (double)(d->from - d->closed_from), (double)d->closure);
    }
  }
  fflush(stderr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftStart(const Scene *scene, const Stage *stage, State *state)
{
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    PetscBool acts = PETSC_FALSE;
    for (PetscInt i = 0; i < stage->n_loads; i++) acts = (PetscBool)(acts || stage->loads[i] == l);
    state->uplift[l].rounds = 0;
    if (!acts) state->uplift[l].crack = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftCrack(const Problem *p, PetscBool *again)
{
  StageResult *result = p->result;
  enum { MOST_ROUNDS = 200 };
  const PetscReal through = 0.99; // of the joint: what is left is crushed before it holds
  const PetscBool at_rest = (PetscBool)(result->verdict == VERDICT_CONVERGED);
  PetscReal crack = 0.;
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  for (PetscInt l = 0; l < p->stage->n_loads; l++) {
    const Load *load = p->scene->loads + p->stage->loads[l];
    Uplift *u = p->state->uplift + p->stage->loads[l];
    if (load->kind != LOAD_UPLIFT || !load->cracked) continue;
    PetscCall(measure(p, load, u, &crack));
    const PetscBool runs = (PetscBool)(crack > through * u->length);
    // on the way only growth counts: at rest it may shrink again
    const PetscReal change = at_rest ? PetscAbsReal(crack - u->crack) : crack - u->crack;
    if (!runs && change <= load->crack_tolerance) continue;
    if (runs || u->rounds >= MOST_ROUNDS) {
      result->verdict = runs ? VERDICT_COLLAPSED : VERDICT_UNDECIDED;
      PetscCall(
          PetscSNPrintf(result->evidence, sizeof(result->evidence),
                        "cracked base of %s runs away: open over %.4g m of %.4g m, %.4g m before, after "
                        "%" PetscInt_FMT " rounds",
                        load->name, (double)crack, (double)u->length, (double)u->crack, u->rounds));
      *again = PETSC_FALSE;
      break;
    }
    u->crack = crack, u->rounds++;
    *again = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
