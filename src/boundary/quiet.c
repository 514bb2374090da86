/* quiet.c: releases supports whose boundary is quiet or a free field in dynamic stages, and adds dashpots
   that let waves out. The motion of free fields is in free_field.c.

   In static stages these supports hold. When a dynamic stage follows, they are released and their
   reactions stay as forces, so the release causes no motion. Dashpots rho c_p along the normal of a face
   and rho c_s along the face absorb waves from within. A motion is that of the free surface far away
   (outcrop), or of the incident wave, which is half of it: C (2 v_in - v) is the force on the model. In a
   later static stage supports hold the ground where it is. */
#include "boundary/boundary.h"
#include "base/lanes.h"

/* A vertex through which waves of a support enter. */
typedef struct {
  PetscInt vertex;
  Pair share[2]; /* share in the velocity of all dashpots of the vertex: C_all^-1 C_support, by columns */
} QuietVertex;

typedef struct {
  PetscInt n_supports;
  Motion *motion;      /* (n_supports,) */
  PetscReal *times;    /* [-] (n_supports,) GroundPart */
  PetscBool *held;     /* (n_dof,) held in static stages by a support that is released in dynamic stages */
  PetscReal *reaction; /* [N] (n_dof,) reactions kept since the release; 0 elsewhere */
  PetscBool released_now;
  /* of the current dynamic stage */
  PetscInt n_released, *released; /* (n_released,) released degrees of freedom */
  PetscInt *start;                /* (n_supports + 1,) support i: at[start[i]] .. at[start[i + 1] - 1] */
  QuietVertex *at;                /* on this rank, where waves enter */
} Quiet;

static PetscBool is_quiet(const Support *s)
{
  return (PetscBool)(s->boundary == BOUNDARY_QUIET);
}

/* Decides whether a support holds in static stages only. */
static PetscBool is_released(const Support *s)
{
  return (PetscBool)(s->boundary != BOUNDARY_FIXED);
}

/* ---- set-up */

PetscInt HalfSpaceOf(const Model *m, const Support *s)
{
  return s->half_space[0] ? NameRow(m->materials.n_groups, m->materials.names, s->half_space) : -1;
}

static const char *const Expected = "expected faces of blocks that deform, with density > 0";

