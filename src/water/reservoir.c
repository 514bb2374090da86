/* reservoir.c: applies hydrostatic pressure to faces: of a reservoir, over a crest, of a tailwater, or of
   silt. */
#include "water/water.h"
#include "scene/reader.h"

static const int HALVINGS = 6; /* of a face where the surface of the water or the curve of its pressure is */

void PushOnFace(const PetscReal x[4], PetscReal at, PetscReal push, PetscReal f[4])
{
  const PetscReal ex = x[2] - x[0], ey = x[3] - x[1], N[2] = {1. - at, at};
  for (int k = 0; k < 2; k++) {
    f[2 * k] -= N[k] * push * ey; // outward normal times length: (ey, -ex)
    f[2 * k + 1] += N[k] * push * ex;
  }
}

/* Integrates with two Gauss points: exact, because pressure and shape functions are linear. */
void PushAlongFace(const PetscReal t[2], const PetscReal p[2], const PetscReal x[4], PetscReal thickness,
                   PetscReal f[4])
{
  for (int g = -1; g <= 1; g += 2) {
    const PetscReal w = 0.5 + g * 0.5 / PetscSqrtReal(3.), at = t[0] + w * (t[1] - t[0]);
    PushOnFace(x, at, 0.5 * PetscAbsReal(t[1] - t[0]) * (p[0] + w * (p[1] - p[0])) * thickness, f);
  }
}

/* Integrates with two Gauss points on the wet stretch of the face: exact, because pressure and shape
   functions are linear. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4])
{
  const PetscReal za = level - x[1], zb = level - x[3];
  PetscReal from = 0., to = 1.;
  for (int i = 0; i < 4; i++) f[i] = 0.;
  if (za <= 0. && zb <= 0.) return;
  if (za < 0.) from = za / (za - zb);
  if (zb < 0.) to = za / (za - zb);
  for (int g = -1; g <= 1; g += 2) {
    const PetscReal at = 0.5 * (from + to) + g * 0.5 * (to - from) / PetscSqrtReal(3.);
    PushOnFace(x, at, 0.5 * (to - from) * rho_g * (za + at * (zb - za)) * thickness, f);
  }
}

/* Keeps the force f on the line x of a face, in pieces on each of which it is linear to a small part of
   `whole`, so that a path may cut the face. The resultant and the moment of a piece are exact. halvings: how
   often a piece may still be halved. */
static void keep_pieces(const TermView *v, PetscInt face, PressFace press, const void *context,
                        const PetscReal x[4], const PetscReal f[4], PetscReal whole, int halvings)
{
  const PetscReal middle[2] = {0.5 * (x[0] + x[2]), 0.5 * (x[1] + x[3])};
  const PetscReal half[2][4] = {{x[0], x[1], middle[0], middle[1]}, {middle[0], middle[1], x[2], x[3]}};
  PetscReal of[2][4], off = 0.;
  for (int h = 0; h < 2; h++) {
    press(half[h], context, of[h]);
    for (int i = 0; i < 2; i++) { // a linear force a + b t, t from the end of the face, 1/2 in the middle
      const PetscReal end = f[2 * h + i], other = f[2 - 2 * h + i], a = 4. * end - 2. * other,
                      b = 6. * (other - end);
      off = PetscMax(off, PetscAbsReal(of[h][2 * h + i] - (a / 4. + b / 24.)));
      off = PetscMax(off, PetscAbsReal(of[h][2 - 2 * h + i] - (a / 4. + b / 12.)));
    }
  }
  if (!halvings || off <= 1e-4 * whole)
    LoadOnFaceKeep(v, face, x, f);
  else
    for (int h = 0; h < 2; h++) keep_pieces(v, face, press, context, half[h], of[h], whole, halvings - 1);
}

/* Returns the displacements at which a load meets a face; NULL: it meets the face as drawn. The displacements
   of the inner vertices of condensed bodies are known only at the end of a stage (CondensedRecover), and at a
   correction (condense_large.c). */
