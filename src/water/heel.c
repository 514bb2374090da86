/* heel.c: decides which end of a joint is its heel, from the waters. The heel is where the water with the
   level of the uplift stands, the toe where its tailwater stands.

   The side of a water is decided along the chord of the joint, from start (left, or lower) to end:
     1. if the mean of its wet faces lies before the start or beyond the end, the water is at that end;
     2. else, if it pushes the faces clearly to one side and the joint is not upright, the water is at the
        end from which it pushes;
     3. else it is at the end that is clearly nearer to its wet faces; else the side is undecided.
   assess/heel.py has the same rules. */
#include "contacts/contacts.h"
#include "water/water.h"

/* A face of a set in the mesh. */
typedef struct {
  PetscInt gid;
  PetscReal x[4]; /* [m] */
} WetFace;

/* Collective. Gathers the faces of a set on all ranks, each once, ascending. */
static PetscErrorCode gather_faces(const Model *m, const char *name, PetscInt *n, WetFace **faces)
{
  const PetscInt set = NameRow(m->mesh.n_face_sets, m->mesh.face_set_names, name);
  PetscInt n_all = 0, n_mine = 0;
  WetFace *mine;
  PetscFunctionBeginUser;
  PetscCheck(set >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no set of faces has the name '%s'", name);
  PetscCall(PetscCalloc1(m->mesh.face_set_start[set + 1] - m->mesh.face_set_start[set] + 1, &mine));
  for (PetscInt i = m->mesh.face_set_start[set]; i < m->mesh.face_set_start[set + 1]; i++) {
    const PetscInt face = m->mesh.face_set_faces[i];
    mine[n_mine].gid = m->faces.gid[face];
    FaceCoordinates(m, NULL, face, mine[n_mine++].x);
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(WetFace), mine, OrderByFirst, &n_all, (void **)faces));
  *n = 0;
  for (PetscInt i = 0; i < n_all; i++)
    if (!i || (*faces)[i].gid != (*faces)[*n - 1].gid) (*faces)[(*n)++] = (*faces)[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts a face at the water's surface. Returns false if it is dry. */
static PetscBool below(PetscReal level, PetscReal x[4])
{
  const PetscReal depth[2] = {level - x[1], level - x[3]};
  if (!(depth[0] > 0. || depth[1] > 0.)) return PETSC_FALSE;
  for (int k = 0; k < 2; k++) {
    if (depth[k] >= 0.) continue;
    const PetscReal t = depth[1 - k] / (depth[1 - k] - depth[k]); // from the wet end
    for (int i = 0; i < 2; i++) x[2 * k + i] = x[2 * (1 - k) + i] + t * (x[2 * k + i] - x[2 * (1 - k) + i]);
  }
  return PETSC_TRUE;
}

/* Returns the distance [m] of a point from a face. */
static PetscReal distance_of(const PetscReal P[2], const PetscReal x[4])
{
  const PetscReal e[2] = {x[2] - x[0], x[3] - x[1]}, d[2] = {P[0] - x[0], P[1] - x[1]},
                  square = e[0] * e[0] + e[1] * e[1];
  const PetscReal t = square > 0. ? PetscClipInterval((d[0] * e[0] + d[1] * e[1]) / square, 0., 1.) : 0.;
  return PetscHypotReal(d[0] - t * e[0], d[1] - t * e[1]);
}

int WaterSide(PetscInt n, const PetscReal *faces, PetscReal level, const PetscReal ends[4])
{
  const PetscReal e[2] = {ends[2] - ends[0], ends[3] - ends[1]}, L = PetscHypotReal(e[0], e[1]);
  const PetscReal near = 0.1 * L;
  PetscReal push[2] = {0., 0.}, sideways = 0., wet = 0., place = 0.,
            far[2] = {PETSC_INFINITY, PETSC_INFINITY};
  for (PetscInt i = 0; i < n; i++) {
    PetscReal x[4];
    for (int k = 0; k < 4; k++) x[k] = faces[4 * i + k];
    if (!below(level, x)) continue;
    const PetscReal along[2] = {x[2] - x[0], x[3] - x[1]}, length = PetscHypotReal(along[0], along[1]);
    const PetscReal middle[2] = {0.5 * (x[0] + x[2]), 0.5 * (x[1] + x[3])}, depth = level - middle[1];
    push[0] -= depth * along[1], push[1] += depth * along[0]; // inward normal times length
    sideways += PetscAbsReal(depth * along[1]);
    wet += length;
    place += length * ((middle[0] - ends[0]) * e[0] + (middle[1] - ends[1]) * e[1]) / L;
    for (int k = 0; k < 2; k++) far[k] = PetscMin(far[k], distance_of(ends + 2 * k, x));
  }
  if (!(wet > 0.)) return -1;
  if (place < -1e-6 * L * wet) return 0;
  if (place > (1. + 1e-6) * L * wet) return 1;
  if (PetscAbsReal(e[0]) > near && PetscAbsReal(push[0]) > 0.5 * sideways &&
      PetscAbsReal(push[0]) > 0.1 * PetscAbsReal(push[1]))
    return (push[0] > 0.) == (e[0] > 0.) ? 0 : 1;
  if (PetscAbsReal(far[0] - far[1]) < near) return -1;
  return far[0] < far[1] ? 0 : 1;
}

/* The highest water at each end of a joint. */
typedef struct {
  PetscInt load[2];   /* -1: none */
  PetscReal level[2]; /* [m] */
} EndWaters;

static PetscBool is_water(const Load *joint, const Load *water)
{
  return (PetscBool)(water->kind == LOAD_RESERVOIR || water->kind == LOAD_OVERFLOW ||
                     water->kind == LOAD_TAILWATER ||
                     (water->kind == LOAD_HEAD && joint->kind == LOAD_DRAIN));
}

/* Returns the difference [m] between the heads of the waters and the heads of the uplift, if its heel is this
   end. For a drain, which has no level, it is the head of the water at the other end. */
static PetscReal missed(const Load *load, const PetscReal ends[4], const EndWaters *w, int heel)
{
  const PetscReal tail = load->kind == LOAD_UPLIFT ? load->uplift.tailwater : NAN;
  PetscReal sum = 0.;
  for (int k = 0; k < 2; k++) {
    const PetscReal y = ends[2 * k + 1], want = k == heel ? load->level : tail;
    const PetscReal head = w->load[k] >= 0 && w->level[k] > y ? w->level[k] - y : 0.;
    if (load->kind == LOAD_DRAIN) {
      if (k != heel) sum += head;
    } else if (w->load[k] >= 0) {
      sum += PetscAbsReal(head - (want > y ? want - y : 0.));
    }
  }
  return sum;
}

/* Finds the highest waters at both ends that act together with the load in a stage. side: (n_loads,) of
   each load. */
static void waters_of(const Scene *scene, const Load *load, const Stage *stage, const int *side, EndWaters *w)
{
  w->load[0] = w->load[1] = -1;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const PetscInt l = stage->loads[i];
    if (l < 0 || side[l] < 0 || !is_water(load, scene->loads + l)) continue;
    if (w->load[side[l]] >= 0 && w->level[side[l]] >= scene->loads[l].level) continue;
    w->load[side[l]] = l, w->level[side[l]] = scene->loads[l].level;
  }
}

static PetscBool acts(const Stage *stage, PetscInt load)
{
  for (PetscInt i = 0; i < stage->n_loads; i++)
    if (stage->loads[i] == load) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Writes a message: the waters of a stage contradict the heel. */
static void contradict(const Scene *scene, const Load *load, const Stage *stage, const PetscReal ends[4],
                       const EndWaters *w, UpliftHeel heel, UpliftHeel found, char message[MESSAGE_LENGTH])
{
  const int k = found == HEEL_END, other = w->load[k] < 0; // name the water at the toe if there is no other
  const Load *water = scene->loads + w->load[other ? 1 - k : k];
  const int at = other ? 1 - k : k;
  char where[64] = "";
  if (load->line) snprintf(where, sizeof where, ":%d", load->line);
  PetscCallAbort(PETSC_COMM_SELF,
                 PetscSNPrintf(message, MESSAGE_LENGTH,
                               "%s%s: loads.%s.heel: %s is the end at (%.6g, %.6g) m, but in stage %s the "
                               "water of loads.%s, at the "
                               "level %.6g m, stands at (%.6g, %.6g) m: expected %s",
                               scene->file, where, load->name, heel == HEEL_END ? "end" : "start",
                               (double)(ends[heel == HEEL_END ? 2 : 0] + 0.),
                               (double)(ends[heel == HEEL_END ? 3 : 1] + 0.), stage->name, water->name,
                               (double)water->level, (double)(ends[2 * at] + 0.),
                               (double)(ends[2 * at + 1] + 0.),
                               load->uplift.heel != HEEL_AUTO
                                   ? found == HEEL_END ? "end" : "start"
                                   : "a load of its own for each side on which the water stands"));
}

PetscErrorCode JointEnds(const Model *m, const char *set, PetscReal ends[4])
{
  PetscReal mean[2] = {0., 0.}, xx = 0., xy = 0., yy = 0., e[2], low = PETSC_INFINITY, high = PETSC_NINFINITY;
  WetFace *faces;
  PetscInt n;
  PetscFunctionBeginUser;
  for (int k = 0; k < 4; k++) ends[k] = 0.;
  PetscCall(gather_faces(m, set, &n, &faces));
  for (PetscInt i = 0; i < 4 * n; i++) mean[i % 2] += faces[i / 4].x[i % 4] / (2. * n);
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal *P = faces[i / 2].x + 2 * (i % 2), dx = P[0] - mean[0], dy = P[1] - mean[1];
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  JointDirection(xx, xy, yy, e);
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscReal *P = faces[i / 2].x + 2 * (i % 2), at = P[0] * e[0] + P[1] * e[1];
    if (at < low) low = at, ends[0] = P[0], ends[1] = P[1];
    if (at > high) high = at, ends[2] = P[0], ends[3] = P[1];
  }
  PetscCall(PetscFree(faces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HeelOf(const Scene *scene, const Model *m, PetscInt row, const PetscReal ends[4],
                      PetscBool *at_end, char message[MESSAGE_LENGTH])
{
  const Load *load = scene->loads + row;
  UpliftHeel heel = load->uplift.heel;
  int *side;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(scene->n_loads, &side));
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    WetFace *faces;
    PetscReal *x;
    PetscInt n;
    side[l] = -1;
    if (!is_water(load, scene->loads + l)) continue;
    PetscCall(gather_faces(m, scene->loads[l].target, &n, &faces));
    PetscCall(PetscMalloc1(4 * n + 1, &x));
    for (PetscInt i = 0; i < 4 * n; i++) x[i] = faces[i / 4].x[i % 4];
    side[l] = WaterSide(n, x, scene->loads[l].level, ends);
    PetscCall(PetscFree(x));
    PetscCall(PetscFree(faces));
  }
  for (const Stage *stage = scene->stages; stage < scene->stages + scene->n_stages && !message[0]; stage++) {
    EndWaters w;
    if (!acts(stage, row)) continue;
    waters_of(scene, load, stage, side, &w);
    if (w.load[0] < 0 && w.load[1] < 0) continue;
    const PetscReal miss[2] = {missed(load, ends, &w, 0), missed(load, ends, &w, 1)};
    if (PetscAbsReal(miss[0] - miss[1]) <= 1e-9 * (miss[0] + miss[1])) continue;
    const UpliftHeel found = miss[0] < miss[1] ? HEEL_START : HEEL_END;
    const PetscBool sure = (PetscBool)(PetscMin(miss[0], miss[1]) <= 0.25 * PetscMax(miss[0], miss[1]));
    if (heel == HEEL_AUTO)
      heel = found;
    else if (found != heel && sure)
      contradict(scene, load, stage, ends, &w, heel, found, message);
  }
  PetscCall(PetscFree(side));
  *at_end = (PetscBool)(heel == HEEL_END);
  PetscFunctionReturn(PETSC_SUCCESS);
}