/* Refuses a support without suitable faces, on this rank. */
static PetscErrorCode check_target(const Scene *scene, const Model *m, const Support *s, char *message)
{
  const PetscInt set = NameRow(m->mesh.n_face_sets, m->mesh.face_set_names, s->target);
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, s->target, &n);
  const char *boundary = is_quiet(s) ? "quiet" : "free_field";
  const PetscInt behind = HalfSpaceOf(m, s);
  PetscFunctionBeginUser;
  if (behind >= 0 && (m->materials.rigid[behind] || !(m->materials.density[behind] > 0.)))
    PetscCall(
        PetscSNPrintf(message, MESSAGE_LENGTH,
                      "%s: supports.%s.half_space: group %s is rigid or has no density: expected ground "
                      "that deforms, with density > 0",
                      scene->file, s->name, s->half_space));
  if (set < 0)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: supports.%s.boundary: %s: \"%s\" is no face set: %s", scene->file, s->name,
                            boundary, s->target, Expected));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt group = m->faces.group[faces[i]];
    if (!m->materials.rigid[group] && m->materials.density[group] > 0.) continue;
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: supports.%s.boundary: %s: a face of \"%s\" belongs to group %s: %s",
                            scene->file, s->name, boundary, s->target, m->materials.names[group], Expected));
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether each load of a stage is also in the other. other NULL: no loads. */
static PetscBool within(const Scene *scene, const Stage *stage, const Stage *other)
{
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    PetscBool found = PETSC_FALSE;
    if (scene->loads[stage->loads[i]].kind == LOAD_ADDED_MASS) continue;
    for (PetscInt j = 0; other && j < other->n_loads; j++)
      if (other->loads[j] == stage->loads[i]) found = PETSC_TRUE;
    if (!found) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Decides whether two stages have the same loads, in any order. before NULL: none. */
static PetscBool same_loads(const Scene *scene, const Stage *stage, const Stage *before)
{
  return (PetscBool)(within(scene, stage, before) && (!before || within(scene, before, stage)));
}

/* Decides whether a stage ends with other loads than the scene gives it. */
static PetscBool leaves_changed(const Scene *scene, const Stage *stage)
{
  if (stage->kind == STAGE_FLOOD || stage->kind == STAGE_LOAD_FACTOR) return PETSC_TRUE;
  for (PetscInt i = 0; stage->kind == STAGE_TRANSIENT && i < stage->n_loads; i++)
    if (scene->loads[stage->loads[i]].levels[0]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Refuses a dynamic stage with new loads. Released ground cannot carry them: a pressure p moves all of it
   at p / (rho c). */
static PetscErrorCode check_loads(const Scene *scene, char *message)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_stages; i++) {
    const Stage *stage = scene->stages + i, *before = StageBefore(scene, stage);
    const PetscBool changed = (PetscBool)(before && leaves_changed(scene, before));
    if (!StageInTime(stage) || (!changed && same_loads(scene, stage, before))) continue;
    const char *where = changed ? "not those at the end of the stage before"
                                : "not those of the stage before",
               *wanted = changed ? "a static stage between them" : "the same loads";
    PetscCall(
        PetscSNPrintf(message, MESSAGE_LENGTH,
                      "%s: stages.%s.loads: %s: ground that lets waves out would give way to what is added; "
                      "expected %s",
                      scene->file, stage->name, before ? where : "no stage runs before this one",
                      before ? wanted : "a static stage with these loads before it"));
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses incident waves together with a moving fixed support: these would be two earthquakes. */
static PetscErrorCode check_motions(const Scene *scene, char *message)
{
  const Support *waves = NULL, *moved = NULL;
  PetscFunctionBeginUser;
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    if (!s->motion[0]) continue;
    if (is_quiet(s))
      waves = s;
    else
      moved = s;
  }
  if (waves && moved)
    PetscCall(
        PetscSNPrintf(message, MESSAGE_LENGTH,
                      "%s: supports.%s.motion: a fixed support is moved, while waves come in through %s: "
                      "expected one of them",
                      scene->file, moved->name, waves->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  const Scene *scene = v->scene;
  char message[MESSAGE_LENGTH] = "";
  PetscBool any = PETSC_FALSE;
  Quiet *q;
  PetscFunctionBeginUser;
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports && !message[0]; s++) {
    if (!is_released(s)) continue;
    any = PETSC_TRUE;
    PetscCall(check_target(scene, v->m, s, message));
  }
  if (any && !message[0]) PetscCall(check_loads(scene, message));
  if (any && !message[0]) PetscCall(check_motions(scene, message));
  PetscCall(CheckMessage(v->m->comm, message));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&q));
  q->n_supports = scene->n_supports;
  PetscCall(PetscCalloc1(scene->n_supports + 1, &q->start));
  PetscCall(PetscCalloc1(scene->n_supports, &q->motion));
  PetscCall(PetscCalloc1(scene->n_supports, &q->times));
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    const Support *s = scene->supports + i;
    if (is_quiet(s)) PetscCall(MotionCreate(s, q->motion + i));
    q->times[i] = GroundPart(s);
  }
  PetscCall(PetscCalloc1(v->m->n_dof, &q->reaction));
  PetscCall(PetscMalloc1(v->m->n_dof, &q->held));
  for (PetscInt d = 0; d < v->m->n_dof; d++)
    q->held[d] = (PetscBool)(SupportRow(v->m, d) >= 0 && is_released(scene->supports + v->m->support[d]));
  *memory = q;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  Quiet *q = *memory;
  PetscFunctionBeginUser;
  if (!q) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < scene->n_supports; i++) PetscCall(MotionDestroy(q->motion + i));
  PetscCall(PetscFree(q->motion));
  PetscCall(PetscFree(q->times));
  PetscCall(PetscFree(q->held));
  PetscCall(PetscFree(q->reaction));
  PetscCall(PetscFree(q->released));
  PetscCall(PetscFree(q->start));
  PetscCall(PetscFree(q->at));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stages */