static const PetscReal *moved(const TermView *v, PetscInt face)
{
  const Model *m = v->m;
  const PetscInt *at = m->faces.vertex + 2 * face, owned = m->mesh.n_owned;
  if (m->materials.strain != STRAIN_LARGE || v->faces) return NULL;
  if (!m->materials.condensed[m->faces.group[face]]) return v->state->u + 3 * m->rigid.n;
  // the rank of a condensed body owns all its vertices
  return v->state->corrected && at[0] < owned && at[1] < owned ? v->state->corrected + 3 * m->rigid.n : NULL;
}

/* Applies a load to the faces of a set. */
void PressOnFaces(const TermView *v, const char *name, PressFace press, const void *context,
                  PetscReal *f_vertex)
{
  const Model *m = v->m;
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, name, &n);
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt *at = m->faces.vertex + 2 * faces[i];
    if (FaceAbsent(m, faces[i])) continue; // face not built yet: no water
    PetscReal x[4], f[4];
    FaceCoordinates(m, moved(v, faces[i]), faces[i], x);
    press(x, context, f);
    if (v->faces)
      keep_pieces(v, faces[i], press, context, x, f, PetscHypotReal(f[0], f[1]) + PetscHypotReal(f[2], f[3]),
                  HALVINGS);
    for (int k = 0; k < 4; k++)
      if (at[k / 2] < m->mesh.n_owned) f_vertex[2 * at[k / 2] + k % 2] += f[k];
  }
}