/* Computes the dashpots [N s/m] of half a face at one of its vertices. group: of the ground behind the
   face. */
static void half_face(const Model *m, PetscInt face, PetscInt group, PetscReal C[2][2])
{
  const PetscInt *v = m->faces.vertex + 2 * face;
  const PetscReal ex = m->mesh.X[2 * v[1]] - m->mesh.X[2 * v[0]],
                  ey = m->mesh.X[2 * v[1] + 1] - m->mesh.X[2 * v[0] + 1];
  const PetscReal length = PetscHypotReal(ex, ey), s[2] = {ex / length, ey / length}, n[2] = {s[1], -s[0]};
  const PetscReal half = 0.5 * length * m->materials.thickness, rho = m->materials.density[group];
  const Lame lame = m->materials.lame[group];
  const PetscReal along = half * PetscSqrtReal(rho * lame.mu),
                  across = half * PetscSqrtReal(rho * (lame.lambda + 2. * lame.mu));
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) C[i][j] = across * n[i] * n[j] + along * s[i] * s[j];
}

void QuietDashpots(const Scene *scene, const Model *m, const Support *only, PetscReal (*sum)[2])
{
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    if (!is_released(s) || (only && s != only)) continue;
    PetscInt n;
    const PetscInt *faces = FacesOfSet(m, s->target, &n), behind = HalfSpaceOf(m, s);
    for (PetscInt i = 0; i < n; i++) {
      const PetscInt face = faces[i];
      PetscReal C[2][2];
      half_face(m, face, behind < 0 ? m->faces.group[face] : behind, C);
      for (int k = 0; k < 2; k++) {
        const PetscInt v = m->faces.vertex[2 * face + k];
        for (int x = 0; x < 4 && v < m->mesh.n_deformable; x++) sum[2 * v + x / 2][x % 2] += C[x / 2][x % 2];
      }
    }
  }
}

/* Returns column j of C_all^-1 C. */
static Pair share_of(PetscReal (*all)[2], PetscReal (*C)[2], int j)
{
  const PetscReal det = all[0][0] * all[1][1] - all[0][1] * all[1][0];
  return (Pair){(all[1][1] * C[0][j] - all[0][1] * C[1][j]) / det,
                (all[0][0] * C[1][j] - all[1][0] * C[0][j]) / det};
}

static PetscBool lets_waves_in(const Scene *scene, const Quiet *q, PetscInt support)
{
  return (PetscBool)(is_quiet(scene->supports + support) && MotionMoves(q->motion + support));
}