PetscErrorCode FacesEnd(const Model *m, const char *name, PetscReal ends[2])
{
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, name, &n);
  PetscReal y[2] = {-PETSC_MAX_REAL, -PETSC_MAX_REAL}; // first value: minus the lowest elevation
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal at = m->mesh.X[2 * m->faces.vertex[2 * faces[i / 2] + i % 2] + 1];
    y[0] = PetscMax(y[0], -at), y[1] = PetscMax(y[1], at);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, y, 2, MPIU_REAL, MPI_MAX, m->comm));
  ends[0] = -y[0], ends[1] = y[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water at rest, or silt, whose horizontal pressure is `lateral` times the vertical one. */
typedef struct {
  PetscReal level, rho_g, thickness, lateral; /* [m], [N/m3], [m], [-] */
} Water;

static void press(const PetscReal x[4], const void *context, PetscReal f[4])
{
  const Water *water = context;
  WaterOnFace(x, water->level, water->rho_g, water->thickness, f);
  f[0] *= water->lateral, f[2] *= water->lateral;
}

/* Returns the elevation [m] of the surface at the faces. An overflow drops by its velocity head on its way
   to the dam; a tailwater is pushed away from it. */
static PetscReal surface_of(const Load *load)
{
  const SurfaceKeys *s = &load->surface;
  if (load->kind == LOAD_OVERFLOW) return load->level - s->velocity_head;
  if (load->kind == LOAD_TAILWATER && s->effective < 1.)
    return s->bottom + s->effective * (load->level - s->bottom);
  return load->level;
}

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f_vertex)
{
  const Load *load = v->scene->loads + row;
  const PetscReal rho_g = load->density * v->scene->gravity;
  const Water water = {surface_of(load), rho_g, v->m->materials.thickness,
                       load->kind == LOAD_SILT ? load->lateral : 1.},
              over = {load->level, load->surface.crest_pressure * rho_g, v->m->materials.thickness, 1.};
  PetscFunctionBeginUser;
  PressOnFaces(v, load->target, press, &water, f_vertex);
  if (load->surface.crest[0]) PressOnFaces(v, load->surface.crest, press, &over, f_vertex);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns how many faces of one set are also in the other. */
static PetscInt shared_faces(const Model *m, const char *one, const char *other)
{
  PetscInt n = 0, n_a, n_b;
  const PetscInt *a = FacesOfSet(m, one, &n_a), *b = FacesOfSet(m, other, &n_b);
  for (PetscInt i = 0; i < n_a; i++)
    for (PetscInt k = 0; k < n_b; k++) n += a[i] == b[k];
  return n;
}

/* Warns of a surface outside the range of the faces. A reservoir or an overflow may stand above its faces. */
static void warn(const Load *load, const PetscReal ends[2])
{
  const PetscReal y = surface_of(load);
  const PetscReal slack = 1e-9 * (ends[1] - ends[0]); // rounding
  if (ends[0] > ends[1]) return;                      // no faces
  if (y < ends[0] - slack)
    Warn("loads.%s: its surface is at %.4g m, the faces of %s begin at %.4g m: it presses "
         "nowhere",
         load->name, (double)y, load->target, (double)ends[0]);
  else if (load->kind == LOAD_OVERFLOW && load->surface.velocity_head > 0. && y < ends[1] - slack)
    Warn("loads.%s: at the dam its surface is at %.4g m, below the top of the faces of %s "
         "at %.4g m: no water runs over them, and none has a velocity_head",
         load->name, (double)y, load->target, (double)ends[1]);
  else if ((load->kind == LOAD_SILT || load->kind == LOAD_TAILWATER) && y > ends[1] + slack)
    Warn("loads.%s: its surface is at %.4g m, the faces of %s end at %.4g m: what is above "
         "them is left out",
         load->name, (double)y, load->target, (double)ends[1]);
}

/* Collective. Refuses an overflow that would press twice on a face. */
static PetscErrorCode create(const TermView *v, void **memory)
{
  const Model *m = v->m;
  char message[MESSAGE_LENGTH] = "", key[LABEL_LENGTH];
  static PetscInt runs; // once, because advise.c sets up the same mesh many times
  const PetscBool warned = AlreadyWarned(&runs);
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  *memory = NULL;
  PetscCallMPI(MPI_Comm_rank(m->comm, &rank));
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    const Load *load = v->scene->loads + l;
    PetscReal ends[2];
    if (!(1u << load->kind & Reservoir_term.loads)) continue;
    PetscCall(FacesEnd(m, load->target, ends));
    if (!rank && !warned) warn(load, ends);
    if (!load->surface.crest[0]) continue;
    const PetscInt n = shared_faces(m, load->target, load->surface.crest);
    PetscCall(PetscSNPrintf(key, sizeof(key), "loads.%s.crest", load->name));
    if (n)
      Complain(message, v->scene->file, load->line, key, "faces of %s are in %s too: expected none",
               load->surface.crest, load->target);
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- keys */

PetscErrorCode CompleteOverflow(Reader *r, const char *path, Load *load)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "crest", &given));
  if (!strcmp(load->surface.crest, load->target))
    COMPLAIN(r, "the face set %s is the upstream face, which has its own pressure: expected another face set",
             load->target);
  PetscCall(IsGiven(r, path, "crest_pressure", &given));
  if (load->surface.crest[0] && !given)
    COMPLAIN_MISSING(r, "missing [-]: the fraction of the static water pressure that acts on the crest");
  if (!load->surface.crest[0] && given) COMPLAIN(r, "there is no crest: give loads.%s.crest", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteTailwater(Reader *r, const char *path, Load *load)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "bottom", &given));
  if (load->surface.effective < 1. && !given)
    COMPLAIN_MISSING(r, "missing [m]: effective is a fraction of the depth above the ground");
  if (given && load->surface.bottom >= load->level)
    COMPLAIN(r, "%g is not below the level %g [m]", (double)load->surface.bottom, (double)load->level);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the lateral pressure coefficient [-] of silt: given, or Rankine's active one from the friction
   [degree]. */
PetscErrorCode CompleteSilt(Reader *r, const char *path, Load *load)
{
  const PetscReal angle = load->rest_angle * PETSC_PI / 180.;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "lateral", &given));
  if (isnan(load->lateral) == isnan(load->rest_angle))
    COMPLAIN_MISSING(r, "silt needs lateral [-] or friction [degree], one of them");
  if (isnan(load->lateral)) load->lateral = (1. - sin(angle)) / (1. + sin(angle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Reservoir_term = {.name = "reservoir",
                                 .loads = 1u << LOAD_RESERVOIR | 1u << LOAD_SILT | 1u << LOAD_OVERFLOW |
                                          1u << LOAD_TAILWATER,
                                 .presses = PETSC_TRUE,
                                 .create = create,
                                 .applied = applied};