/* Allocates one vertex per end of a face, which is enough. */
static PetscErrorCode make_room(const Scene *scene, const Model *m, Quiet *q)
{
  PetscInt most = 0, n;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    if (!lets_waves_in(scene, q, i)) continue;
    (void)FacesOfSet(m, scene->supports[i].target, &n);
    most += 2 * n;
  }
  PetscCall(PetscFree(q->at));
  PetscCall(PetscMalloc1(most, &q->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the vertices through which waves enter. */
static PetscErrorCode find_inlets(const Scene *scene, const Model *m, PetscReal (*all)[2], Quiet *q)
{
  PetscReal(*own)[2];
  PetscInt n = 0;
  PetscFunctionBeginUser;
  PetscCall(make_room(scene, m, q));
  PetscCall(PetscMalloc1(2 * m->mesh.n_deformable, &own));
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    q->start[i] = n;
    if (!lets_waves_in(scene, q, i)) continue;
    PetscCall(PetscMemzero(own, 2 * m->mesh.n_deformable * sizeof *own));
    QuietDashpots(scene, m, scene->supports + i, own);
    for (PetscInt v = 0; v < m->mesh.n_deformable; v++) {
      if (own[2 * v][0] == 0. && own[2 * v + 1][1] == 0.) continue;
      q->at[n++] = (QuietVertex){
          v, {share_of(all + 2 * v, own + 2 * v, 0), share_of(all + 2 * v, own + 2 * v, 1)}};
    }
  }
  q->start[scene->n_supports] = n;
  PetscCall(PetscFree(own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the released degrees of freedom. */
static PetscErrorCode find_released(const Model *m, Quiet *q)
{
  const PetscInt end = 3 * m->rigid.n + 2 * m->mesh.n_deformable;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (int fill = 0; fill < 2; fill++) {
    if (fill) {
      PetscCall(PetscFree(q->released));
      PetscCall(PetscMalloc1(n, &q->released));
      n = 0;
    }
    for (PetscInt d = 3 * m->rigid.n; d < end; d++) {
      if (!q->held[d] || Held(m, d)) continue;
      if (fill) q->released[n] = d;
      n++;
    }
  }
  q->n_released = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode inertia(const TermView *view, TermInertia add, void *context)
{
  const Model *m = view->m;
  PetscReal(*all)[2];
  PetscFunctionBeginUser;
  if (!view->memory) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(2 * m->mesh.n_deformable, &all));
  QuietDashpots(view->scene, m, NULL, all);
  for (PetscInt v = 0; v < m->mesh.n_deformable; v++)
    if (all[2 * v][0] > 0. || all[2 * v + 1][1] > 0.) PetscCall(add(1, &v, NULL, all[2 * v], context));
  PetscCall(find_inlets(view->scene, m, all, view->memory));
  PetscCall(find_released(m, view->memory));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the reactions of the supports just released. */
static void keep_reactions(const TermView *v, Quiet *q)
{
  memset(q->reaction, 0, v->m->n_dof * sizeof *q->reaction);
  for (PetscInt i = 0; i < q->n_released; i++) {
    const PetscInt d = q->released[i];
    q->reaction[d] = v->state->f[d] - v->state->f_ext[d];
  }
}

static PetscErrorCode begin(const TermView *v)
{
  Quiet *q = v->memory;
  PetscFunctionBeginUser;
  if (!q) PetscFunctionReturn(PETSC_SUCCESS);
  if (!StageInTime(v->stage)) q->released_now = PETSC_FALSE;
  if (!StageInTime(v->stage) || q->released_now) PetscFunctionReturn(PETSC_SUCCESS);
  keep_reactions(v, q);
  q->released_now = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void incoming(void *memory, const Model *m, const State *s, Incoming *in)
{
  const Quiet *q = memory;
  if (!q) return;
  for (const PetscInt *d = q->released; d < q->released + q->n_released; d++)
    in->push[*d - 3 * m->rigid.n] += q->reaction[*d];
  for (PetscInt i = 0; i < q->n_supports; i++) {
    if (q->start[i] == q->start[i + 1]) continue;
    const PetscReal from = s->time - 0.5 * s->dt,
                    to = s->time + 0.5 * s->dt; // the step centred at the present time
    const PetscReal vx = q->times[i] * MotionMean(q->motion + i, from, to, s->dt, 0),
                    vy = q->times[i] * MotionMean(q->motion + i, from, to, s->dt, 1);
    for (const QuietVertex *at = q->at + q->start[i]; at < q->at + q->start[i + 1]; at++) {
      const Pair w = at->share[0] * vx + at->share[1] * vy;
      PetscReal *all = in->w + 2 * at->vertex, *wave = in->wave + 2 * at->vertex;
      StorePair(all, LoadPair(all) + w);
      StorePair(wave, LoadPair(wave) + 0.5 * w);
    }
  }
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  Quiet *q = v->memory;
  PetscFunctionBeginUser;
  if (!q) PetscFunctionReturn(PETSC_SUCCESS);
  PetscInt released_now = q->released_now;
  PetscCall(ArchiveInts(a, "quiet_let_go", 1, &released_now));
  q->released_now = (PetscBool)released_now;
  PetscCall(ArchiveDofs(a, v->m, "quiet_reaction", q->reaction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Quiet_term = {.name = "quiet",
                             .create = create,
                             .destroy = destroy,
                             .inertia = inertia,
                             .incoming = incoming,
                             .begin = begin,
                             .archive = archive};
